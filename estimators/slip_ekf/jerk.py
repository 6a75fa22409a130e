"""How fast the motion changes: the densities of the jerks, learnt on the way."""

from __future__ import annotations

import math

from estimators.kalman import Record
from estimators.slip_ekf.judge import has_accelerometer
from estimators.slip_ekf.layout import FROM_TOWED, LAGS
from estimators.slip_ekf.learn import CLIP, SETTLE, factor
from twin.compute.compiled import array_law

NO_IMU_JERK_PSD, NO_IMU_FADING_S, DRIVEN_ONLY_FADING_S, NO_IMU_WHEEL_PSD = 0.2, 4.0, 0.3, 0.0135
"""Without an accelerometer: density of the jerk [m2/s5]; time over which accelerations are
forgotten [s], with towed wheels and without; density of the driven wheels' own jerk [m2/s5]."""
WHEEL_NIS, COMMON_PRODUCT, MOST_FACTOR = 1.5, 0.2, 1000.0
"""Mean e^2 / S of the driven wheels' counts above which they move more than thought, mean product
of both axles' e / sqrt(S) above which the machine does, and the largest factor."""
LEAST_FACTOR, MOST_EXCESS = 1.0, 100.0
GAIN_SLOW_S, GAIN_S, GAIN_PRIOR_MPS = 0.5, 30.0, 0.01
"""What lasts longer than the first of these is slow, the gain is learnt over the second [s], and
the prior of it counts as much as swings of the last [m/s]."""
JERK_SETTLE, JERK_CLIP = 500.0, 4.0
"""Samples over which the density of the jerk is averaged; a square counts at most as so many."""


@array_law
def fading_s(tuning: Record, memory: Record) -> float:
    """Time over which accelerations are forgotten [s]."""
    if has_accelerometer(memory):
        return float(tuning.fading_s)
    return NO_IMU_FADING_S if math.isfinite(memory.towed_innovation) else DRIVEN_ONLY_FADING_S


@array_law
def jerk_densities(has_imu: bool, tuning: Record, memory: Record) -> tuple[float, float, float]:
    """Densities of the noise on a, on r, and of both together [m2/s5].

    Under load the wheels, held by the governor, lose a share of what the ground speed loses:
    r = wheel_jerk_gain a + own. Without an accelerometer load cannot be told from throttle, and the
    driver's throttle changes both speeds alike.
    """
    if has_imu:
        jerk = max(memory.jerk_psd, tuning.jerk_psd)
        gain, own = wheel_gain(tuning, memory), tuning.wheel_jerk_share
        return jerk, memory.wheel_factor * jerk * (gain**2 + own), gain * jerk
    jerk = NO_IMU_JERK_PSD * memory.motion_factor
    return jerk, jerk + NO_IMU_WHEEL_PSD * memory.wheel_factor, jerk


@array_law
def wheel_gain(tuning: Record, memory: Record) -> float:
    """What of the ground's acceleration the driven wheels share, as far as it is learnt."""
    if memory.gain_sums[1] == 0.0:
        return float(tuning.wheel_jerk_gain)
    return float(min(max(memory.gain_sums[0] / memory.gain_sums[1], 0.0), 1.0))


@array_law
def gain(ground: float, wheel: float, dt: float, prior: float, memory: Record) -> None:
    """Learn how much of what the ground speed changes by quickly the driven wheels do, too.

    gain = E (w - slow w) (v - slow v) / E (v - slow v)^2

    A load slows the ground and leaves governed wheels most of their speed; a throttle changes both.
    """
    share = min(dt / GAIN_SLOW_S, 1.0)
    swings = memory.gain_sums
    if swings[1] == 0.0:
        memory.slow_mps[0], memory.slow_mps[1] = ground, wheel
        swings[1] = GAIN_PRIOR_MPS**2 * GAIN_S
        swings[0] = prior * swings[1]
    memory.slow_mps[0] += share * (ground - memory.slow_mps[0])
    memory.slow_mps[1] += share * (wheel - memory.slow_mps[1])
    v, w = ground - memory.slow_mps[0], wheel - memory.slow_mps[1]
    keep = max(1.0 - dt / GAIN_S, 0.0)
    swings[0] = keep * swings[0] + v * w * dt
    swings[1] = max(keep * swings[1] + v * v * dt, 1e-9)


@array_law
def adapt_factors(off: float, memory: Record) -> None:
    """Learn from what both axles surprise by together, the motion, and what by itself.

    Args:
        off: e / sqrt(S) of the driven wheels, after the towed ones were taken.
        memory: record, changed.
    """
    memory.wheel_factor = factor(memory.wheel_factor, off**2, WHEEL_NIS, 1.0, MOST_FACTOR)
    if not math.isfinite(memory.towed_innovation):
        memory.motion_factor = memory.wheel_factor
        return
    both = memory.towed_innovation * off
    memory.motion_factor = factor(
        memory.motion_factor, both, COMMON_PRODUCT, LEAST_FACTOR, MOST_FACTOR
    )
    own = memory.towed_innovation**2 - max(both, 0.0)
    memory.noise_factor[FROM_TOWED] = factor(
        memory.noise_factor[FROM_TOWED], own, 1.0, 1.0, MOST_EXCESS
    )


@array_law
def accel_var(accel: float, epoch_ns: int, floor_var: float, memory: Record) -> float:
    """Variance of the white part of an acceleration, never below the data sheet's.

    d = a_k - 2 a_k-1 + a_k-2,   E d^2 = 6 var             for white noise; motion hardly enters d
    c = a_k - a_k-10,            E c^2 = 2 var + psd tau   for white jerk

    The second gives `memory.jerk_psd`.
    """
    if memory.accel_count == 0:
        memory.accel_var = floor_var
    if memory.accel_count >= 2:
        square = (accel - 2.0 * memory.accel[0] + memory.accel[1]) ** 2 / 6.0
        square = min(square, CLIP * max(memory.accel_var, floor_var))
        memory.accel_var += (square - memory.accel_var) / min(SETTLE, memory.accel_count + 10.0)
    tau = (epoch_ns - memory.accel_ns[LAGS - 1]) * 1e-9
    if memory.accel_count >= LAGS and 0.0 < tau < 1.0:
        white = 2.0 * memory.accel_var
        limit = JERK_CLIP * (white + max(memory.jerk_psd, 0.0) * tau)
        square = min((accel - memory.accel[LAGS - 1]) ** 2, limit)
        gain = 1.0 / min(JERK_SETTLE, memory.accel_count)
        memory.jerk_psd += gain * ((square - white) / tau - memory.jerk_psd)
    for i in range(LAGS - 1, 0, -1):
        memory.accel[i], memory.accel_ns[i] = memory.accel[i - 1], memory.accel_ns[i - 1]
    memory.accel[0], memory.accel_ns[0] = accel, epoch_ns
    memory.accel_count += 1
    return float(max(memory.accel_var, floor_var))
