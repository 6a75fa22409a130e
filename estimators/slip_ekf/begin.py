"""The first state of the filter, from the first speeds."""

from __future__ import annotations

import math

from estimators.kalman import Record
from estimators.layout import STALE_S
from estimators.slip_ekf.brixius import traction
from estimators.slip_ekf.layout import (
    BIAS,
    CAMERA,
    FROM_TOWED,
    FRONT,
    GNSS_BIAS,
    LATENCY,
    PITCH_SLIP,
    PITCH_SLIP_RATE,
    RADIUS,
    REAR,
    SIZE,
    TOWED,
    TOWED_FAST,
    TRACTION,
    UNLOADED_SLIP,
    V_Y,
    W_RATE,
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
"""Least sd of an accelerometer's bias, below which no data sheet is trusted."""
LATENCY_SD_S = 0.02
"""sd of a receiver's error in its own time stamps."""
ACCEL_SD_MPS2 = 1.0
"""sd of the first acceleration, by which speeds are other than some time ago."""
LEAST_ALONG, LEAST_REST = 0.1, 0.01
"""Least of the front wheels' speed, squared, that is along the machine: they steer by 72 degrees at
most; and of the root beyond which front wheels do not tell the turning, at 45 degrees."""
FIRST_GNSS_BIAS = 0.7
"""sd of the receiver error that lasts at the start, over the noise it states."""
UNLOADED_SLIP_MEAN, UNLOADED_SLIP_SD = 0.007, 0.006
"""Slip with the plough out of the ground, and its sd from soil to soil: in the twin 0.3 to 0.6 % on
firm soil by Brixius' and Bekker's laws, 1.8 % on soft soil."""
FIRST_SLIP_SD, UNKNOWN_TRACTION_SD = 0.05, 0.5
"""sd of the mean slip about the first one; sd of the mean traction where that is unknown."""


@array_law
def begin(signal: Record, age: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin with the first ground speed and the slip it makes with the driven wheels' speed."""
    wheels, sd = signal.wheel_mps, signal.wheel_sd_mps
    front, front_var, _ = axle(wheels, sd, nominal, 0.0, math.nan, 0.0, math.inf)
    rear, rear_var, _ = axle(wheels, sd, nominal, 1.0, math.nan, 0.0, math.inf)
    tau = 0.0
    for i in range(4):
        tau = max(tau, signal.wheel_age_s[i])
    since_var = (ACCEL_SD_MPS2 * (age + tau)) ** 2
    waited_s = (memory.time_ns - memory.first_ns) * 1e-9
    speed = memory.first_mps if waited_s <= STALE_S else math.nan
    var = memory.first_var + (ACCEL_SD_MPS2 * waited_s) ** 2
    if math.isfinite(front):
        rolled = front
        front, front_var = _rear_speed(signal, front, front_var, nominal)
        _first_turning(rolled, front, signal, nominal, memory)
        front_var += (tuning.scale_sd * front) ** 2 + since_var
        if math.isfinite(speed):
            share = var / (var + front_var)
            speed, var = speed + share * (front - speed), var * (1.0 - share)
        else:
            speed, var = front, front_var
            memory.measured_ns = signal.epoch_ns
    if not math.isfinite(speed) or not math.isfinite(rear):
        return
    if tau > 0.0:
        late_var = 2.0 * memory.jitter_var / (2.0 * tau) ** 2
        rear_var += late_var * rear**2
        var += late_var * speed**2 if math.isfinite(front) else 0.0
    x, p = memory.x, memory.p
    memory.known = 1
    memory.rim_mps, memory.wheel_factor = rear, 1.0
    memory.step_s, memory.gyro, memory.plough = 0.0, math.nan, 0
    for i in range(SIZE):
        x[i] = 0.0
        for j in range(SIZE):
            p[i, j] = 0.0
    x[V], x[W], x[UNLOADED_SLIP] = speed, rear, UNLOADED_SLIP_MEAN
    bias_sd = max(nominal.accel_bias_sd_mps2, LEAST_BIAS_SD_MPS2)
    swing = tuning.pitch_slip_sd
    for state, deviation in (
        (V, math.sqrt(var)),
        (W, math.sqrt(rear_var + since_var)),
        (A, ACCEL_SD_MPS2),
        (W_RATE, ACCEL_SD_MPS2),
        (BIAS, math.hypot(nominal.gravity * tuning.gravity_sd, bias_sd)),
        (WHEEL_BIAS, bias_sd),
        (RADIUS, nominal.radius_sd),
        (UNLOADED_SLIP, UNLOADED_SLIP_SD),
        (TOWED, tuning.scale_sd),
        (CAMERA, tuning.scale_sd),
        (TOWED_FAST, tuning.towed_fast_sd),
        (LATENCY, LATENCY_SD_S),
        (GNSS_BIAS, FIRST_GNSS_BIAS * nominal.velocity_sd_mps),
        (PITCH_SLIP, swing),
        (PITCH_SLIP_RATE, swing * 2.0 * math.pi * tuning.pitch_hz),
        (V_Y, 1.0),
        (REAR, math.sqrt(2.0 * rear_var) * tau),
        (FRONT, math.sqrt(2.0 * rear_var) * tau),
    ):
        p[state, state] = deviation**2
    origin = tau > 0.0 and age == 0.0
    memory.unbroken[0] = 1 if origin else 0
    memory.unbroken[1] = 1 if origin and math.isfinite(front) else 0
    if math.isfinite(front):
        memory.seen_ns[FROM_TOWED], memory.seen_mps[FROM_TOWED] = signal.epoch_ns, front
    _first_traction(memory)


@array_law
def _rear_speed(signal: Record, front: float, var: float, nominal: Record) -> tuple[float, float]:
    """Speed of the rear-axle centre from that of the towed wheels, and its variance.

    v^2 = front^2 - b^2,   b = wheelbase yaw rate

    The yaw rate is the gyro's, else the wheels'. Front wheels roll along where they are steered:

    k = wheelbase (right - left) / track = b v / front
    b^2 = front^2 (1 - sqrt(1 - 4 k^2 / front^2)) / 2
    """
    turn, turn_var, steered = nominal.wheelbase_m * signal.yaw_rate_radps, 0.0, False
    for driven in range(2):
        for left in (0, 2):
            track = nominal.track_rear_m if left else nominal.track_front_m
            difference = signal.wheel_mps[left + 1] - signal.wheel_mps[left]
            known = nominal.driven[left] == driven and math.isfinite(difference) and track > 0.0
            if turn == 0.0 and known:
                by, sd = nominal.wheelbase_m / track, signal.wheel_sd_mps
                turn, turn_var = by * difference, by**2 * (sd[left] ** 2 + sd[left + 1] ** 2)
                steered = left == 0
    turn_sq, front_sq = max(turn**2 - turn_var, 0.0), front**2  # noise is no turning
    spread = (turn_sq + turn_var) * turn_var
    if steered and front_sq > 0.0:
        rest = max(1.0 - 4.0 * turn_sq / front_sq, LEAST_REST)
        turn_sq, spread = 0.5 * front_sq * (1.0 - math.sqrt(rest)), spread / rest
    along_sq = front_sq - turn_sq
    if along_sq <= LEAST_ALONG * front_sq:  # no machine turns so
        return front, var + front_sq
    by_turn = min(spread / along_sq, front_sq / 3.0)
    return math.copysign(math.sqrt(along_sq), front), var * front_sq / along_sq + by_turn


@array_law
def _first_turning(
    rolled: float, v: float, signal: Record, nominal: Record, memory: Record
) -> None:
    """The turning that makes this of the first speeds: yaw rate, and right less left of both axles.

    wheelbase |yaw rate| = sqrt(rolled^2 - v^2)
    """
    if not nominal.wheelbase_m > 0.0:
        return
    sign = signal.yaw_rate_radps
    for left in (0, 2):
        if sign == 0.0 and nominal.driven[left] == 0.0:
            sign = signal.wheel_mps[left + 1] - signal.wheel_mps[left]
    rate = math.sqrt(max(rolled**2 - v**2, 0.0)) / nominal.wheelbase_m
    memory.yaw_rate = math.copysign(rate, sign) if math.isfinite(sign) else 0.0
    memory.difference_mps[0] = memory.yaw_rate * nominal.track_rear_m
    along = v / rolled if rolled != 0.0 else 1.0
    memory.difference_mps[1] = memory.yaw_rate * nominal.track_front_m * along


@array_law
def _first_traction(memory: Record) -> None:
    """The mean traction begins as that of the first slip: 1 - v / w, its sd and 0.05 more."""
    x, p = memory.x, memory.p
    v, w = x[V], x[W]
    p[TRACTION, TRACTION] = UNKNOWN_TRACTION_SD**2
    if max(abs(v), abs(w)) >= SLOW_MPS:
        turning = math.copysign(max(abs(w), SLOW_MPS), w)
        x[TRACTION], steep = traction(max(-2.0, min(0.9, 1.0 - v / turning)))
        by_v, by_w = -steep / turning, steep * v / turning**2
        var = by_v**2 * p[V, V] + by_w**2 * p[W, W] + (steep * FIRST_SLIP_SD) ** 2
        p[TRACTION, TRACTION] = var
        p[V, TRACTION] = p[TRACTION, V] = by_v * p[V, V]
        p[W, TRACTION] = p[TRACTION, W] = by_w * p[W, W]
