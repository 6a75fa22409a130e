"""Speeds of an axle from its wheels' counters, without those that are stuck."""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled
from estimators.kalman import Array, Record

MOVING_MPS = 0.2
"""A counter that stands still while its wheel should turn this fast is stuck."""
JUMP_MPS = 2.0
"""No wheel changes its speed by more between two samples."""


@compiled
def usable(speed: float, predicted: float) -> bool:
    """Whether a wheel's speed can be: finite, turning if it should, and no jump."""
    if not np.isfinite(speed):
        return False
    if speed == 0.0 and abs(predicted) > MOVING_MPS:
        return False
    return not np.isfinite(predicted) or abs(speed - predicted) < JUMP_MPS


@compiled
def axle(
    wheels: Array, sd: Array, nominal: Record, driven: float, predicted: float, apart: float
) -> tuple[float, float, int]:
    """Mean speed of an axle's usable wheels, its variance, and how many they are.

    A wheel alone stands for the axle's mean: speed + apart / 2 on the left, - apart / 2 right.

    Args:
        wheels: speeds [m/s], (4,), NaN where there is none.
        sd: their standard deviations [m/s], (4,).
        nominal: record of `layout.NOMINAL`.
        driven: 1.0 for the driven wheels, 0.0 for the towed.
        predicted: what the mean should be [m/s], NaN if unknown.
        apart: right less left [m/s].
    """
    total, variance, n = 0.0, 0.0, 0
    for i in range(4):
        side = 0.5 * apart if i % 2 == 0 else -0.5 * apart
        if nominal.driven[i] == driven and usable(wheels[i], predicted - side):
            total += wheels[i] + side
            variance += sd[i] ** 2
            n += 1
    if n == 0:
        return np.nan, np.nan, 0
    return total / n, variance / n**2, n


@compiled
def radius(nominal: Record, driven: float) -> float:
    """Mean nominal radius of an axle's wheels [m]; 0 where none is stated."""
    total, n = 0.0, 0
    for i in range(4):
        if nominal.driven[i] == driven and np.isfinite(nominal.radius_m[i]):
            total += nominal.radius_m[i]
            n += 1
    return total / n if n else 0.0
