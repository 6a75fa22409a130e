"""The causal filter: every sample in order of arrival, at the epoch it was measured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.estimate import SLOW_MPS, too_old
from estimators.inekf import rows
from estimators.inekf.group import attitude, left_jacobian, rotation, skew, times, turn, turn_back
from estimators.inekf.layout import (
    ACCEL_BIAS,
    ATTITUDE,
    FRONT_SCALE,
    GYRO_BIAS,
    SIZE,
    SLIP,
    VELOCITY,
)
from estimators.inekf.motion import carry, push, rates
from estimators.innovations import keep, note
from estimators.kalman import Array, Record, correct, predict, slip_and_sd
from estimators.layout import (
    GNSS,
    GRAVITY_MPS2,
    IMU,
    NO_GROUND_SPEED,
    OUT_OF_ORDER,
    RESTARTED,
    STALE_S,
    WHEELS,
)
from estimators.wheel_speed import driven_mean, mean_variance, towed_mean
from twin.compute.compiled import compiled

WAIT_S = 1.0
"""Time for which the filter waits for GNSS at the start [s]."""
SILENT_S = 0.5
"""An inertial unit that is silent for longer measures nothing."""
COURSE_MPS, COURSE_SD_RAD = 0.5, 0.1
"""Above this speed the course counts as a heading with this sd, where no heading is measured."""
TILT_SD_RAD, HEADING_SD_RAD = 0.05, 0.003
"""sd of the first tilt, and the least one of a heading: its baseline may be out of line."""
FIRST_SD_MPS = 0.3
"""sd of the first slip velocity."""
LEAN_SD = 1.0
"""sd of the lean of a body whose accelerometer is missing, for one of 50 samples a second."""
CHANGE_MPS2 = 1.0
"""sd of what an acceleration changes by while a sample is on its way."""
ASTRAY_NIS, MOST_ASTRAY = 25.0, 20
"""After 20 headings in a row that are off by more than five sd, the filter begins again."""
STEP_S = 0.1
"""No step of the covariance is longer."""


@compiled
def loop(
    signals: Any, raw: Array, nominal: Record, tuning: Record, memory: Record, out: Any
) -> int:
    """Take the samples, write an estimate per wheel sample; returns how many.

    Args:
        signals: records of `layout.SIGNALS`, in order of arrival.
        raw: what GNSS and inertial unit gave, as `RAW` names it, (samples, 7).
        nominal, tuning, memory: records; `memory` is changed.
        out: records of ROW to write.
    """
    count, h = 0, np.zeros(SIZE)
    for i in range(len(signals)):
        memory.flags |= signals[i].flags
        if signals[i].flags & OUT_OF_ORDER:
            continue
        if take(signals[i], raw[i], h, nominal, tuning, memory):
            report(out[count], h, nominal, memory)
            count += 1
    return count


@compiled
def kept_innovations(
    signals: Any, raw: Array, nominal: Record, tuning: Record, memory: Record, kept: Any
) -> int:
    """As `loop`; what is kept are the innovations."""
    count, h = 0, np.zeros(SIZE)
    for i in range(len(signals)):
        if not signals[i].flags & OUT_OF_ORDER:
            take(signals[i], raw[i], h, nominal, tuning, memory)
            count = keep(memory.notes, signals[i], kept, count)
    return count


@compiled
def take(
    signal: Record, raw: Array, h: Array, nominal: Record, tuning: Record, memory: Record
) -> bool:
    """Take a sample at its own epoch; whether an estimate is due."""
    _advance(signal.epoch_ns, nominal, tuning, memory)
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if too_old(signal, memory):
        return False
    if signal.sensor == IMU:
        memory.imu_ns = signal.epoch_ns
        memory.gyro[:], memory.accel[:] = raw[:3], raw[3:6]
    elif signal.sensor == GNSS:
        _take_gnss(signal.epoch_ns, raw, age, h, nominal, tuning, memory)
    elif signal.sensor == WHEELS:
        _take_wheels(signal, age, h, nominal, tuning, memory)
        return True
    return False


@compiled
def _advance(epoch_ns: int, nominal: Record, tuning: Record, memory: Record) -> None:
    """Carry the state to a newer epoch; start again after a gap."""
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns < 0:
        memory.first_ns = epoch_ns
    elif dt > STALE_S:
        memory.known = 0
        memory.first_ns = epoch_ns
        memory.flags |= RESTARTED
    elif dt > 0.0 and memory.known:
        if (epoch_ns - memory.imu_ns) * 1e-9 > SILENT_S:
            memory.gyro[:] = np.nan
            memory.accel[:] = np.nan
        steps = math.ceil(dt / STEP_S)
        for _ in range(steps):
            carry(dt / steps, nominal, tuning, memory)
        _slide(dt, nominal, memory)
    memory.time_ns = max(memory.time_ns, epoch_ns)


@compiled
def _slide(dt: float, nominal: Record, memory: Record) -> None:
    """Sum up the sideslip."""
    across = rows.along(1, False, nominal, memory, np.zeros(SIZE))
    memory.sideslip_rear_m += dt * across
    memory.sideslip_m += dt * (across + nominal.cg_x_m * rates(memory)[2])


@compiled
def _measure(h: Array, error: float, variance: float, memory: Record) -> float:
    """X <- Exp(K e) X,  P <- P - K S K^T, for one scalar innovation e; gives e^2 / S."""
    xi = np.zeros(SIZE)
    innovation, total = correct(xi, memory.p, h, error, variance)
    note(memory.notes, innovation, total)
    phi = xi[ATTITUDE : ATTITUDE + 3]
    turned, jacobian = rotation(phi), left_jacobian(phi)
    memory.world_from_body[:, :] = times(turned, memory.world_from_body)
    v, u = turn(turned, memory.v), turn(turned, memory.u)
    by_v, by_u = xi[VELOCITY : VELOCITY + 3], xi[SLIP : SLIP + 3]
    memory.v[:] = v + turn(jacobian, by_v)
    memory.u[:] = u + turn(jacobian, by_u)
    for k in range(3):
        memory.gyro_bias[k] += xi[GYRO_BIAS + k]
        memory.accel_bias[k] += xi[ACCEL_BIAS + k]
    memory.front_scale += xi[FRONT_SCALE]
    return innovation**2 / total


@compiled
def _take_gnss(
    epoch_ns: int, raw: Array, age: float, h: Array, nominal: Record, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """The antenna's velocity and the heading of the baseline, of `age` ago."""
    v_heading, quality = raw[3], raw[4]
    if math.isfinite(v_heading):
        memory.heading_rad, memory.heading_ns = v_heading, epoch_ns
    moving = math.isfinite(raw[0]) and math.isfinite(raw[1]) and quality != 0.0
    if moving:
        memory.gnss_ns = epoch_ns
    if not (memory.known and memory.placed):
        if moving:
            _begin(raw, nominal, tuning, memory)
        return
    if math.isfinite(v_heading):
        sd = raw[6] if raw[6] > 0.0 else nominal.heading_sd_rad
        since = age * rates(memory)[2]
        error = v_heading + since - rows.heading(nominal, memory, h)
        error -= 2.0 * math.pi * round(error / (2.0 * math.pi))
        nis = _measure(h, error, max(sd, HEADING_SD_RAD) ** 2, memory)
        memory.astray = memory.astray + 1 if nis > ASTRAY_NIS else 0
        if memory.astray > MOST_ASTRAY and moving:  # a receiver that has found its heading
            memory.flags |= RESTARTED
            _begin(raw, nominal, tuning, memory)
            return
    if moving:
        sd = raw[5] if raw[5] > 0.0 else nominal.velocity_sd_mps
        since_v = age * push(nominal, memory)
        for axis in range(3):
            if math.isfinite(raw[axis]):
                error = raw[axis] + since_v[axis] - rows.antenna(axis, nominal, memory, h)
                _measure(h, error, sd**2 + (CHANGE_MPS2 * age) ** 2, memory)


@compiled
def _take_wheels(
    signal: Record, age: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    """The driven wheels turn with v + u, the towed ones with v; across and up both are small."""
    rear = driven_mean(signal.wheel_mps, nominal)
    if math.isfinite(rear):
        memory.rim_mps = rear
    if not memory.known:
        waited_s = (signal.epoch_ns - max(memory.first_ns, memory.gnss_ns)) * 1e-9
        if waited_s > WAIT_S and math.isfinite(rear):
            _begin_blind(rear, nominal, tuning, memory)
        return
    tau = age + signal.wheel_age_s.max()
    since = tau * turn_back(memory.world_from_body, push(nominal, memory))[0]
    late_var = (CHANGE_MPS2 * age) ** 2
    if math.isfinite(rear):
        variance = mean_variance(signal.wheel_sd_mps, nominal, 1.0, signal.one_driven_speed)
        error = rear + since - rows.along(0, True, nominal, memory, h)
        _measure(h, error, variance + late_var, memory)
    front = towed_mean(signal.wheel_mps, nominal)
    if math.isfinite(front):
        turning = nominal.wheelbase_m * rates(memory)[2]
        front = math.copysign(math.sqrt(max(front**2 - turning**2, 0.0)), front)
        variance = mean_variance(signal.wheel_sd_mps, nominal, 0.0, signal.one_towed_speed)
        variance += (tuning.front_quick_sd * front) ** 2 + late_var
        error = front + since - rows.towed(nominal, memory, h)
        _measure(h, error, variance, memory)
    for axis in (1, 2):
        error = -rows.along(axis, True, nominal, memory, h)
        _measure(h, error, tuning.skid_sd**2, memory)
    if math.isnan(memory.accel[2]):
        for axis in (0, 1):
            _measure(h, -rows.lean(axis, memory, h), LEAN_SD**2, memory)


@compiled
def _begin(raw: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin with GNSS: heading of the baseline, else the course while it moves."""
    if memory.heading_ns >= 0 and (memory.time_ns - memory.heading_ns) * 1e-9 < STALE_S:
        yaw, sd = memory.heading_rad - nominal.heading_mount_rad, TILT_SD_RAD
    elif math.hypot(raw[0], raw[1]) > COURSE_MPS:
        yaw, sd = math.atan2(raw[1], raw[0]), COURSE_SD_RAD
        if memory.rim_mps < 0.0:
            yaw += math.pi
    else:
        return
    memory.placed = 1
    v = np.array([raw[0], raw[1], raw[2] if math.isfinite(raw[2]) else 0.0])
    sd_mps = max(raw[5] if raw[5] > 0.0 else nominal.velocity_sd_mps, 0.05)
    _start(yaw, sd, v, sd_mps, nominal, tuning, memory)


@compiled
def _begin_blind(rear: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin without GNSS, as the paper's filter: the wheels' speed, heading nowhere."""
    memory.placed = 0
    v = np.array([rear, 0.0, 0.0])
    _start(0.0, COURSE_SD_RAD, v, FIRST_SD_MPS, nominal, tuning, memory)


@compiled
def _start(
    yaw: float, yaw_sd: float, v: Array, sd_mps: float, nominal: Record, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """The first state, its errors of attitude, velocities and biases independent of each other.

    nu = dv + v^ phi,   mu = du + u^ phi
    """
    up = np.array([0.0, 0.0, 1.0])
    size = math.sqrt(memory.accel[0] ** 2 + memory.accel[1] ** 2 + memory.accel[2] ** 2)
    if nominal.gravity > 0.0 and size > 0.5 * GRAVITY_MPS2:
        up[:] = memory.accel / size
    memory.known = 1
    memory.world_from_body[:, :] = attitude(yaw, up)
    memory.v[:] = v
    memory.u[:] = 0.0
    memory.gyro_bias[:] = 0.0
    memory.accel_bias[:] = 0.0
    memory.front_scale = 0.0
    memory.astray = 0
    memory.p[:, :] = 0.0
    memory.p[FRONT_SCALE, FRONT_SCALE] = tuning.front_scale_sd**2
    turned, f = skew(v), np.eye(SIZE)
    for i in range(3):
        memory.p[ATTITUDE + i, ATTITUDE + i] = (yaw_sd if i == 2 else TILT_SD_RAD) ** 2
        memory.p[VELOCITY + i, VELOCITY + i] = sd_mps**2
        memory.p[SLIP + i, SLIP + i] = FIRST_SD_MPS**2
        memory.p[GYRO_BIAS + i, GYRO_BIAS + i] = nominal.gyro_bias_sd_radps**2
        memory.p[ACCEL_BIAS + i, ACCEL_BIAS + i] = nominal.accel_bias_sd_mps2**2
        for k in range(3):
            f[VELOCITY + i, ATTITUDE + k] = turned[i, k]
    predict(np.zeros(SIZE), memory.p, f, np.zeros((SIZE, SIZE)))


@compiled
def report(row: Record, h: Array, nominal: Record, memory: Record) -> None:
    """Write the estimate at the filter's time; slip by the delta method."""
    row.epoch_ns = memory.time_ns
    late_s = (memory.time_ns - memory.gnss_ns) * 1e-9
    if not memory.known or memory.gnss_ns < 0 or late_s > STALE_S:
        memory.flags |= NO_GROUND_SPEED
    row.flags = memory.flags
    memory.flags = 0
    if not memory.known:
        return
    by_v, by_w = np.zeros(SIZE), np.zeros(SIZE)
    ground = rows.along(0, False, nominal, memory, by_v)
    wheel = rows.along(0, True, nominal, memory, by_w)
    across = rows.along(1, False, nominal, memory, h)
    row.speed_mps, row.wheel_speed_mps = ground, wheel
    var_w, var_v = _quadratic(by_w, by_w, memory.p), _quadratic(by_v, by_v, memory.p)
    both = _quadratic(by_w, by_v, memory.p)
    row.slip, row.slip_sd = slip_and_sd(wheel, ground, var_w, var_v, both)
    row.v_y_mps = across + nominal.cg_x_m * rates(memory)[2]
    row.sideslip_m, row.sideslip_rear_m = memory.sideslip_m, memory.sideslip_rear_m
    if abs(ground) >= SLOW_MPS:
        row.sideslip_rear_rad = math.atan2(across, ground)
        row.sideslip_rad = math.atan2(row.v_y_mps, ground)
        row.sideslip_sd_rad = math.sqrt(max(_quadratic(h, h, memory.p), 0.0)) / abs(ground)


@compiled
def _quadratic(a: Array, b: Array, p: Array) -> float:
    """A P B^T."""
    total = 0.0
    for i in range(SIZE):
        if a[i] != 0.0:
            for j in range(SIZE):
                total += a[i] * p[i, j] * b[j]
    return total
