"""The filter of Zhang (2018), and the accelerometer that the paper names without an equation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from estimators.estimate import State, advance, begin, each_sample, too_old, write
from estimators.innovations import NOTES, each_innovation, innovations, note
from estimators.kalman import Array, Record, correct, predict
from estimators.layout import (
    GNSS,
    GRAVITY_MPS2,
    IMU,
    NO_GROUND_SPEED,
    RESTARTED,
    SILENT_S,
    STALE_S,
    WHEELS,
)
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

START_ACCEL_SD_MPS2 = 1.0
"""Standard deviation of the accelerations when a speed is first seen [m/s2]."""

TUNING = np.dtype(
    [
        ("jerk_psd", "f8"),
        ("wheel_jerk_psd", "f8"),
        ("bias_psd", "f8"),
        ("tilt_sd_rad", "f8"),
        ("accel_model_sd", "f8"),
    ],
    align=True,
)
MEMORY = np.dtype(
    [
        ("time_ns", "i8"),
        ("measured_ns", "i8"),
        ("flags", "i8"),
        ("ground_known", "i8"),
        ("ground", "f8", 3),
        ("ground_cov", "f8", (3, 3)),
        ("wheel_known", "i8", 4),
        ("wheel", "f8", (4, 2)),
        ("wheel_cov", "f8", (4, 2, 2)),
        ("notes", NOTES),
    ],
    align=True,
)


@dataclass(frozen=True, kw_only=True)
class FourState:
    """Kalman filter on x = [v, a, w, a_w], with an accelerometer bias and each wheel's own speed.

    dv = a dt,  da = dW_v,  db = dW_b,  dw = a_w dt,  da_w = dW_w    (white jerk)
    GNSS           z = v - a tau             sd of the data sheet
    accelerometer  z = a + b                 sd of the data sheet and `accel_model_sd_mps2`
    wheel i        z = w_i - a_w,i tau       sd of its ticks

    tau is the age of what was measured: for ticks half their interval, for a sample that arrives
    late the time since its epoch, as far as the filter has got by other sensors. The filter is
    never behind the newest epoch it has seen. Ground and wheels share no row and no noise, as in
    the paper, so no covariance between them; slip by the delta method.

    Gravity: the gyro takes quick pitching out of the accelerometer (`inertial.read`); slope,
    mounting and bias stay as b, which starts with the data sheet's sd and that of an unknown tilt.

    Source: Zhang, B. (2018), GNSS and MIMU fusion for driving wheel slip, eq. (2)-(7): A and the
    rows of v and w. The accelerometer's row, Q and R are not in the paper.
    """

    jerk_psd_m2ps5: float = 0.2
    """Density of the ground speed's jerk [m2/s5]: 0.3 m/s2 that decorrelates in about 1 s."""
    wheel_jerk_psd_m2ps5: float = 0.2
    """Density of a wheel speed's jerk [m2/s5]."""
    bias_psd_m2ps5: float = 1e-3
    """Density of the bias's random walk [m2/s5]: 0.03 m/s2, 0.2 degree of slope, in 1 s."""
    tilt_sd_rad: float = 0.05
    """Unknown tilt at the start, 3 degrees [rad]."""
    accel_model_sd_mps2: float = 0.2
    """What the accelerometer's row leaves out: vibration, lever arm, lateral motion [m/s2]."""

    tunable: ClassVar[Mapping[str, str]] = {
        "jerk_psd_m2ps5": "assumed",
        "wheel_jerk_psd_m2ps5": "assumed",
        "bias_psd_m2ps5": "assumed",
        "accel_model_sd_mps2": "assumed",
    }
    """Fields that `twin tune` finds from innovations -> grade of the values above."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = (
            self.jerk_psd_m2ps5,
            self.wheel_jerk_psd_m2ps5,
            self.bias_psd_m2ps5,
            self.tilt_sd_rad,
            self.accel_model_sd_mps2,
        )
        memory = np.zeros(1, MEMORY)
        memory["time_ns"] = memory["measured_ns"] = -1
        return begin(setup, np.array([tuning], TUNING), memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is not newer than the last one, or over 5 s older than the newest sample
        of any sensor, gives no row.
        """
        return advance(_loop, state, chunk)

    def innovations(self, setup: Setup, streams: Streams) -> Table:
        """Innovation of each measurement, and its predicted variance."""
        return innovations(_innovations, self.init(setup), streams)


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    return each_sample(_take, signals, nominal, tuning, memory, rows)


@compiled
def _innovations(
    signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any, kept: Any
) -> int:
    return each_innovation(_take, signals, nominal, tuning, memory, rows, kept)


@compiled
def _take(signal: Record, nominal: Record, tuning: Record, memory: Record, row: Record) -> bool:
    _carry(signal.epoch_ns, nominal, tuning, memory)
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if too_old(signal, memory):
        return False
    if signal.sensor == GNSS:
        _take_gnss(signal, age, nominal, tuning, memory)
    elif signal.sensor == IMU:
        _take_accel(signal, nominal, tuning, memory)
    elif signal.sensor == WHEELS:
        _take_wheels(signal, age, memory)
        _report(row, signal, nominal, memory)
        return True
    return False


@compiled
def _carry(epoch_ns: int, nominal: Record, tuning: Record, memory: Record) -> None:
    """Predict to a newer epoch; start again after a gap, and doubt the bias after a silence."""
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns >= 0 and dt > STALE_S:
        memory.ground_known = 0
        memory.wheel_known[:] = 0
        memory.flags |= RESTARTED
    elif memory.time_ns >= 0 and dt > 0.0:
        if memory.ground_known:
            f, q = white_jerk(dt, tuning.jerk_psd, 3)
            f[2, 2], q[2, 2] = 1.0, tuning.bias_psd * dt
            predict(memory.ground, memory.ground_cov, f, q)
            if dt > SILENT_S:
                memory.ground_cov[2, 2] += nominal.accel_bias_sd_mps2**2
        f, q = white_jerk(dt, tuning.wheel_jerk_psd, 2)
        for i in range(4):
            if memory.wheel_known[i]:
                predict(memory.wheel[i], memory.wheel_cov[i], f, q)
    memory.time_ns = max(memory.time_ns, epoch_ns)


@compiled
def white_jerk(dt: float, psd: float, n: int) -> tuple[Array, Array]:
    """Transition and process covariance of [speed, acceleration] under white jerk.

    F = [[1, dt], [0, 1]],   Q = psd [[dt^3/3, dt^2/2], [dt^2/2, dt]]

    Args:
        dt: step [s].
        psd: density of the jerk [m2/s5].
        n: size of the matrices; what is beyond two is zero.
    """
    f, q = np.zeros((n, n)), np.zeros((n, n))
    f[0, 0], f[0, 1], f[1, 1] = 1.0, dt, 1.0
    q[0, 0], q[1, 1] = psd * dt**3 / 3.0, psd * dt
    q[0, 1] = q[1, 0] = psd * dt**2 / 2.0
    return f, q


@compiled
def _take_gnss(signal: Record, age: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Measure the ground speed of `age` ago, v - a age; the first time, begin with it."""
    if not math.isfinite(signal.v_x_mps):
        return
    memory.measured_ns = signal.epoch_ns
    if memory.ground_known:
        variance = signal.v_sd_mps**2 + tuning.jerk_psd * age**3 / 3.0
        h = np.array([1.0, -age, 0.0])
        note(memory.notes, *correct(memory.ground, memory.ground_cov, h, signal.v_x_mps, variance))
        return
    bias_var = nominal.accel_bias_sd_mps2**2 + (GRAVITY_MPS2 * tuning.tilt_sd_rad) ** 2
    memory.ground_known = 1
    memory.ground[:] = 0.0
    memory.ground[0] = signal.v_x_mps
    memory.ground_cov[:, :] = 0.0
    memory.ground_cov[0, 0] = signal.v_sd_mps**2 + (age * START_ACCEL_SD_MPS2) ** 2
    memory.ground_cov[1, 1] = START_ACCEL_SD_MPS2**2
    memory.ground_cov[0, 1] = memory.ground_cov[1, 0] = age * START_ACCEL_SD_MPS2**2
    memory.ground_cov[2, 2] = bias_var


@compiled
def _take_accel(signal: Record, nominal: Record, tuning: Record, memory: Record) -> None:
    """Measure a + b; how late it comes is not made up for."""
    if memory.ground_known:
        variance = nominal.accel_sd_mps2**2 + tuning.accel_model_sd**2
        h = np.array([0.0, 1.0, 1.0])
        accel = signal.accel_mps2
        note(memory.notes, *correct(memory.ground, memory.ground_cov, h, accel, variance))


@compiled
def _take_wheels(signal: Record, age: float, memory: Record) -> None:
    """Measure w_i - a_w,i tau of each wheel; the first time, begin with it."""
    for i in range(4):
        speed, sd = signal.wheel_mps[i], signal.wheel_sd_mps[i]
        if not (math.isfinite(speed) and math.isfinite(sd)):
            continue
        tau = age + signal.wheel_age_s[i]
        if memory.wheel_known[i]:
            h = np.array([1.0, -tau])
            note(memory.notes, *correct(memory.wheel[i], memory.wheel_cov[i], h, speed, sd**2))
            continue
        memory.wheel_known[i] = 1
        memory.wheel[i, 0], memory.wheel[i, 1] = speed, 0.0
        accel_var = START_ACCEL_SD_MPS2**2
        memory.wheel_cov[i, 0, 0] = sd**2 + tau**2 * accel_var
        memory.wheel_cov[i, 0, 1] = memory.wheel_cov[i, 1, 0] = tau * accel_var
        memory.wheel_cov[i, 1, 1] = accel_var


@compiled
def _report(row: Record, signal: Record, nominal: Record, memory: Record) -> None:
    """Write the estimate at the filter's time."""
    wheels, wheel_sd = np.full(4, np.nan), np.full(4, np.nan)
    for i in range(4):
        if memory.wheel_known[i]:
            wheels[i], wheel_sd[i] = memory.wheel[i, 0], math.sqrt(memory.wheel_cov[i, 0, 0])
    ground, variance = np.nan, np.nan
    if memory.ground_known:
        ground, variance = memory.ground[0], memory.ground_cov[0, 0]
    if not memory.ground_known or (memory.time_ns - memory.measured_ns) * 1e-9 > STALE_S:
        memory.flags |= NO_GROUND_SPEED
    write(row, signal, nominal, ground, variance, wheels, wheel_sd)
    row.epoch_ns, row.flags = memory.time_ns, memory.flags
    memory.flags = 0
