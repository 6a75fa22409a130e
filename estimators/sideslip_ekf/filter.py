"""The loop: samples in order of their epochs, and what is told brought up to now."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.sideslip_ekf import ground, motion, rows
from estimators.sideslip_ekf.gnss import take_gnss
from estimators.sideslip_ekf.law import take_speed
from estimators.sideslip_ekf.layout import (
    ASIDE,
    BIAS_X,
    BIAS_Y,
    CAMERA,
    CAMERA_PITCH,
    CAMERA_PULL,
    CAMERA_SCALE,
    CAMERA_YAW,
    COMPLIANCE,
    EAST,
    ENTRIES,
    F_X,
    F_Y,
    FRAME,
    GNSS,
    HEADING,
    IMU,
    NORTH,
    PITCH,
    PUSH,
    RECEIVER_E,
    RECEIVER_N,
    ROLL,
    SIZE,
    SLIDE,
    SLIDE_REAR,
    V_X,
    V_Y,
    WHEELS,
)  # fmt: skip
from estimators.sideslip_ekf.queue import arrive, drop_first, first_is_due, imu_at, wait, wait_frame
from estimators.sideslip_ekf.report import report
from estimators.sideslip_ekf.update import restart, take
from twin.compute.compiled import array_law, compiled

FREE_RAD2, FREE_MPS, FREE_M = 10.0, 10.0, 1e3
"""Variance of a heading, sd of a speed and of a place that nothing is known of."""
SAME_S = 0.001
"""Instants as near as this are one."""
LAPSE_S = 0.06
"""The covariance is not carried more often than a measurement or this time asks [s]."""
SHARE = 0.5
"""What of the variance from sample to sample is white: the rest is an engine."""
ACCEL_PSD, SETTLE, MOST_SQUARE = 5e-5, 100.0, 9.0
"""Density of the forces' noise at first [m2/s3], samples over which it is averaged, and what a
square counts at most over the mean."""
HELD_NS = 100_000_000
"""Without an IMU for so long, the samples of the wheels carry the state on."""
STEEPEST = 0.5
"""Sine of the steepest lean that a first sample tells."""
GATE = 4.0
"""An error beyond so many sd moves nothing further."""


@compiled
def loop(
    sensor: Any, row: Any, epoch_ns: Any, gnss: Array, imu: Array, camera: Array, clear: Array,
    speed: Array, nominal: Record, tuning: Record, memory: Record, out: Array, kept: Any,
) -> int:  # fmt: skip
    """Take a chunk's samples, and fill a row of `out` for each row of `speed`.

    Args:
        sensor, row, epoch_ns: of each sample in order of arrival.
        gnss, imu, camera: values by sensor, in the columns of `layout.READ`.
        clear: 1 with the plough out of the ground, 0 in it, NaN unknown, of each sample.
        speed: ground speed, its sd, slip, and room, of each wheel sample that the slip filter
            accepted.
        nominal, tuning, memory: records; `memory` is changed.
        out: (n, 7).
        kept: room for innovations, records of KEPT, where `memory.notes` wants them.

    Returns:
        How many innovations were kept.
    """
    n = count = 0
    room = np.empty((SIZE, SIZE))
    h, x = np.zeros(SIZE), np.zeros(SIZE)
    at = np.zeros((ENTRIES, 2), np.int64)
    now, mean = np.zeros(5), np.zeros(5)
    motion.entries(memory.x, now, 0.0, 0.0, nominal, memory, at, memory.change)  # the places
    for i in range(len(sensor)):
        kind, epoch = sensor[i], epoch_ns[i]
        if epoch <= memory.last_ns[kind]:
            continue
        memory.last_ns[kind] = epoch
        arrive(epoch, memory)
        stale = (memory.newest_ns - epoch) * 1e-9 > STALE_S
        if kind == WHEELS:
            if stale:
                continue
            speed[n, 3] = clear[i]
            wait(epoch, kind, speed[n], memory)
        elif stale:
            continue
        elif kind == GNSS:
            wait(epoch, kind, gnss[row[i]], memory)
        elif kind == IMU:
            wait(epoch, kind, imu[row[i]], memory)
        elif kind == CAMERA and camera[row[i], 6] == 1.0:
            wait_frame(epoch, camera[row[i]], memory)
        while first_is_due(memory):
            _take_first(h, at, room, now, mean, nominal, tuning, memory)
            for k in range(memory.notes.count):
                kept[count].epoch_ns, kept[count].sensor = memory.epoch_ns, GNSS
                kept[count].innovation = memory.notes.innovation[k]
                kept[count].variance = memory.notes.variance[k]
                count += 1
            memory.notes.count = 0
        if kind == WHEELS:
            report(out[n], x, now, mean, nominal, tuning, memory)
            n += 1
    return count


@array_law
def _take_first(
    h: Array, at: motion.Places, room: Array, now: Array, mean: Array, nominal: Record,
    tuning: Record, memory: Record,
) -> None:  # fmt: skip
    """Carry the state to the oldest sample that waits, and take it.

    What the slip filter says is slow: it is taken with the next of the others.
    """
    kind, epoch = memory.waiting[0].sensor, memory.waiting[0].epoch_ns
    values = memory.waiting[0].values.copy()
    if kind != WHEELS or memory.imu_ns < 0 or epoch - memory.imu_ns > HELD_NS:
        imu_at(epoch, memory, now)
        _carry(epoch, at, now, mean, nominal, memory, tuning)
    drop_first(memory)
    if kind == IMU:
        learn_noise(values, (epoch - memory.imu_ns) * 1e-9, nominal, memory)
        memory.imu_ns = epoch
        _hear(values, nominal, tuning, memory)
    elif kind == WHEELS:
        memory.speed_ns = epoch
        for i in range(4):
            memory.speed[i] = values[i]
    if memory.lapse_s >= LAPSE_S or kind in (GNSS, CAMERA, FRAME):
        _settle(h, at, room, nominal, tuning, memory)
    if kind == GNSS:
        take_gnss(values, h, nominal, tuning, memory)
    elif kind == CAMERA and memory.known:
        lean = motion.across(memory.x, memory)
        foretold = rows.camera_ahead(memory.x, memory.imu, lean, nominal, memory, h)
        r = values[2] + (tuning.camera_ahead_sd * values[0]) ** 2
        take(memory.x, memory.p, h, values[0] - foretold, r, GATE)
    elif kind == FRAME:
        _take_frame(values, h, nominal, tuning, memory)


@array_law
def _carry(
    epoch_ns: int, at: motion.Places, now: Array, mean: Array, nominal: Record, memory: Record,
    tuning: Record,
) -> None:  # fmt: skip
    """Carry the mean to an epoch; after a gap start again, with the biases that are known."""
    dt = (epoch_ns - memory.epoch_ns) * 1e-9
    if memory.epoch_ns < 0 or dt > STALE_S:
        forget(now, nominal, tuning, memory)
    elif dt <= 0.0:
        return
    else:
        over_step(now, dt, mean, nominal, memory)
        ground.feel(mean, dt, memory)
        if memory.known:
            x = memory.x
            lean = motion.across(x, memory)
            motion.entries(x, mean, lean, dt, nominal, memory, at, memory.change)
            motion.step(x, mean, lean, dt, nominal, memory)
            ground.survey(motion.turning(x, mean), dt, memory)
            memory.lapse_s += dt
    memory.imu[:] = now
    memory.epoch_ns = max(memory.epoch_ns, epoch_ns)


@array_law
def _settle(
    h: Array, at: motion.Places, room: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    """Carry the covariance after the mean, and take what the slip filter said since."""
    if memory.lapse_s > 0.0:
        motion.carry(memory.p, at, memory.change, ENTRIES, room)
        motion.noise(memory.x, memory.p, memory.imu, memory.lapse_s, nominal, tuning, memory, h)
        memory.change[:] = 0.0
        memory.lapse_s = 0.0
        if not memory.heard[F_Y]:
            motion.slide_on(memory.x, memory.p, memory.x[V_X] - memory.faster_mps)
            memory.faster_mps = memory.x[V_X]
    if memory.speed_ns >= 0:
        take_speed(memory.speed, h, nominal, tuning, memory)
        memory.speed_ns = -1


@array_law
def _hear(values: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """What the IMU has values of; with the first force across, the body's lean is told."""
    if math.isfinite(values[F_Y]) and not memory.heard[F_Y]:
        _lean(values, nominal, tuning, memory.x, memory.p)
        restart(memory.x, memory.p, PUSH, 0.0, 0.0)
        memory.placed = 0  # where the antenna is no longer tells where the axle is
    for i in range(5):
        if math.isfinite(values[i]):
            memory.heard[i] = 1


@array_law
def learn_noise(values: Array, dt: float, nominal: Record, memory: Record) -> None:
    """Density of the white noise of the forces, never below the data sheet's.

    d = f_k - 2 f_k-1 + f_k-2,   E d^2 = 6 var   for white noise; motion hardly enters d
    """
    square = 0.0
    for i in range(2):
        force = values[F_X + i]
        square += (force - 2.0 * memory.accel[i, 0] + memory.accel[i, 1]) ** 2 / 12.0
        memory.accel[i, 1] = memory.accel[i, 0]
        memory.accel[i, 0] = force
    least = nominal.accel_density**2
    if memory.accel_psd == 0.0:
        memory.accel_psd = ACCEL_PSD
    if math.isfinite(square) and 0.0 < dt < STALE_S:
        known = max(memory.accel_psd, least)
        psd = min(SHARE * square * dt, MOST_SQUARE * known)
        memory.accel_psd = max(known + (psd - known) / SETTLE, least)


@array_law
def over_step(now: Array, dt: float, mean: Array, nominal: Record, memory: Record) -> None:
    """Rates and forces over a step, the forces brought from the unit to the rear axle.

    f_axle = f - dw/dt x l - w x (w x l)
    """
    l_x, l_y, l_z = nominal.imu_m
    for i in range(5):
        mean[i] = 0.5 * (memory.imu[i] + now[i])
    p1, q1 = (now[0] - memory.imu[0]) / dt, (now[1] - memory.imu[1]) / dt
    r1 = (now[2] - memory.imu[2]) / dt
    mean[F_X] -= q1 * l_z - r1 * l_y - mean[2] ** 2 * l_x
    mean[F_Y] -= r1 * l_x - p1 * l_z - mean[2] ** 2 * l_y


@array_law
def forget(felt: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """Speeds, heading, attitude and place become unknown, as after a gap; the biases stay.

    The body leans as the first sample of the IMU feels it.

    What slid in a gap nobody knows: the slides' sd counts from here on.
    """
    x, p = memory.x, memory.p
    if memory.epoch_ns < 0:
        _begin(nominal, tuning, x, p)
    memory.known, memory.placed, memory.fixed, memory.frame_ns = 0, 0, 0, -1
    memory.law_ns = memory.speed_ns = -1
    memory.lapse_s, memory.tilted = 0.0, 0
    memory.change[:] = 0.0
    lasting = (tuning.lasting_share * nominal.position_sd_m) ** 2
    for state, var in (
        (V_X, FREE_MPS**2), (V_Y, 1.0), (HEADING, FREE_RAD2), (EAST, FREE_M**2),
        (NORTH, FREE_M**2), (RECEIVER_E, lasting), (RECEIVER_N, lasting),
        (CAMERA_PULL, tuning.camera_pull_sd_mps**2), (ASIDE, 0.0), (PUSH, 0.0),
    ):  # fmt: skip
        restart(x, p, state, 0.0, var)
    _lean(felt, nominal, tuning, x, p)
    for state in (SLIDE, SLIDE_REAR):
        restart(x, p, state, x[state], 0.0)
    memory.pulls = 0
    memory.faster_mps = 0.0
    memory.lateral_psd, memory.unrest = tuning.frame_psd, 1.0
    ground.forget(memory)


@array_law
def _lean(felt: Array, nominal: Record, tuning: Record, x: Array, p: Array) -> None:
    """How a body leans that stands or drives steadily: f_y = g sin(roll), f_x = -g sin(pitch)."""
    g = max(nominal.gravity_mps2, 1.0)
    for state, sign, force, bias in ((ROLL, 1.0, F_Y, BIAS_Y), (PITCH, -1.0, F_X, BIAS_X)):
        share = (felt[force] - x[bias]) / g if nominal.gravity_mps2 > 0.0 else 0.0
        mean = (
            sign * math.asin(min(max(share, -STEEPEST), STEEPEST)) if math.isfinite(share) else 0.0
        )
        restart(x, p, state, mean, tuning.lean_sd**2)


@array_law
def _begin(nominal: Record, tuning: Record, x: Array, p: Array) -> None:
    """What is known of the sensors' errors before the first sample."""
    for state, mean, sd in (
        (7, 0.0, nominal.gyro_bias_sd_radps), (8, 0.0, nominal.gyro_bias_sd_radps),
        (9, 0.0, nominal.gyro_bias_sd_radps), (10, 0.0, tuning.gyro_scale_sd),
        (11, 0.0, nominal.accel_bias_sd_mps2), (12, 0.0, nominal.accel_bias_sd_mps2),
        (13, 0.0, tuning.misaligned_sd), (COMPLIANCE, tuning.compliance, tuning.compliance_sd),
        (CAMERA_YAW, 0.0, tuning.camera_yaw_sd), (CAMERA_PITCH, 0.0, tuning.camera_pitch_sd),
        (CAMERA_SCALE, 0.0, tuning.camera_scale_sd),
    ):  # fmt: skip
        restart(x, p, state, mean, sd**2)


@array_law
def _take_frame(values: Array, h: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """Path to the left from the frame before, at this one.

    The density q of the lateral speed's walk from frame to frame follows the innovation i and its
    variance s, q += 3 (i^2 - s) / memory; an i beyond three sd is a slide that begins, a walk of
    3 i^2 / T.
    """
    ahead, span_s = values[0], values[3]
    memory.tilted = 1 if math.isfinite(values[4] + values[5]) else 0
    for i in range(2):
        memory.tilt[i] = math.tan(values[4 + i]) if memory.tilted else 0.0
    x, p = memory.x, memory.p
    known_s = (memory.epoch_ns - memory.frame_ns) * 1e-9 if memory.frame_ns >= 0 else 1e9
    follows = abs(known_s - span_s) < SAME_S
    memory.frame_ns = memory.epoch_ns
    if not memory.known:
        x[V_X], memory.known = ahead, 1
    else:
        lean = motion.across(x, memory)
        beside = rows.camera_left(x, memory.imu, lean, nominal, memory)
        frame = np.array([ahead, values[1], span_s])
        error = -rows.camera_aside(x, frame, follows, beside, lean, nominal, memory, h)
        r = values[2] + (math.sin(x[CAMERA_YAW]) * tuning.camera_ahead_sd * ahead) ** 2
        r += 0.0 if follows else memory.lateral_psd * span_s / 3.0
        sunk, _ = motion.stance(x, lean, memory)
        sinks = math.sin(sunk) * motion.sinking(x, memory.imu)
        r += sinks**2 * max(motion.SINKS_S / span_s, 1.0)
        take(x, p, h, error, r, GATE)
        memory.lateral_ns = memory.camera_ns = memory.epoch_ns
    restart(x, p, ASIDE, 0.0, 0.0)
