"""Speeds of an axle from its wheels' counters, without those that are stuck."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from twin.compute.compiled import compiled

MOVING_MPS = 0.2
"""A counter that stands still while its wheel should turn this fast is stuck."""
JUMP_MPS = 2.0
"""No wheel changes its speed by more between two samples."""
APART_S, LIFTED, DOWN = 0.2, 0.03, 0.01
"""Towed wheels that differ over this time [s] by more than such a share of their speed do not both
touch the ground; they do again below the other. Tyres of one axle differ by less than 1 %."""


@compiled
def usable(speed: float, predicted: float) -> bool:
    """Whether a wheel's speed can be: finite, turning if it should, and no jump."""
    if not math.isfinite(speed):
        return False
    if speed == 0.0 and abs(predicted) > MOVING_MPS:
        return False
    return not math.isfinite(predicted) or abs(speed - predicted) < JUMP_MPS


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
def lifted(wheels: Array, across: float, dt: float, nominal: Record, memory: Record) -> bool:
    """Find the towed wheel that is in the air and coasts down; whether that has changed.

    A towed wheel skids and does not spin: of two that differ by more than turning explains, the
    slower is in the air. `memory.lifted` is 1 more than its place, 0 for none.

    Args:
        wheels: speeds [m/s], (4,), NaN where there is none.
        across: right less left as turning makes it [m/s].
        dt: time since the last sample [s].
        nominal: record of `layout.NOMINAL`.
        memory: record, changed in place.
    """
    left, right = (0, 1) if nominal.driven[2] else (2, 3)
    faster = max(wheels[left], wheels[right])
    if nominal.driven[left] or nominal.driven[right] or not math.isfinite(faster):
        return False
    share = min(dt / APART_S, 1.0)
    memory.towed_apart_mps += share * (
        wheels[right] - wheels[left] - across - memory.towed_apart_mps
    )
    before, apart = memory.lifted, abs(memory.towed_apart_mps)
    if apart > LIFTED * max(abs(faster), MOVING_MPS):
        memory.lifted = 1 + (left if memory.towed_apart_mps > 0.0 else right)
    elif apart < DOWN * max(abs(faster), MOVING_MPS):
        memory.lifted = 0
    return bool(memory.lifted != before)


@compiled
def radius(nominal: Record, driven: float) -> float:
    """Mean nominal radius of an axle's wheels [m]; 0 where none is stated."""
    total, n = 0.0, 0
    for i in range(4):
        if nominal.driven[i] == driven and math.isfinite(nominal.radius_m[i]):
            total += nominal.radius_m[i]
            n += 1
    return total / n if n else 0.0
