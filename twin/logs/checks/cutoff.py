"""Wheels whose speed reads zero below a cut-off: that they stand is not known then."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array

MOVING_MPS = 0.4
"""Ground speed at which wheels that read zero do not stand: eight of a receiver's sd, and more than
its lag gives at a usual stop (0.3 s at 1 m/s2)."""


CREEPING_MPS, CREEPING_S = 0.15, 5.0
"""Or this much, three of a receiver's sd, for so long on end."""
HELD_S = 5.0
"""A ground speed as old as this still says that the machine moves."""


def unknown(
    wheel_mps: Array, wheel_ns: NDArray[np.int64], ground_mps: Array, ground_ns: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], Array]:
    """Which wheel speeds read exactly zero while the ground moves; the ground's speed then.

    Where the ground's speed is not known at a wheel's row, that of the nearest rows counts.
    """
    known = np.isfinite(ground_mps)
    zero = wheel_mps == 0.0
    if not known.any() or not zero.any():
        return np.zeros(len(wheel_mps), bool), np.empty(0)
    at_s = (wheel_ns - ground_ns[0]) * 1e-9
    time_s = (ground_ns[known] - ground_ns[0]) * 1e-9
    near = np.interp(at_s, time_s, ground_mps[known])
    right = np.clip(np.searchsorted(time_s, at_s), 0, len(time_s) - 1)
    left = np.maximum(right - 1, 0)
    age_s = np.minimum(np.abs(at_s - time_s[left]), np.abs(at_s - time_s[right]))
    moving = (near > MOVING_MPS) | _for_long(zero & (near > CREEPING_MPS), at_s)
    doubted = zero & moving & (age_s < HELD_S)
    return doubted, near[doubted]


def _for_long(holds: NDArray[np.bool_], time_s: Array) -> NDArray[np.bool_]:
    """Rows of pieces over which something holds for CREEPING_S."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(np.int8)))
    long = np.zeros(len(holds), bool)
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        long[start:stop] = time_s[stop - 1] - time_s[start] >= CREEPING_S
    return long
