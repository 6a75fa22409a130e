"""Which samples are scored, and by what was driven there: work, turn or road."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.streams import Table
from twin.trajectory.phase import Phase

Array = NDArray[np.float64]

SCORED = {"work": Phase.WORK, "turn": Phase.TURN, "road": Phase.ROAD}
"""Phases that are scored apart, by name; a stop is none of them."""
DRIVING_MPS = 0.3
"""A slip is scored where the ground or the wheels are at least so fast [m/s]: below it the noise of
a receiver, 0.03 m/s, alone makes 10 points of slip."""
TURN_RADIUS_M = 25.0
"""A narrower curve is a turn [m], as in `twin.logs.activity`."""
LOWERED_SHARE, LOWERED_M = 0.5, 0.03
"""Above this share of its greatest depth, and this depth [m], an implement works."""


@dataclass(frozen=True)
class Phases:
    """What was driven when."""

    epoch_ns: NDArray[np.int64]
    """Shape (n,), ascending."""
    code: NDArray[np.int64]
    """A Phase from that instant on. Shape (n,)."""
    rule: str
    """The rule that found the phases, in words."""

    def at(self, epoch_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """The phase at other epochs; before the first it is the first's."""
        before = np.searchsorted(self.epoch_ns, epoch_ns, side="right") - 1
        return np.asarray(self.code[np.maximum(before, 0)])


def phases(truth: Table) -> Phases | None:
    """The driver's own phases where the truth has them, else by a rule; None without a speed.

    Work: deeper than half of the greatest depth, and than 3 cm. Turn: a curve narrower than 25 m,
    |yaw rate| 25 m > |v|, not at work. Stop: slower than 0.3 m/s. All else is road.
    """
    if not len(truth["epoch_ns"]):
        return None
    if "phase" in truth:
        return Phases(truth["epoch_ns"], truth["phase"], "phases are the driver's own")
    if "speed_mps" not in truth:
        return None
    nothing = np.zeros(len(truth["epoch_ns"]))
    depth, turned = truth.get("depth_m", nothing), truth.get("yaw_rate_radps", nothing)
    with np.errstate(invalid="ignore"):
        deepest = float(np.nanmax(depth)) if np.isfinite(depth).any() else 0.0
        works = depth > max(LOWERED_SHARE * deepest, LOWERED_M)
        turns = np.abs(turned) * TURN_RADIUS_M > np.abs(truth["speed_mps"])
        drives = speed_mps(truth) >= DRIVING_MPS
    code = np.select([~drives, works, turns], [Phase.STOP, Phase.WORK, Phase.TURN], Phase.ROAD)
    rule = (
        f"work is deeper than half of the greatest depth and than {100 * LOWERED_M:g} cm; turn is a"
        f" curve narrower than {TURN_RADIUS_M:g} m; stop is slower than {DRIVING_MPS:g} m/s; all"
        " else is road"
    )
    return Phases(truth["epoch_ns"], code.astype(np.int64), rule)


def speed_mps(truth: Table) -> Array:
    """The faster of ground and driven wheels [m/s]; NaN where neither is known. Shape (n,)."""
    unknown = np.full(len(truth["epoch_ns"]), np.nan)
    both = (np.abs(truth.get(name, unknown)) for name in ("speed_mps", "wheel_speed_mps"))
    fastest: Array = np.fmax(*both)
    return fastest
