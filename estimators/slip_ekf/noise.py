"""How noisy the accelerometer is, vibration included: no data sheet knows the engine under it."""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled
from estimators.kalman import Record

SETTLE = 100.0
"""Samples over which the variance is averaged."""
CLIP = 9.0
"""A second difference counts at most as three standard deviations: an event is not noise."""


@compiled
def listen(accel: float, floor_var: float, memory: Record) -> float:
    """Variance of the white part of an acceleration, never below the data sheet's.

    d = a_k - 2 a_k-1 + a_k-2,   E d^2 = 6 var   for white noise; motion hardly enters d
    """
    if memory.accel_count == 0:
        memory.accel_var = floor_var
    if memory.accel_count >= 2:
        square = (accel - 2.0 * memory.accel[0] + memory.accel[1]) ** 2 / 6.0
        gain = 1.0 / min(SETTLE, memory.accel_count + 10.0)
        if np.isfinite(square):
            limit = CLIP * max(memory.accel_var, floor_var)
            memory.accel_var += gain * (min(square, limit) - memory.accel_var)
    memory.accel[1], memory.accel[0] = memory.accel[0], accel
    memory.accel_count += 1
    return float(max(memory.accel_var, floor_var))
