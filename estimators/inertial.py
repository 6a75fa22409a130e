"""The IMU's samples: how the body turns, and its acceleration without what is known of gravity."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.kalman import Record
from estimators.layout import GRAVITY_MPS2, HISTORY
from twin.compute.compiled import compiled

GYRO_MEAN_S = 30.0
"""Roll and pitch rates are taken about their mean over this: a tractor does not go on rolling,
a gyro's bias does."""
TURNED_RAD = 0.05
"""sd of the pitch and roll at either end of that mean: ploughs that rise and sink pitch a tractor
by a degree or two, a furrow rolls it by eight."""
PITCH_LEAK_S = 10.0
"""The pitch is integrated and forgotten over this: beyond it the gyro's drift is the larger."""
GAP_S = 0.2
"""Over a longer time between two samples a rate at its end says nothing of the pitch."""
ROLL_S = 2.0
"""Time over which the sideways acceleration is averaged to the cross slope."""


@compiled
def read(
    sample: NDArray[np.float64],
    epoch_ns: int,
    dt: float,
    nominal: Record,
    memory: Record,
    signal: Record,
) -> None:
    """Turn rates into memory, forward acceleration of the rear-axle centre into the signal.

    f_x = dv_x/dt + g sin(pitch) - r^2 l_x
    accel = f_x + r^2 l_x - g sin(pitch'),   dpitch'/dt = -(q - bias q) - pitch' / 10 s

    Quick pitching is taken out by the gyro; slopes and the mounting stay in, as a slow bias that a
    filter must carry. The lever arm's terms in angular acceleration and r v_y are left out.
    """
    p, q, r, accel_x, accel_y = sample[0], sample[1], sample[2], sample[3], sample[4]
    signal.accel_x_mps2, signal.gyro_y_radps = accel_x, q
    step = min(dt, 1.0)
    memory.imu_samples += 1
    if math.isfinite(p) and math.isfinite(q):
        gain = max(step / (GYRO_MEAN_S + step), 1.0 / memory.imu_samples)
        memory.gyro_mean_radps[0] += gain * (p - memory.gyro_mean_radps[0])
        memory.gyro_mean_radps[1] += gain * (q - memory.gyro_mean_radps[1])
        memory.gyro_s += step
        trust = _trust_in_mean(memory.gyro_s, nominal.gyro_bias_sd_radps)
        p -= trust * memory.gyro_mean_radps[0]
        q -= trust * memory.gyro_mean_radps[1]
        turned = -q * dt if dt <= GAP_S else 0.0
        memory.pitch_rad = (memory.pitch_rad + turned) * math.exp(-dt / PITCH_LEAK_S)
    else:
        p, q = 0.0, 0.0
    if math.isfinite(r):
        memory.yaw_rad += 0.5 * (memory.yaw_rate_radps + r) * step
        memory.yaw_rate_radps = r
    _average_cross_slope(accel_y, step, memory)
    signal.accel_mps2 = (
        accel_x
        + memory.yaw_rate_radps**2 * nominal.imu_m[0]
        - GRAVITY_MPS2 * math.sin(memory.pitch_rad)
    )
    slot = memory.imu_samples % HISTORY
    memory.history_ns[slot] = epoch_ns
    memory.history[slot, 0] = p
    memory.history[slot, 1] = q
    memory.history[slot, 2] = memory.yaw_rate_radps
    memory.history[slot, 3] = memory.yaw_rad


@compiled
def _trust_in_mean(span_s: float, bias_sd: float) -> float:
    """Share of a mean rate that is the gyro's bias: var b / (var b + 2 (turned / span)^2).

    A degree turned in the first seconds is no bias: with the antenna 2 m up it would be centimetres
    per second of ground speed.
    """
    if not span_s > 0.0 or not bias_sd > 0.0:
        return 0.0
    return float(1.0 / (1.0 + 2.0 * (TURNED_RAD / (span_s * bias_sd)) ** 2))


@compiled
def _average_cross_slope(accel_y: float, step: float, memory: Record) -> None:
    """Mean of f_y - r v_x, which on a cross slope is g sin(roll)."""
    if math.isfinite(memory.v_x_mps):
        accel_y -= memory.yaw_rate_radps * memory.v_x_mps
    if math.isfinite(accel_y):
        gain = max(step / (ROLL_S + step), 1.0 / memory.imu_samples)
        memory.accel_y_mps2 += gain * (accel_y - memory.accel_y_mps2)


@compiled
def turning_at(epoch_ns: int, memory: Record) -> tuple[float, float, float, float]:
    """Roll rate, pitch rate, yaw rate [rad/s] and integrated yaw [rad] at an epoch.

    Linear between the remembered IMU samples, held beyond the newest and before the oldest; zero
    without an IMU.
    """
    if memory.imu_samples == 0:
        return 0.0, 0.0, 0.0, 0.0
    after = memory.imu_samples % HISTORY
    if epoch_ns >= memory.history_ns[after]:
        ahead = min((epoch_ns - memory.history_ns[after]) * 1e-9, 1.0)
        p, q, r, yaw = _history(after, memory)
        return p, q, r, yaw + r * ahead
    for back in range(1, min(HISTORY, memory.imu_samples)):
        before = (memory.imu_samples - back) % HISTORY
        if memory.history_ns[before] <= epoch_ns:
            span = memory.history_ns[after] - memory.history_ns[before]
            part = (epoch_ns - memory.history_ns[before]) / span
            p0, q0, r0, yaw0 = _history(before, memory)
            p1, q1, r1, yaw1 = _history(after, memory)
            return (
                p0 + part * (p1 - p0),
                q0 + part * (q1 - q0),
                r0 + part * (r1 - r0),
                yaw0 + part * (yaw1 - yaw0),
            )
        after = before
    return _history(after, memory)


@compiled
def _history(slot: int, memory: Record) -> tuple[float, float, float, float]:
    return (
        memory.history[slot, 0],
        memory.history[slot, 1],
        memory.history[slot, 2],
        memory.history[slot, 3],
    )
