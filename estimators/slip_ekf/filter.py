"""The causal filter: every sample in order of arrival, at the epoch it was measured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.kalman import Array, Record
from estimators.layout import (
    CAMERA,
    GNSS,
    GRAVITY_MPS2,
    IMU,
    OUT_OF_ORDER,
    REPEATED,
    RESTARTED,
    STALE_S,
    WHEELS,
)
from estimators.slip_ekf import model
from estimators.slip_ekf.counts import take_wheels
from estimators.slip_ekf.layout import ACCEL_BIAS, GATED, SIZE, TILTING, A, V
from estimators.slip_ekf.noise import jerk_psd, listen, unrest
from estimators.slip_ekf.pitch import turn
from estimators.slip_ekf.report import report
from estimators.slip_ekf.rows import (
    LEAN_S,
    doubt,
    gated,
    jolt,
    lean,
    restart,
    shift,
    surprise,
    take,
)
from estimators.slip_ekf.tuning import FROM_CAMERA, FROM_FRONT, FROM_GNSS, FROM_IMU
from twin.compute.compiled import compiled


@compiled
def loop(
    signals: Any, raised: Array, nominal: Record, tuning: Record, memory: Record, rows: Any
) -> int:
    """Take the samples, write an estimate per wheel sample; returns how many."""
    n = 0
    h = np.zeros(SIZE)
    for i in range(len(signals)):
        signal = signals[i]
        memory.flags |= signal.flags
        if signal.flags & OUT_OF_ORDER:
            continue
        advance(signal.epoch_ns, nominal, tuning, memory)
        if measure(signal, raised[i], h, nominal, tuning, memory):
            report(rows[n], signal, nominal, tuning, memory)
            n += 1
    return n


@compiled
def measure(
    signal: Record, raised: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> bool:
    """Take a sample at its own epoch; whether an estimate is due, one per wheel sample."""
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if age > STALE_S:
        memory.flags |= OUT_OF_ORDER
    elif signal.sensor == GNSS:
        _take_gnss(signal, age, h, tuning, memory)
    elif signal.sensor == IMU:
        _take_imu(signal, age, h, nominal, tuning, memory)
    elif signal.sensor == CAMERA:
        _take_camera(signal, age, h, tuning, memory)
    elif signal.sensor == WHEELS:
        take_wheels(signal, age, raised, h, nominal, tuning, memory)
        return True
    return False


@compiled
def advance(epoch_ns: int, nominal: Record, tuning: Record, memory: Record) -> None:
    """Predict to a newer epoch; start again after a gap."""
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns >= 0 and dt > STALE_S:
        memory.known = 0
        memory.rear_spans = memory.front_spans = 0
        memory.first_mps = np.nan
        memory.v_y_ns = -1
        memory.flags |= RESTARTED
    elif memory.time_ns >= 0 and dt > 0.0 and memory.known:
        memory.travelled_m += memory.x[V] * dt
        memory.shift[:] = 0.0
        memory.cut[:] = 0
        memory.grown[:, :] = 0.0
        felt = memory.imu_ns >= 0 and epoch_ns - memory.imu_ns < 1_000_000_000
        restless = unrest(felt, tuning, memory)
        memory.forgotten_s = restless[3]
        model.carry(memory.x, memory.cov, memory.rim_mps, restless, dt, tuning)
        memory.cov[ACCEL_BIAS, ACCEL_BIAS] += nominal.gravity * tuning.leak_psd * dt
    memory.time_ns = max(memory.time_ns, epoch_ns)


@compiled
def _take_gnss(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    speed, sd = signal.v_x_mps, signal.v_sd_mps
    if math.isfinite(speed) and math.isfinite(sd):
        if memory.known:
            error = speed - model.ground_row(memory.x, age, h)
            # what the motion did since, which v - a age does not know
            unknown = jerk_psd(tuning, memory) * age**3 / 3.0
            variance = sd**2 + unknown
            _lean(signal, h, error, variance, tuning, memory)
            if gated(memory, FROM_GNSS, h, error, variance, signal.epoch_ns, tuning):
                memory.measured_ns = signal.epoch_ns
            else:
                memory.flags |= GATED
        else:
            memory.first_mps, memory.first_var = speed, sd**2 + age**2
            memory.measured_ns = signal.epoch_ns
    if math.isfinite(signal.v_y_held_mps) and math.isfinite(speed):
        _take_across(signal, tuning, memory)


@compiled
def _lean(
    signal: Record, h: Array, error: float, variance: float, tuning: Record, memory: Record
) -> None:
    """Where GNSS is off the same way for long, the towed wheels have changed.

    Unless they are off that way too: then it is the accelerometer. And a receiver that hangs knows
    nothing of the others.
    """
    if signal.flags & REPEATED:
        return
    leans = lean(memory, FROM_GNSS, h, error, variance, tuning.gate)
    if abs(leans) > tuning.lean:
        towed = 1.0 if memory.lean[FROM_FRONT] * leans < 0.0 else 0.0
        doubt(memory, error, LEAN_S, towed)
        memory.lean[FROM_GNSS] = 0.0


@compiled
def _take_camera(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    """A camera's forward speed; its own height is not known, and moves."""
    speed = signal.v_x_mps
    if not (math.isfinite(speed) and math.isfinite(signal.v_sd_mps)):
        return
    variance = signal.v_sd_mps**2 + (tuning.camera_sd * speed) ** 2
    if not memory.known:
        if not math.isfinite(memory.first_mps):
            memory.first_mps = speed
            memory.first_var = variance + (tuning.camera_scale_sd * speed) ** 2
        return
    error = speed - model.camera_row(memory.x, age, h)
    if gated(memory, FROM_CAMERA, h, error, variance, signal.epoch_ns, tuning):
        memory.measured_ns = signal.epoch_ns
    else:
        memory.flags |= GATED


@compiled
def _take_across(signal: Record, tuning: Record, memory: Record) -> None:
    """A random walk of the velocity across the body, measured by GNSS with its heading."""
    measured, variance = signal.v_y_held_mps, signal.v_y_held_sd_mps**2
    if memory.v_y_ns < 0:
        memory.v_y, memory.v_y_var = measured, variance
    else:
        memory.v_y_var += tuning.v_y_psd * max(0.0, (signal.epoch_ns - memory.v_y_ns) * 1e-9)
        error, total = measured - memory.v_y, memory.v_y_var + variance
        if error * error < tuning.gate**2 * total:
            gain = memory.v_y_var / total
            memory.v_y += gain * error
            memory.v_y_var *= 1.0 - gain
        else:  # taken in part: a skid across is rare, a wrong heading is not
            memory.v_y_var += 0.1 * error * error
    memory.v_y_ns = signal.epoch_ns


@compiled
def _take_imu(
    signal: Record, age: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    accel = signal.accel_x_mps2
    dt = min(max((signal.epoch_ns - memory.imu_ns) * 1e-9, 0.0), 0.1)
    turn(signal.pitch_rate_radps, signal.epoch_ns, memory)
    if memory.known and math.isfinite(signal.gyro_y_radps):
        if memory.gyro_y_known:
            tilt = 0.5 * (memory.gyro_y + signal.gyro_y_radps) * dt
            shift(memory, ACCEL_BIAS, -GRAVITY_MPS2 * tilt)
        else:
            restart(memory, TILTING, (GRAVITY_MPS2 * tuning.gyro_bias_sd) ** 2)
        memory.gyro_y, memory.gyro_y_known = signal.gyro_y_radps, 1
        # the unit stands above the axle: pitching moves it
        accel -= memory.pitch_accel * nominal.imu_m[2]
    accel += signal.yaw_rate_radps**2 * nominal.imu_m[0]
    memory.imu_ns = signal.epoch_ns
    if not math.isfinite(accel):
        return
    floor = nominal.accel_sd_mps2 if math.isfinite(nominal.accel_sd_mps2) else 0.0
    felt = accel + nominal.gravity * GRAVITY_MPS2 * memory.pitch_rad
    variance = listen(felt, signal.epoch_ns, max(floor, tuning.accel_floor_sd) ** 2, memory)
    if memory.known:
        h[:] = 0.0
        h[A] = h[ACCEL_BIAS] = 1.0
        error = accel - memory.x[A] - memory.x[ACCEL_BIAS]
        unknown = jerk_psd(tuning, memory) * age  # what the motion did since
        variance += unknown
        grown, _ = surprise(memory, FROM_IMU, h, error, variance, tuning.follow)
        if grown > 0.0:
            jolt(memory, grown, dt, tuning.load_correlation)
        take(memory.x, memory.cov, h, error, variance, memory.raised)
