"""The part of a log that is learnt from, the part that is held out, and their blocks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.plugins.percent import MOVING_MPS
from twin.streams import Streams

Epochs = NDArray[np.int64]

BLOCKS = 20
"""Blocks of each part of a log, by which intervals are made."""
LEAST_S, LEAST_INNOVATIONS = 30.0, 300
"""Least time of driving [s] and least number of innovations in each of the two parts."""
GAP_S = 3.0
"""Between innovations further apart than this nothing was driven [s]."""


def parts(name: str, epoch_ns: Epochs, learn_share: float) -> tuple[Epochs, Epochs]:
    """Edges of the blocks of both parts of a log, each block with as many innovations.

    Args:
        name: what messages call the estimator.
        epoch_ns: of its innovations.
        learn_share: of them, the first that are learnt from.

    Raises:
        BadInput: there are too few, or in too little time.
    """
    epoch_ns = np.sort(epoch_ns)
    if not len(epoch_ns):
        raise BadInput(
            f"the log gives estimator '{name}' no innovations while driving above {MOVING_MPS:g} "
            "m/s; wheel speeds and GNSS speed are needed"
        )
    middle = int(learn_share * len(epoch_ns))
    edges = []
    for what, part in (("to learn from", epoch_ns[:middle]), ("held out", epoch_ns[middle:])):
        if driven_s(part) < LEAST_S or len(part) < LEAST_INNOVATIONS:
            raise BadInput(
                f"the part of the log {what} has {driven_s(part):.0f} s of driving and "
                f"{len(part)} measurements of '{name}'; {LEAST_S:.0f} s and {LEAST_INNOVATIONS} "
                "are needed"
            )
        at = np.linspace(0, len(part) - 1, BLOCKS + 1).astype(np.int64)
        edges.append(part[at] + (at == len(part) - 1))
    return edges[0], edges[1]


def driven_s(epoch_ns: Epochs) -> float:
    """Time of driving [s], from the epochs of innovations in order; gaps are left out."""
    step_s = np.diff(epoch_ns) * 1e-9
    return float(step_s[step_s < GAP_S].sum())


def until(streams: Streams, stop_ns: int) -> Streams:
    """The samples that arrived before an instant."""
    return Streams({
        sensor: {k: v[: np.searchsorted(table["arrival_ns"], stop_ns)] for k, v in table.items()}
        for sensor, table in streams.tables.items()
    })  # fmt: skip


def between(epoch_ns: Epochs, edges_ns: Epochs) -> Epochs:
    """The epochs between the first and the last edge, in order."""
    return np.sort(epoch_ns[(epoch_ns >= edges_ns[0]) & (epoch_ns < edges_ns[-1])])
