"""The oracle's plans that come with the package, as a controller of the held-out grounds."""

from __future__ import annotations

import gzip
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import Seen
from twin.errors import BadInput

Array = NDArray[np.float64]

KNOT_S = 0.5
"""Time between two knots of a plan [s]."""
DURATION_S = 20.0
"""How long the shipped plans are [s]."""
FOLDER = Path(__file__).parent / "oracles"


@dataclass(frozen=True)
class Plans:
    """Open-loop plans, one for each held-out ground in the order of the seeds: a `Controller`."""

    knots: Array
    """Actions (grounds, knots, actions)."""

    def init(self, count: int) -> float:
        """The time [s]. Raises BadInput for more tractors than grounds were planned."""
        if count > len(self.knots):
            raise BadInput(
                f"the oracle's plans are of {len(self.knots)} held-out grounds, not of {count}; "
                f"--episodes {len(self.knots)} would do"
            )
        return 0.0

    def act(self, state: float, seen: Seen, period_s: float) -> tuple[float, Array]:
        """The plans' actions now; after their end, the last."""
        count = len(next(iter(seen.values())))
        return state + period_s, between(self.knots[:count], state)


def between(knots: Array, time_s: float) -> Array:
    """Actions at a time, linear between the knots (count, actions).

    Args:
        knots: (count, knots, actions).
        time_s: since the start of the episode.
    """
    place = min(time_s / KNOT_S, knots.shape[1] - 1.0)
    i = min(int(place), knots.shape[1] - 2)
    share = place - i
    return np.asarray((1.0 - share) * knots[:, i] + share * knots[:, i + 1])


def shipped(environment: str) -> Plans | None:
    """The plans that come with the package; None for an environment without."""
    file = FOLDER / f"{environment}.json.gz"
    if not file.is_file():
        return None
    held: Any = json.loads(gzip.decompress(file.read_bytes()))
    return Plans(np.array(held["knots"], dtype=np.float64))
