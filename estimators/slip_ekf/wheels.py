"""Speeds of an axle from its wheels, without those that are stuck or in the air."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from twin.compute.compiled import array_law

MOVING_MPS = 0.2
"""A counter that stands still while its wheel should turn this fast is stuck."""
APART_S, LIFTED, DOWN = 0.2, 0.03, 0.01
"""Towed wheels that differ over this time [s] by more than such a share of their speed do not both
touch the ground; they do again below the other. Tyres of one axle differ by less than 1 %."""


@array_law
def axle(
    wheels: Array, sd: Array, nominal: Record, driven: float, predicted: float, apart: float,
    jump: float,
) -> tuple[float, float, int]:  # fmt: skip
    """Mean speed of an axle's usable wheels, its variance, and how many they are.

    A wheel alone stands for the axle's mean: speed + apart / 2 on the left, - apart / 2 right.

    Args:
        wheels: speeds [m/s], (4,), NaN where there is none.
        sd: their standard deviations [m/s], (4,).
        nominal: record of `layout.NOMINAL`.
        driven: 1.0 for the driven wheels, 0.0 for the towed.
        predicted: what the mean should be [m/s], NaN if unknown.
        apart: right less left [m/s].
        jump: no wheel is further off what it should be [m/s].
    """
    total, variance, n = 0.0, 0.0, 0
    for i in range(4):
        side = 0.5 * apart if i % 2 == 0 else -0.5 * apart
        if nominal.driven[i] == driven and usable(wheels[i], predicted - side, jump):
            total += wheels[i] + side
            variance += sd[i] ** 2
            n += 1
    if n == 0:
        return np.nan, np.nan, 0
    return total / n, variance / n**2, n


@array_law
def usable(speed: float, predicted: float, jump: float) -> bool:
    """Whether a wheel's speed can be: finite, turning if it should, and no jump."""
    if not math.isfinite(speed):
        return False
    if speed == 0.0 and abs(predicted) > MOVING_MPS:
        return False
    return not math.isfinite(predicted) or abs(speed - predicted) < jump


@array_law
def in_the_air(wheels: Array, apart: float, was: int, nominal: Record) -> int:
    """1 more than the place of the towed wheel that is in the air and coasts down, 0 for none.

    A towed wheel skids and does not spin: of two that differ by more than turning explains, the
    slower is in the air, whichever way they turn.

    Args:
        wheels: speeds [m/s], (4,), NaN where there is none.
        apart: right less left, averaged, beyond what turning makes [m/s].
        was: what it was before.
        nominal: record of `layout.NOMINAL`.
    """
    left = 0 if nominal.driven[2] else 2
    both = wheels[left] + wheels[left + 1]
    if nominal.driven[left] or nominal.driven[left + 1] or not math.isfinite(both):
        return was
    least = max(abs(wheels[left]), abs(wheels[left + 1]), MOVING_MPS)
    if abs(apart) > LIFTED * least:
        return 1 + (left if apart * both > 0.0 else left + 1)
    return 0 if abs(apart) < DOWN * least else was


@array_law
def radius(nominal: Record, driven: float) -> float:
    """Mean nominal radius of an axle's wheels [m]; 0 where none is stated."""
    total, n = 0.0, 0
    for i in range(4):
        if nominal.driven[i] == driven and math.isfinite(nominal.radius_m[i]):
            total += nominal.radius_m[i]
            n += 1
    return total / n if n else 0.0
