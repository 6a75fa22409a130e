"""What a GNSS sample tells: azimuth of the baseline, velocity, and place where it is fixed."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.sideslip_ekf import ground, motion, rows
from estimators.sideslip_ekf.layout import (
    BIAS_P,
    BIAS_Q,
    F_Y,
    HEADING,
    P_RATE,
    Q_RATE,
    V_X,
    V_Y,
)  # fmt: skip
from estimators.sideslip_ekf.place import noted, take_place, unfelt
from estimators.sideslip_ekf.update import restart, take, variance
from estimators.slip_ekf.learn import factor
from twin.compute.compiled import array_law

GATE = 3.0
"""An error beyond so many sd moves nothing further."""
MOVING_MPS = 0.5
"""Below this speed no course is taken for a heading."""
BASELINE_SD, COURSE_SD = 0.05, 0.2
"""sd of a first heading from the baseline and from the course [rad]."""
DOUBT, LEAPS = 0.3, 3
"""By such a share of its square an error of heading beyond the gate is that of what predicted it,
and wholly after so many in a row."""
LEAST_UNREST, MOST_UNREST = 0.1, 1e3
"""Factor of the motion that nothing feels."""
DUE, MOST_EXCESS = 1.3, 1e7
"""Mean e^2 / S above which the gyro seems noisier than stated, and how much noisier at most."""


@array_law
def take_gnss(values: Array, h: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """Take what there is of one sample, at its epoch."""
    east, north, up, azimuth, quality = values[0], values[1], values[2], values[3], values[4]
    seen = quality != 0.0 and math.isfinite(east) and math.isfinite(north)
    x, p = memory.x, memory.p
    if p[HEADING, HEADING] > ground.UNKNOWN_RAD2:
        _begin(east, north, azimuth, seen, nominal, memory)
        if p[HEADING, HEADING] > ground.UNKNOWN_RAD2:
            return
    if math.isfinite(azimuth):
        sd = values[6] if values[6] > 0.0 else nominal.heading_sd_rad
        error = wrapped(azimuth - rows.azimuth(x, nominal.mount_rad, h))
        unfelt(h, memory)
        if error**2 > GATE**2 * (variance(p, h) + sd**2):  # the gyro missed a turn, or it leaps
            p[HEADING, HEADING] += (1.0 if memory.leapt >= LEAPS else DOUBT) * error**2
        nis = take(x, p, h, error, sd**2, GATE)
        noted(error, nis, memory)
        memory.excess = factor(memory.excess, nis, DUE, 1.0, MOST_EXCESS)
        memory.leapt = memory.leapt + 1 if nis > GATE**2 else 0
    if seen:
        sd = values[5] if values[5] > 0.0 else nominal.velocity_sd_mps
        _take_velocity(east, north, up, sd, h, nominal, tuning, memory)
    take_place(values, h, nominal, tuning, memory)


@array_law
def wrapped(angle_rad: float) -> float:
    """The angle in [-pi, pi)."""
    return float((angle_rad + math.pi) % (2.0 * math.pi) - math.pi)


@array_law
def _begin(
    east: float, north: float, azimuth: float, seen: bool, nominal: Record, memory: Record
) -> None:
    """A heading that is unknown begins with the baseline's, else with the course of a drive."""
    x, p = memory.x, memory.p
    speed = math.hypot(east, north) if seen else np.nan
    if math.isfinite(azimuth):
        restart(x, p, HEADING, azimuth - nominal.mount_rad, BASELINE_SD**2)
        if seen and not memory.known:
            x[V_X] = east * math.cos(x[HEADING]) + north * math.sin(x[HEADING])
    elif speed > MOVING_MPS:
        restart(x, p, HEADING, math.atan2(north, east), COURSE_SD**2)
        if not memory.known:
            x[V_X] = speed
    else:
        return
    memory.known = 1


@array_law
def _take_velocity(
    east: float, north: float, up: float, sd: float, h: Array, nominal: Record, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """Ahead, then to the left, in the horizontal axes of the heading predicted."""
    x, p, imu = memory.x, memory.p, memory.imu
    lean = motion.across(x, memory)
    p_rate, q_rate = imu[P_RATE] - x[BIAS_P], imu[Q_RATE] - x[BIAS_Q]
    climbs = up - (p_rate * nominal.antenna_m[1] - q_rate * nominal.antenna_m[0])
    climbs -= x[V_Y] * math.sin(lean)  # whoever slides down a slope sinks
    ground.climb(climbs, x[V_X], 0.05, memory)
    for beside in (True, False):
        foretold = rows.velocity(x, imu, lean, beside, nominal, memory, h)
        cos, sin = math.cos(x[HEADING]), math.sin(x[HEADING])
        error = (north * cos - east * sin if beside else east * cos + north * sin) - foretold
        unfelt(h, memory)
        r = sd**2 + (math.sin(lean) * motion.sinking(x, imu) if beside else 0.0) ** 2
        state = V_Y if beside else V_X
        if not memory.heard[F_Y] and error**2 > GATE**2 * (variance(p, h) + r):
            p[state, state] += error**2
        nis = take(x, p, h, error, r, GATE)
        noted(error, nis, memory)
        if not memory.heard[F_Y]:  # then it is the motion that nobody feels
            memory.unrest = factor(memory.unrest, nis, 1.0, LEAST_UNREST, MOST_UNREST)
    memory.lateral_ns = memory.epoch_ns
