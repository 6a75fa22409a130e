"""Speeds of an axle from its wheels, without those that are stuck or in the air."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import FROM_DRIVEN, FROM_TOWED, V
from estimators.slip_ekf.motion import front_path
from twin.compute.compiled import array_law

MOVING_MPS = 0.2
"""A counter that stands still while its wheel should turn this fast is stuck."""
DIFFERENCE_S, LIFTED_SHARE, LANDED_SHARE = 0.2, 0.03, 0.01
"""Towed wheels that differ over this time [s] by more than such a share of their speed do not both
touch the ground; they do again below the other. Tyres of one axle differ by less than 1 %."""


@array_law
def axle(
    wheels: Array, sd: Array, nominal: Record, driven: float, predicted: float, difference: float,
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
        difference: right less left [m/s].
        jump: no wheel is further off what it should be [m/s].
    """
    total, variance, n = 0.0, 0.0, 0
    for i in range(4):
        side = 0.5 * difference if i % 2 == 0 else -0.5 * difference
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
def in_the_air(wheels: Array, difference: float, was: int, nominal: Record) -> int:
    """1 more than the place of the towed wheel that is in the air and coasts down, 0 for none.

    A towed wheel skids and does not spin: of two that differ by more than turning explains, the
    slower is in the air, whichever way they turn.

    Args:
        wheels: speeds [m/s], (4,), NaN where there is none.
        difference: right less left, averaged, beyond what turning makes [m/s].
        was: what it was before.
        nominal: record of `layout.NOMINAL`.
    """
    left = 0 if nominal.driven[2] else 2
    both = wheels[left] + wheels[left + 1]
    if nominal.driven[left] or nominal.driven[left + 1] or not math.isfinite(both):
        return was
    least = max(abs(wheels[left]), abs(wheels[left + 1]), MOVING_MPS)
    if abs(difference) > LIFTED_SHARE * least:
        return 1 + (left if difference * both > 0.0 else left + 1)
    return 0 if abs(difference) < LANDED_SHARE * least else was


@array_law
def radius(nominal: Record, driven: float) -> float:
    """Mean nominal radius of an axle's wheels [m]; 0 where none is stated."""
    total, n = 0.0, 0
    for i in range(4):
        if nominal.driven[i] == driven and math.isfinite(nominal.radius_m[i]):
            total += nominal.radius_m[i]
            n += 1
    return total / n if n else 0.0


@array_law
def yawing(signal: Record, dt: float, jump: float, nominal: Record, memory: Record) -> None:
    """Right less left of both axles, averaged, and the yaw rate: the gyro's, else the wheels'.

    yaw rate = (right - left) / (track cos(steer)),   of the towed wheels where there are any

    1 / cos(steer) is the way of a front wheel over that of the rear-axle centre.
    """
    path_ratio, _ = front_path(memory.x[V], nominal.wheelbase_m * memory.yaw_rate)
    share = min(max(dt, 0.0) / DIFFERENCE_S, 1.0)
    rate = signal.yaw_rate_radps
    for rear in range(2):
        left = 2 * rear
        driven = nominal.driven[left] > 0.0
        at = 0 if driven else 1
        speed = memory.seen_mps[FROM_DRIVEN if driven else FROM_TOWED]
        both = usable(signal.wheel_mps[left], speed, jump)
        both = both and usable(signal.wheel_mps[left + 1], speed, jump)
        difference = signal.wheel_mps[left + 1] - signal.wheel_mps[left]
        if both:
            memory.difference_mps[at] += share * (difference - memory.difference_mps[at])
            track = nominal.track_rear_m if rear else nominal.track_front_m
            if signal.yaw_rate_radps == 0.0 and track > 0.0 and (not driven or rate == 0.0):
                rate = memory.difference_mps[at] / track * (1.0 if rear else path_ratio)
    memory.yaw_rate = rate
