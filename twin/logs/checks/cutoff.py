"""Wheels whose speed reads zero below a cut-off: that they stand is not known then."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

MOVING_MPS = 0.4
"""Ground speed at which wheels that read zero do not stand: eight of a receiver's sd, and more than
its lag makes of a usual stop (0.3 s at 1 m/s2)."""


def unknown(wheel_mps: Array, ground_mps: Array) -> NDArray[np.bool_]:
    """Which wheel speeds read exactly zero while the ground moves, shape (n,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray((wheel_mps == 0.0) & (ground_mps > MOVING_MPS))
