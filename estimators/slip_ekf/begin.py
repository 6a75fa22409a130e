"""The first state of the filter, from the first speeds."""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled
from estimators.kalman import Record
from estimators.layout import GRAVITY_MPS2
from estimators.slip_ekf.driven import axle
from estimators.slip_ekf.layout import (
    ACCEL_BIAS,
    DS,
    FRONT_TRAVEL,
    LATE,
    QUICK_RADIUS,
    QUICK_SKID,
    RADIUS,
    REAR_TRAVEL,
    SKID,
    SWING,
    SWING_RATE,
    TILTING,
    USUAL,
    WHEEL_BIAS,
    A,
    S,
    V,
)
from estimators.slip_ekf.rows import restart


@compiled
def begin(signal: Record, age: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin with the first ground speed and the slip it makes with the driven wheels' speed."""
    wheels, sd = signal.wheel_mps, signal.wheel_sd_mps
    front, front_var, _ = axle(wheels, sd, nominal, 0.0, np.nan, 0.0)
    rear, rear_var, _ = axle(wheels, sd, nominal, 1.0, np.nan, 0.0)
    speed, variance = memory.first_mps, memory.first_var
    if np.isfinite(front):
        front_var += (tuning.skid_sd * front) ** 2
        if np.isfinite(speed):
            share = variance / (variance + front_var)
            speed, variance = speed + share * (front - speed), variance * (1.0 - share)
        else:
            speed, variance = front, front_var
            memory.measured_ns = signal.epoch_ns
    if not np.isfinite(speed) or not np.isfinite(rear):
        return
    memory.known = 1
    memory.rim_mps = rear
    memory.x[:] = 0.0
    memory.cov[:, :] = 0.0
    memory.x[V] = speed
    slow = max(abs(rear), abs(speed)) < 0.3
    if not slow:
        turning = math.copysign(max(abs(rear), 0.3), rear)
        memory.x[S] = max(-2.0, min(0.9, 1.0 - speed / turning))
    by_speed = 0.0 if slow else -1.0 / math.copysign(max(abs(rear), 0.3), rear)
    slip_var = 0.1**2 if slow else (rear_var + tuning.radius_sd**2 * rear**2) / max(rear**2, 0.09)
    memory.cov[V, V] = variance
    memory.cov[V, S] = memory.cov[S, V] = by_speed * variance
    memory.cov[S, S] = slip_var + by_speed**2 * variance
    for state, deviation in (
        (A, 1.0),
        (DS, 0.3),
        (ACCEL_BIAS, math.hypot(tuning.bias_sd, nominal.accel_bias_sd_mps2)),
        (RADIUS, tuning.radius_sd),
        (SKID, tuning.skid_sd),
        (QUICK_SKID, tuning.quick_skid_sd),
        (QUICK_RADIUS, tuning.quick_radius_sd),
        (LATE, tuning.late_sd),
        (WHEEL_BIAS, tuning.bias_sd),
        (TILTING, GRAVITY_MPS2 * tuning.gyro_bias_sd),
        (SWING, tuning.swing_sd),
        (SWING_RATE, tuning.swing_sd * 2.0 * math.pi * tuning.swing_hz),
    ):
        memory.cov[state, state] = deviation**2
    memory.gyro_y_known = 0
    memory.x[USUAL] = memory.x[S]
    memory.cov[USUAL, :] = memory.cov[S, :]
    memory.cov[:, USUAL] = memory.cov[:, S]
    memory.cov[USUAL, USUAL] = memory.cov[S, S] + 0.05**2
    if not slow:
        memory.cov[S, RADIUS] = memory.cov[RADIUS, S] = -(tuning.radius_sd**2) * (1.0 - memory.x[S])
    memory.rear_ns = signal.epoch_ns
    if signal.wheel_age_s.max() > 0.0:
        restart(memory, REAR_TRAVEL, rear_var * 2.0 * signal.wheel_age_s.max() ** 2)
        memory.rear_spans = 1
        if np.isfinite(front):
            restart(memory, FRONT_TRAVEL, rear_var * 2.0 * signal.wheel_age_s.max() ** 2)
            memory.front_spans = 1
