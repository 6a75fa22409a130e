"""How the state moves: x <- f(x),  P <- F P F^T + Q,  with F = df/dx.

With the rates w = (p, q, r) and the forces (f_x, f_y) that the IMU feels, less their errors:

    v_x' = f_x + g sin(pitch) + r v_y          v_y' = f_y - g cos(pitch) sin(roll) - r v_x
    heading' = (q sin(roll) + r cos(roll)) / cos(pitch)
    roll' = p + heading' sin(pitch)            pitch' = q cos(roll) - r sin(roll)
    (east', north') = R(heading) (v_x cos(grade), left)
    left = v_y cos(a) - v_x sin(a) (pitch + grade)
    slide_rear' = v_y    slide' = v_y + x_cg r    aside' = body_left + x_c r - z_c p

The velocity lies in the ground plane, which leans by a across the machine and rises by the grade
along it; the body leans otherwise where it sinks in, and a camera and antennas lean with the body.
A force that nobody feels is zero and its bias a walk.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.kalman import Array, Record
from estimators.sideslip_ekf.layout import (
    ASIDE,
    BIAS_P,
    BIAS_Q,
    BIAS_R,
    BIAS_X,
    BIAS_Y,
    CAMERA_PITCH,
    CAMERA_SCALE,
    CAMERA_YAW,
    COMPLIANCE,
    EAST,
    F_X,
    F_Y,
    GYRO_SCALE,
    HEADING,
    MISALIGNED,
    NORTH,
    P_RATE,
    PITCH,
    PUSH,
    Q_RATE,
    R_RATE,
    RECEIVER_E,
    RECEIVER_N,
    ROLL,
    SIZE,
    SLIDE,
    SLIDE_REAR,
    V_X,
    V_Y,
)  # fmt: skip
from twin.compute.compiled import array_law

ROLLS = 0.06
"""A body leans by this share more than the ground, as load goes to its lower wheels: m g h over the
roll stiffness k b^2 / 2 of two tyres; 3 t at 0.8 m on 350 kN/m, 1.6 m apart (derived)."""
HALF_TRACK_M, SINKS_S = 0.9, 1.0
"""From the middle of the body to a wheel that drops into a furrow [m], and how long it drops
[s]."""
EARLY, EARLY_S = 100.0, 5.0
"""How much quicker than later the push of an implement changes at first, and for how long [s]."""

Places = NDArray[np.int64]
"""Rows and columns, (ENTRIES, 2)."""


@array_law
def turning(x: Array, imu: Array) -> float:
    """Yaw rate of the body about its own axis, r = gyro (1 - scale) - bias [rad/s]."""
    return float(imu[R_RATE] * (1.0 - x[GYRO_SCALE]) - x[BIAS_R])


@array_law
def across(x: Array, memory: Record) -> float:
    """How the ground leans across the machine, its left up [rad].

    A machine that pulls stands in a furrow; the ground is as it was felt before.
    """
    if memory.pulls and memory.surveyed:
        left = memory.ground[1] * math.cos(x[HEADING]) - memory.ground[0] * math.sin(x[HEADING])
        return math.atan(left)
    return float(x[ROLL] / (1.0 + ROLLS))


@array_law
def sinking(x: Array, imu: Array) -> float:
    """How fast a body that rolls rises or sinks [m/s]: one of its wheels does, the other not.

    Nothing measures it; on a slope, and in a body that leans, some of it is lateral.
    """
    return float(HALF_TRACK_M * abs(imu[P_RATE] - x[BIAS_P]))


@array_law
def stance(x: Array, lean: float, memory: Record) -> tuple[float, float]:
    """How the body stands on the ground: left up by s, and nose down by t [rad].

    A camera sees the ground's normal lean by (k, l) in its own axes; else how body and ground lean
    tells it:

        tan(s) = k sin(c) + l cos(c)          or  s = roll - a
        t = (camera's nose up - k cos(c) + l sin(c)) cos(s)    pitch + grade
    """
    if not memory.tilted:
        return float(x[ROLL] - lean), float(x[PITCH] + memory.grade)
    cos, sin = math.cos(x[CAMERA_YAW]), math.sin(x[CAMERA_YAW])
    sunk = math.atan(memory.tilt[0] * sin + memory.tilt[1] * cos)
    nose = x[CAMERA_PITCH] - memory.tilt[0] * cos + memory.tilt[1] * sin
    return float(sunk), float(nose * math.cos(sunk))


@array_law
def body_left(v_x: float, v_y: float, x: Array, lean: float, memory: Record) -> float:
    """Velocity along the body's own left [m/s]: v_y cos(s) + v_x sin(s) t, of its `stance`."""
    sunk, nose = stance(x, lean, memory)
    return float(v_y * math.cos(sunk) + v_x * math.sin(sunk) * nose)


@array_law
def body_left_by(x: Array, lean: float, memory: Record) -> tuple[float, float, float, float]:
    """Derivatives of `body_left` by v_x, v_y, and what the nose and the lean are told by.

    Those are camera's pitch and yaw, or the body's pitch and roll.
    """
    sunk, nose = stance(x, lean, memory)
    cos, sin = math.cos(sunk), math.sin(sunk)
    by_lean = x[V_X] * cos * nose - x[V_Y] * sin
    if not memory.tilted:
        return sin * nose, cos, sin * x[V_X], by_lean
    ahead, left = memory.tilt[0], memory.tilt[1]
    leans = (ahead * math.cos(x[CAMERA_YAW]) - left * math.sin(x[CAMERA_YAW])) * cos * cos
    noses = sin - nose * math.tan(sunk) * leans
    return sin * nose, cos, sin * x[V_X] * cos, by_lean * leans + sin * x[V_X] * noses


@array_law
def step(x: Array, imu: Array, lean: float, dt: float, nominal: Record, memory: Record) -> None:
    """Carry the mean, in place.

    Args:
        x: mean, (SIZE,).
        imu: rates and forces over the step, (5,).
        lean: `across`.
        dt: the step [s].
        nominal, memory: records.
    """
    g, grade = nominal.gravity_mps2, memory.grade
    p, q, r = imu[P_RATE] - x[BIAS_P], imu[Q_RATE] - x[BIAS_Q], turning(x, imu)
    sin_roll, cos_roll = math.sin(x[ROLL]), math.cos(x[ROLL])
    sin_pitch, cos_pitch = math.sin(x[PITCH]), math.cos(x[PITCH])
    v_x, v_y = x[V_X], x[V_Y]
    yaw = (q * sin_roll + r * cos_roll) / cos_pitch
    ahead = 0.0
    if memory.heard[F_X]:
        ahead = imu[F_X] - x[BIAS_X] + g * sin_pitch + r * v_y
    aside = 0.0
    if memory.heard[F_Y]:
        aside = imu[F_Y] - x[BIAS_Y] - g * cos_pitch * sin_roll - r * v_x
    x[V_X] += ahead * dt
    x[V_Y] += aside * dt
    mean_x, mean_y = v_x + 0.5 * ahead * dt, v_y + 0.5 * aside * dt
    heading = x[HEADING] + 0.5 * yaw * dt
    left = mean_y * math.cos(lean) - mean_x * math.sin(lean) * (x[PITCH] + grade)
    flat = mean_x * math.cos(grade)
    x[EAST] += (math.cos(heading) * flat - math.sin(heading) * left) * dt
    x[NORTH] += (math.sin(heading) * flat + math.cos(heading) * left) * dt
    x[SLIDE_REAR] += mean_y * dt
    x[SLIDE] += (mean_y + nominal.cg_x_m * r) * dt
    beside = body_left(mean_x, mean_y, x, lean, memory)
    x[ASIDE] += (beside + nominal.camera_m[0] * r - nominal.camera_m[2] * p) * dt
    x[HEADING] += yaw * dt
    if memory.heard[F_Y]:
        x[ROLL] += (p + yaw * sin_pitch) * dt
        x[PITCH] += (q * cos_roll - r * sin_roll) * dt


@array_law
def entries(
    x: Array, imu: Array, lean: float, dt: float, nominal: Record, memory: Record,
    at: Places, value: Array,
) -> int:  # fmt: skip
    """Add a step to F - I, before the mean is carried; returns how many places are not zero.

    F of several steps is taken as I and the sum of the others' F - I: they are short.

    Args:
        x, imu, lean, dt, nominal, memory: as in `step`.
        at: row and column of each place, (ENTRIES, 2), filled.
        value: F - I there, (ENTRIES,), added to.
    """
    g, grade = nominal.gravity_mps2, memory.grade
    q, r, gyro = imu[Q_RATE] - x[BIAS_Q], turning(x, imu), imu[R_RATE]
    sin_roll, cos_roll = math.sin(x[ROLL]), math.cos(x[ROLL])
    sin_pitch, cos_pitch = math.sin(x[PITCH]), math.cos(x[PITCH])
    v_x, v_y = x[V_X], x[V_Y]
    by_r = cos_roll / cos_pitch
    yaw = q * sin_roll / cos_pitch + r * by_r
    yaw_roll = (q * cos_roll - r * sin_roll) / cos_pitch
    yaw_pitch = yaw * sin_pitch / cos_pitch
    felt_s = dt if memory.heard[F_X] else 0.0
    n = _put(at, value, 0, V_X, BIAS_X, -felt_s)
    n = _put(at, value, n, V_X, PITCH, g * cos_pitch * felt_s)
    n = _put(at, value, n, V_X, V_Y, r * felt_s)
    n = _put(at, value, n, V_X, BIAS_R, -v_y * felt_s)
    n = _put(at, value, n, V_X, GYRO_SCALE, -gyro * v_y * felt_s)
    felt_s = dt if memory.heard[F_Y] else 0.0
    n = _put(at, value, n, V_Y, BIAS_Y, -felt_s)
    n = _put(at, value, n, V_Y, ROLL, -g * cos_pitch * cos_roll * felt_s)
    n = _put(at, value, n, V_Y, PITCH, g * sin_pitch * sin_roll * felt_s)
    n = _put(at, value, n, V_Y, V_X, -r * felt_s)
    n = _put(at, value, n, V_Y, BIAS_R, v_x * felt_s)
    n = _put(at, value, n, V_Y, GYRO_SCALE, gyro * v_x * felt_s)
    n = _put(at, value, n, HEADING, BIAS_R, -by_r * dt)
    n = _put(at, value, n, HEADING, GYRO_SCALE, -gyro * by_r * dt)
    n = _put(at, value, n, HEADING, BIAS_Q, -sin_roll / cos_pitch * dt)
    n = _put(at, value, n, HEADING, ROLL, yaw_roll * dt)
    n = _put(at, value, n, HEADING, PITCH, yaw_pitch * dt)
    n = _put(at, value, n, ROLL, BIAS_P, -felt_s)
    n = _put(at, value, n, ROLL, ROLL, yaw_roll * sin_pitch * felt_s)
    n = _put(at, value, n, ROLL, BIAS_R, -by_r * sin_pitch * felt_s)
    n = _put(at, value, n, ROLL, GYRO_SCALE, -gyro * by_r * sin_pitch * felt_s)
    n = _put(at, value, n, ROLL, BIAS_Q, -sin_roll / cos_pitch * sin_pitch * felt_s)
    n = _put(at, value, n, ROLL, PITCH, (yaw * cos_pitch + yaw_pitch * sin_pitch) * felt_s)
    n = _put(at, value, n, PITCH, BIAS_Q, -cos_roll * felt_s)
    n = _put(at, value, n, PITCH, BIAS_R, sin_roll * felt_s)
    n = _put(at, value, n, PITCH, GYRO_SCALE, gyro * sin_roll * felt_s)
    n = _put(at, value, n, PITCH, ROLL, -(q * sin_roll + r * cos_roll) * felt_s)
    cos, sin = math.cos(x[HEADING]), math.sin(x[HEADING])
    by_x, by_y = -math.sin(lean) * (x[PITCH] + grade), math.cos(lean)
    left = v_x * by_x + v_y * by_y
    flat, by_pitch = v_x * math.cos(grade), -v_x * math.sin(lean)
    n = _put(at, value, n, EAST, V_X, (cos * math.cos(grade) - sin * by_x) * dt)
    n = _put(at, value, n, NORTH, V_X, (sin * math.cos(grade) + cos * by_x) * dt)
    n = _put(at, value, n, EAST, V_Y, -sin * by_y * dt)
    n = _put(at, value, n, NORTH, V_Y, cos * by_y * dt)
    n = _put(at, value, n, EAST, HEADING, -(sin * flat + cos * left) * dt)
    n = _put(at, value, n, NORTH, HEADING, (cos * flat - sin * left) * dt)
    n = _put(at, value, n, EAST, PITCH, -sin * by_pitch * dt)
    n = _put(at, value, n, NORTH, PITCH, cos * by_pitch * dt)
    n = _put(at, value, n, SLIDE_REAR, V_Y, dt)
    n = _put(at, value, n, SLIDE, V_Y, dt)
    by_x, by_y, by_nose, by_lean = body_left_by(x, lean, memory)
    felt_s, seen_s = (0.0, dt) if memory.tilted else (dt, 0.0)
    n = _put(at, value, n, ASIDE, V_Y, by_y * dt)
    n = _put(at, value, n, ASIDE, V_X, by_x * dt)
    n = _put(at, value, n, ASIDE, PITCH, by_nose * felt_s)
    n = _put(at, value, n, ASIDE, ROLL, by_lean * felt_s)
    n = _put(at, value, n, ASIDE, CAMERA_PITCH, by_nose * seen_s)
    n = _put(at, value, n, ASIDE, CAMERA_YAW, by_lean * seen_s)
    n = _put(at, value, n, SLIDE, BIAS_R, -nominal.cg_x_m * dt)
    n = _put(at, value, n, SLIDE, GYRO_SCALE, -nominal.cg_x_m * gyro * dt)
    n = _put(at, value, n, ASIDE, BIAS_R, -nominal.camera_m[0] * dt)
    n = _put(at, value, n, ASIDE, GYRO_SCALE, -nominal.camera_m[0] * gyro * dt)
    return _put(at, value, n, ASIDE, BIAS_P, nominal.camera_m[2] * dt)


@array_law
def _put(at: Places, value: Array, n: int, row: int, column: int, what: float) -> int:
    at[n, 0], at[n, 1] = row, column
    value[n] += what
    return n + 1


@array_law
def carry(p: Array, at: Places, value: Array, n: int, room: Array) -> None:
    """P <- F P F^T, from the places of F - I alone; P stays symmetric to the bit.

    Args:
        p: covariance, (SIZE, SIZE), changed in place.
        at, value, n: of `entries`.
        room: (SIZE, SIZE), overwritten.
    """
    room[:, :] = p
    for k in range(n):
        row, column, by = at[k, 0], at[k, 1], value[k]
        for j in range(SIZE):
            p[row, j] += by * room[column, j]
    for i in range(SIZE):  # transposed, so that the second product goes along rows, too
        for j in range(SIZE):
            room[i, j] = p[j, i]
    for i in range(SIZE):
        for j in range(SIZE):
            p[i, j] = room[i, j]
    for k in range(n):
        row, column, by = at[k, 0], at[k, 1], value[k]
        for j in range(SIZE):
            p[row, j] += by * room[column, j]
    for i in range(SIZE):
        for j in range(i):
            p[i, j] = p[j, i]


@array_law
def slide_on(x: Array, p: Array, faster_mps: float) -> None:
    """Where no force is felt a slide stays at its angle as the speed grows: v_y' = push v_x'.

    Else a slide that lasts would be told from antennas that stand askew whenever the speed changes.
    """
    x[V_Y] += x[PUSH] * faster_mps
    for i in range(SIZE):
        p[V_Y, i] += faster_mps * p[PUSH, i]
    for i in range(SIZE):
        p[i, V_Y] += faster_mps * p[i, PUSH]


@array_law
def noise(
    x: Array, p: Array, imu: Array, dt: float, nominal: Record, tuning: Record, memory: Record,
    way: Array,
) -> None:  # fmt: skip
    """P <- P + Q of a step; what is forgotten fades in mean and covariance.

    Args:
        x, p: mean and covariance, changed in place.
        imu, dt, nominal, memory: as in `step`.
        tuning: record of the filter's constants.
        way: room, (SIZE,).
    """
    sin_roll, cos_roll = math.sin(x[ROLL]), math.cos(x[ROLL])
    gyro = nominal.gyro_density**2
    # a unit that is set askew feels a part of one turning as another
    felt = imu[P_RATE] ** 2 + imu[Q_RATE] ** 2 + imu[R_RATE] ** 2
    askew = tuning.askew_s * tuning.askew_rad**2
    by_p, by_q = askew * (felt - imu[P_RATE] ** 2), askew * (felt - imu[Q_RATE] ** 2)
    by_r = askew * (felt - imu[R_RATE] ** 2)
    psd = gyro * memory.excess + by_r if memory.heard[R_RATE] else tuning.free_turn_psd
    way[:] = 0.0
    way[HEADING], way[SLIDE], way[ASIDE] = cos_roll, nominal.cg_x_m, nominal.camera_m[0]
    if memory.heard[F_Y]:
        way[V_Y], way[V_X] = -x[V_X], x[V_Y]
    way[PITCH] = -sin_roll
    _grow(p, way, psd * dt)
    way[:] = 0.0
    way[ROLL], way[ASIDE] = 1.0, -nominal.camera_m[2]
    _grow(p, way, (gyro + by_p if memory.heard[F_Y] else 0.0) * dt)
    way[:] = 0.0
    way[PITCH], way[HEADING] = cos_roll, sin_roll
    _grow(p, way, (gyro + by_q if memory.heard[F_Y] else 0.0) * dt)
    way[:] = 0.0
    way[EAST], way[NORTH] = -math.sin(x[HEADING]), math.cos(x[HEADING])
    _grow(p, way, SINKS_S * (math.sin(across(x, memory)) * sinking(x, imu)) ** 2 * dt)
    free = tuning.free_psd * memory.unrest
    p[V_X, V_X] += (memory.accel_psd if memory.heard[F_X] else 4.0 * free) * dt
    rolls = SINKS_S * (sinking(x, imu) * (imu[P_RATE] - x[BIAS_P])) ** 2
    walk(p, memory.accel_psd + rolls if memory.heard[F_Y] else free, dt)
    for bias in (BIAS_P, BIAS_Q, BIAS_R):
        p[bias, bias] += tuning.gyro_bias_psd * dt
    for bias in (BIAS_X, BIAS_Y):
        p[bias, bias] += tuning.accel_bias_psd * dt
    # and as a body rolls, gravity's share across as one ahead
    p[BIAS_X, BIAS_X] += askew * (nominal.gravity_mps2 * imu[P_RATE]) ** 2 * dt
    lasting = tuning.lasting_share * nominal.position_sd_m
    for state in (RECEIVER_E, RECEIVER_N):
        fade(x, p, state, tuning.receiver_s, lasting, dt)
    p[MISALIGNED, MISALIGNED] += tuning.misaligned_psd * dt
    p[COMPLIANCE, COMPLIANCE] += tuning.compliance_psd * dt
    if memory.pulls:
        early = EARLY * math.exp(-memory.pulls_s / EARLY_S)
        memory.pulls_s += dt
        p[PUSH, PUSH] += (1.0 + early) * tuning.push_psd * dt
    p[CAMERA_YAW, CAMERA_YAW] += tuning.camera_yaw_psd * dt
    p[CAMERA_SCALE, CAMERA_SCALE] += dt * (
        tuning.camera_work_psd if memory.pulls else tuning.camera_scale_psd
    )


@array_law
def fade(x: Array, p: Array, state: int, lasts_s: float, sd: float, dt: float) -> None:
    """x' = -x / lasts + white,  which keeps the variance sd^2."""
    keep = math.exp(-dt / lasts_s)
    x[state] *= keep
    for i in range(SIZE):
        p[state, i] *= keep
        p[i, state] *= keep
    p[state, state] += sd**2 * (1.0 - keep**2)


@array_law
def walk(p: Array, psd: float, dt: float) -> None:
    """What a white lateral acceleration adds to v_y and to its integrals."""
    p[V_Y, V_Y] += psd * dt
    for i in (SLIDE, SLIDE_REAR, ASIDE):
        p[V_Y, i] += psd * dt * dt / 2.0
        p[i, V_Y] += psd * dt * dt / 2.0
        for j in (SLIDE, SLIDE_REAR, ASIDE):
            p[i, j] += psd * dt**3 / 3.0


@array_law
def _grow(p: Array, way: Array, by: float) -> None:
    if by > 0.0:
        for i in range(SIZE):
            if way[i] != 0.0:
                for j in range(SIZE):
                    if way[j] != 0.0:
                        p[i, j] += by * way[i] * way[j]
