"""An accelerometer along the body, and the gyro that measures how the body pitches."""

from __future__ import annotations

import math

from estimators.innovations import note
from estimators.kalman import Array, Record
from estimators.layout import GRAVITY_MPS2
from estimators.slip_ekf import motion, rows
from estimators.slip_ekf.jerk import accel_var, wheel_gain
from estimators.slip_ekf.layout import BIAS, BIAS_RATE, FROM_IMU, NUMBER
from estimators.slip_ekf.update import restart, take, variance
from twin.compute.compiled import array_law

OUTLIER_SD = 4.0
"""An acceleration further off than this many sd is a new motion, and is followed."""
ACCEL_FLOOR_MPS2 = 0.01
"""No accelerometer is better than this."""
GYRO_BIAS_SD_RADPS = 1e-3
"""sd of a pitch gyro's bias, 0.06 degrees per second."""
GYRO_GAP_S = 0.5
"""Step longer than this and the gyro's integral means nothing [s]."""
AHEAD_S, PITCH_STALE_S = 0.06, 0.5
"""No further ahead of the newest gyro sample is the pitch predicted, and after this time it is not
known [s]."""


@array_law
def take_imu(
    signal: Record, age: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    """An acceleration; how the gyro turns the body since the last one is known, and not learnt."""
    accel, leaking = signal.accel_x_mps2, nominal.gravity * GRAVITY_MPS2
    dt = (signal.epoch_ns - memory.imu_ns) * 1e-9
    rate = signal.pitch_rate_radps
    fresh = memory.imu_ns >= 0 and 0.0 < dt < GYRO_GAP_S
    memory.pitch_accel = (rate - memory.pitch_rate) / dt if fresh else 0.0
    if fresh:
        memory.pitch_rad += 0.5 * (memory.pitch_rate + rate) * dt
    memory.pitch_rate = rate
    if memory.known and math.isfinite(signal.gyro_y_radps):
        if not math.isfinite(memory.gyro):
            restart(memory, NUMBER[BIAS_RATE], (leaking * GYRO_BIAS_SD_RADPS) ** 2)
        elif fresh:
            tilt = 0.5 * (memory.gyro + signal.gyro_y_radps) * dt
            memory.x[BIAS] -= leaking * tilt
        else:  # how the body turned is unknown
            memory.p[BIAS, BIAS] += (nominal.gravity * tuning.gravity_sd) ** 2
        memory.gyro = signal.gyro_y_radps
        # the unit stands above the axle: pitching moves it
        accel -= memory.pitch_accel * nominal.imu_m[2]
    accel += signal.yaw_rate_radps**2 * nominal.imu_m[0]
    if not math.isfinite(accel):
        memory.imu_ns = signal.epoch_ns
        return
    floor = nominal.accel_sd_mps2 if math.isfinite(nominal.accel_sd_mps2) else 0.0
    level = accel + leaking * memory.pitch_rad
    white = accel_var(level, signal.epoch_ns, max(floor, ACCEL_FLOOR_MPS2) ** 2, memory)
    memory.imu_ns = signal.epoch_ns
    if not memory.known:
        return
    error = accel - rows.accel(memory.x, h)
    white += max(memory.jerk_psd, tuning.jerk_psd) * age
    total = variance(memory.p, h, white)
    note(memory.notes, error, total)
    memory.nis_sum[FROM_IMU] += error**2 / total
    memory.nis_count[FROM_IMU] += 1
    if error**2 > OUTLIER_SD**2 * total:
        excess, step = error**2 - total, min(max(dt, 1e-3), 0.1)
        gain, own = wheel_gain(tuning, memory), tuning.wheel_jerk_share
        psd = excess / step
        motion.add_jerk(memory.p, psd, psd * (gain**2 + own), psd * gain, step)
    take(memory, h, error, white)


@array_law
def pitch(epoch_ns: int, memory: Record) -> tuple[float, float]:
    """How far the body has turned nose down [rad], and its rate [rad/s]; carried on to an epoch.

    pitch(t) = pitch + q tau + dq/dt tau^2 / 2,   rate(t) = q + dq/dt tau
    """
    since = (epoch_ns - memory.imu_ns) * 1e-9
    if memory.imu_ns < 0 or since >= PITCH_STALE_S:
        return memory.pitch_rad, 0.0
    tau = min(max(since, 0.0), AHEAD_S)
    now = memory.pitch_rad + memory.pitch_rate * tau + 0.5 * memory.pitch_accel * tau**2
    return now, memory.pitch_rate + memory.pitch_accel * tau
