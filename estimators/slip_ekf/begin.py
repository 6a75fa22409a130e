"""The first state of the filter, from the first speeds."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Record
from estimators.slip_ekf.driven import axle
from estimators.slip_ekf.layout import (
    ACCEL_BIAS,
    CAMERA_SCALE,
    FRONT_TRAVEL,
    LATE,
    QUICK_RADIUS,
    QUICK_SKID,
    RADIUS,
    REAR_TRAVEL,
    RIM_RATE,
    SKID,
    SWING,
    SWING_RATE,
    USUAL,
    WHEEL_BIAS,
    A,
    V,
    W,
)
from estimators.slip_ekf.rows import restart
from twin.compute.compiled import compiled

SLOW_MPS = 0.3
"""Below this the first speeds say nothing of slip."""
LEAST_BIAS_SD_MPS2 = 0.002
"""No accelerometer's bias is taken to be smaller, whatever its data sheet says."""


@compiled
def begin(signal: Record, age: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin with the first ground speed and the slip it makes with the driven wheels' speed."""
    wheels, sd = signal.wheel_mps, signal.wheel_sd_mps
    front, front_var, _ = axle(wheels, sd, nominal, 0.0, np.nan, 0.0)
    rear, rear_var, _ = axle(wheels, sd, nominal, 1.0, np.nan, 0.0)
    speed, variance = memory.first_mps, memory.first_var
    if math.isfinite(front):
        front_var += (tuning.skid_sd * front) ** 2
        if math.isfinite(speed):
            share = variance / (variance + front_var)
            speed, variance = speed + share * (front - speed), variance * (1.0 - share)
        else:
            speed, variance = front, front_var
            memory.measured_ns = signal.epoch_ns
    if not math.isfinite(speed) or not math.isfinite(rear):
        return
    memory.known = 1
    memory.rim_mps, memory.spin, memory.forgotten_s = rear, 1.0, 1.0
    memory.x[:] = 0.0
    memory.cov[:, :] = 0.0
    memory.x[V] = speed
    memory.x[W] = rear
    memory.cov[V, V] = variance
    memory.cov[W, W] = rear_var + (tuning.radius_sd * rear) ** 2
    bias_sd = max(nominal.accel_bias_sd_mps2, LEAST_BIAS_SD_MPS2)
    for state, deviation in (
        (A, 1.0),
        (RIM_RATE, 1.0),
        (ACCEL_BIAS, math.hypot(nominal.gravity * tuning.leak_sd, bias_sd)),
        (RADIUS, tuning.radius_sd),
        (SKID, tuning.skid_sd),
        (QUICK_SKID, tuning.quick_skid_sd),
        (QUICK_RADIUS, tuning.quick_radius_sd),
        (LATE, tuning.late_sd),
        (CAMERA_SCALE, tuning.camera_scale_sd),
        (WHEEL_BIAS, bias_sd),
        (SWING, tuning.swing_sd),
        (SWING_RATE, tuning.swing_sd * 2.0 * math.pi * tuning.swing_hz),
    ):
        memory.cov[state, state] = deviation**2
    memory.gyro_y_known = 0
    memory.cov[W, RADIUS] = memory.cov[RADIUS, W] = -(tuning.radius_sd**2) * rear
    _usual(memory)
    memory.rear_ns = signal.epoch_ns
    if signal.wheel_age_s.max() > 0.0:
        restart(memory, REAR_TRAVEL, rear_var * 2.0 * signal.wheel_age_s.max() ** 2)
        memory.rear_spans = 1
        if math.isfinite(front):
            restart(memory, FRONT_TRAVEL, rear_var * 2.0 * signal.wheel_age_s.max() ** 2)
            memory.front_spans = 1


@compiled
def _usual(memory: Record) -> None:
    """The first slip is the usual one, as far as anybody knows: 1 - v / w, its sd and 0.05 more."""
    v, w = memory.x[V], memory.x[W]
    memory.cov[USUAL, USUAL] = 0.1**2
    if max(abs(v), abs(w)) >= SLOW_MPS:
        turning = math.copysign(max(abs(w), SLOW_MPS), w)
        memory.x[USUAL] = max(-2.0, min(0.9, 1.0 - v / turning))
        by_v, by_w = -1.0 / turning, v / turning**2
        variance = by_v**2 * memory.cov[V, V] + by_w**2 * memory.cov[W, W]
        memory.cov[USUAL, USUAL] = variance + 0.05**2
        memory.cov[V, USUAL] = memory.cov[USUAL, V] = by_v * memory.cov[V, V]
        memory.cov[W, USUAL] = memory.cov[USUAL, W] = by_w * memory.cov[W, W]
        memory.cov[RADIUS, USUAL] = memory.cov[USUAL, RADIUS] = by_w * memory.cov[W, RADIUS]
