"""The causal filter: every sample in order of arrival, at the epoch it was measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from estimators.innovations import keep
from estimators.kalman import Array, Record
from estimators.layout import (
    CAMERA,
    GNSS,
    IMU,
    OUT_OF_ORDER,
    RESTARTED,
    STALE_S,
    WHEELS,
)
from estimators.slip_ekf import motion
from estimators.slip_ekf.camera import take_camera
from estimators.slip_ekf.clock import catch_up, note_out_of_order
from estimators.slip_ekf.counts import take_wheels
from estimators.slip_ekf.gnss import take_gnss
from estimators.slip_ekf.imu import take_imu
from estimators.slip_ekf.jerk import fading_s, jerk_densities
from estimators.slip_ekf.judge import forget_accelerations, has_accelerometer
from estimators.slip_ekf.layout import (
    FROM_GNSS,
    FROM_TOWED,
    SIZE,
    V,
)
from estimators.slip_ekf.report import report
from twin.compute.compiled import array_law

SLOW_MPS = 0.5
"""Below this speed a turn is no sharper."""


@array_law
def loop(
    signals: Any, slow: Array, nominal: Record, tuning: Record, memory: Record, out: Any
) -> int:
    """Take the samples, write an estimate per wheel sample; returns how many."""
    n = 0
    h = np.zeros(SIZE)
    f, q, scratch = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for i in range(len(signals)):
        signal = signals[i]
        memory.flags |= signal.flags
        if signal.flags & OUT_OF_ORDER:
            note_out_of_order(signal, memory)
            continue
        advance(signal.epoch_ns, nominal, tuning, memory, f, q, scratch)
        if measure(signal, slow[i], h, nominal, tuning, memory):
            report(out[n], signal, h, nominal, memory)
            n += 1
    return n


@array_law
def kept_innovations(
    signals: Any, slow: Array, nominal: Record, tuning: Record, memory: Record, kept: Any
) -> int:
    """Take the samples, keep their innovations; returns how many."""
    count = 0
    h = np.zeros(SIZE)
    f, q, scratch = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for i in range(len(signals)):
        if signals[i].flags & OUT_OF_ORDER:
            note_out_of_order(signals[i], memory)
        else:
            advance(signals[i].epoch_ns, nominal, tuning, memory, f, q, scratch)
            measure(signals[i], slow[i], h, nominal, tuning, memory)
            count = keep(memory.notes, signals[i], kept, count)
    return count


@array_law
def measure(
    signal: Record, slow: Array, h: Array, nominal: Record, tuning: Record, memory: Record
) -> bool:
    """Take a sample at its own epoch; whether an estimate is due, one per wheel sample."""
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if age > STALE_S:
        memory.flags |= OUT_OF_ORDER
    elif signal.sensor == GNSS:
        take_gnss(signal, age, h, tuning, memory)
    elif signal.sensor == IMU:
        take_imu(signal, age, h, nominal, tuning, memory)
    elif signal.sensor == CAMERA:
        take_camera(signal, age, h, tuning, memory)
    elif signal.sensor == WHEELS:
        take_wheels(signal, age, slow, h, nominal, tuning, memory)
        return True
    return False


@array_law
def advance(
    epoch_ns: int,
    nominal: Record,
    tuning: Record,
    memory: Record,
    f: Array,
    q: Array,
    scratch: Array,
) -> None:
    """Predict to a newer epoch; start again after a gap."""
    if epoch_ns > memory.time_ns:
        catch_up(memory)
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns >= 0 and dt > STALE_S:
        memory.known = 0
        memory.unbroken[0] = memory.unbroken[1] = 0
        memory.first_mps = np.nan
        memory.refused_ns[:] = -1
        memory.mean_innovation_ns = -1
        memory.flags |= RESTARTED
    elif memory.time_ns >= 0 and dt > 0.0 and memory.known:
        memory.travelled_m += memory.x[V] * dt
        forget_accelerations(dt, memory)
        jerk, wheel, both = jerk_densities(has_accelerometer(memory), tuning, memory)
        fading = fading_s(tuning, memory)
        front_turn_mps = nominal.wheelbase_m * memory.yaw_rate
        motion.step(memory.x, memory.rim_mps, front_turn_mps, fading, dt, tuning, f)
        receiver = (
            memory.noise_factor[FROM_GNSS] * (tuning.gnss_bias_share * nominal.velocity_sd_mps) ** 2
        )
        quick = memory.noise_factor[FROM_TOWED] * tuning.towed_fast_sd**2
        turn = front_turn_mps / max(abs(memory.x[V]), SLOW_MPS)
        camera, gravity = memory.camera_psd, nominal.gravity
        motion.noise(f, jerk, wheel, both, receiver, quick, turn, camera, gravity, dt, tuning, q)
        motion.propagate_covariance(memory.p, f, q, scratch)
        memory.cut[:] = 0
        if memory.keeps:
            memory.gained[:] = 0.0
            memory.lost[:, :] = 0.0
    memory.time_ns = max(memory.time_ns, epoch_ns)
