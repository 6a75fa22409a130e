"""The first state of the filter, from the first speeds."""

from __future__ import annotations

import math

from estimators.kalman import Record
from estimators.slip_ekf.layout import (
    ACROSS,
    BIAS,
    CAMERA,
    FROM_TOWED,
    FRONT,
    LATE,
    QUICK,
    RADIUS,
    RATE,
    REAR,
    RECEIVER,
    SIZE,
    SWING,
    SWING_RATE,
    TOWED,
    USUAL,
    WHEEL_BIAS,
    A,
    V,
    W,
)
from estimators.slip_ekf.wheels import axle
from twin.compute.compiled import array_law

SLOW_MPS = 0.3
"""Below this the first speeds say nothing of slip."""
LEAST_BIAS_SD_MPS2 = 0.002
"""No accelerometer's bias is taken to be smaller, whatever its data sheet says."""
LATE_SD_S = 0.02
"""sd of a receiver's error in its own time stamps."""
RADIUS_SD = 0.01
"""sd of the driven wheels' mean radius error: tyre pressure, wear, load."""
USUAL_SD, NO_IDEA_SD = 0.05, 0.1
"""sd of the usual slip about the first one, and where that says nothing."""


@array_law
def begin(signal: Record, age: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin with the first ground speed and the slip it makes with the driven wheels' speed."""
    wheels, sd = signal.wheel_mps, signal.wheel_sd_mps
    front, front_var, _ = axle(wheels, sd, nominal, 0.0, math.nan, 0.0, math.inf)
    rear, rear_var, _ = axle(wheels, sd, nominal, 1.0, math.nan, 0.0, math.inf)
    speed, var = memory.first_mps, memory.first_var
    if math.isfinite(front):
        front_var += (tuning.scale_sd * front) ** 2
        if math.isfinite(speed):
            share = var / (var + front_var)
            speed, var = speed + share * (front - speed), var * (1.0 - share)
        else:
            speed, var = front, front_var
            memory.measured_ns = signal.epoch_ns
    if not math.isfinite(speed) or not math.isfinite(rear):
        return
    tau = 0.0
    for i in range(4):
        tau = max(tau, signal.wheel_age_s[i])
    if tau > 0.0:
        late_var = 2.0 * memory.jitter_var / (2.0 * tau) ** 2
        rear_var += late_var * rear**2
        var += late_var * speed**2 if math.isfinite(front) else 0.0
    x, p = memory.x, memory.p
    memory.known = 1
    memory.rim_mps, memory.spin = rear, 1.0
    memory.step_s, memory.gyro = 0.0, math.nan
    for i in range(SIZE):
        x[i] = 0.0
        for j in range(SIZE):
            p[i, j] = 0.0
    x[V], x[W] = speed, rear
    bias_sd = max(nominal.accel_bias_sd_mps2, LEAST_BIAS_SD_MPS2)
    swing = tuning.swing_sd
    for state, deviation in (
        (V, math.sqrt(var)),
        (W, math.sqrt(rear_var + (RADIUS_SD * rear) ** 2)),
        (A, 1.0),
        (RATE, 1.0),
        (BIAS, math.hypot(nominal.gravity * tuning.leak_sd, bias_sd)),
        (WHEEL_BIAS, bias_sd),
        (RADIUS, RADIUS_SD),
        (TOWED, tuning.scale_sd),
        (CAMERA, tuning.scale_sd),
        (QUICK, tuning.quick_sd),
        (LATE, LATE_SD_S),
        (RECEIVER, tuning.receiver_share * nominal.velocity_sd_mps),
        (SWING, swing),
        (SWING_RATE, swing * 2.0 * math.pi * tuning.swing_hz),
        (ACROSS, 1.0),
        (REAR, math.sqrt(2.0 * rear_var) * tau),
        (FRONT, math.sqrt(2.0 * rear_var) * tau),
    ):
        p[state, state] = deviation**2
    p[W, RADIUS] = p[RADIUS, W] = -(RADIUS_SD**2) * rear
    origin = tau > 0.0 and age == 0.0
    memory.spans[0] = 1 if origin else 0
    memory.spans[1] = 1 if origin and math.isfinite(front) else 0
    if math.isfinite(front):
        memory.seen_ns[FROM_TOWED], memory.seen_mps[FROM_TOWED] = signal.epoch_ns, front
    _usual(memory)


@array_law
def _usual(memory: Record) -> None:
    """The first slip is the usual one, as far as anybody knows: 1 - v / w, its sd and 0.05 more."""
    x, p = memory.x, memory.p
    v, w = x[V], x[W]
    p[USUAL, USUAL] = NO_IDEA_SD**2
    if max(abs(v), abs(w)) >= SLOW_MPS:
        turning = math.copysign(max(abs(w), SLOW_MPS), w)
        x[USUAL] = max(-2.0, min(0.9, 1.0 - v / turning))
        by_v, by_w = -1.0 / turning, v / turning**2
        p[USUAL, USUAL] = by_v**2 * p[V, V] + by_w**2 * p[W, W] + USUAL_SD**2
        p[V, USUAL] = p[USUAL, V] = by_v * p[V, V]
        p[W, USUAL] = p[USUAL, W] = by_w * p[W, W]
        p[RADIUS, USUAL] = p[USUAL, RADIUS] = by_w * p[W, RADIUS]
