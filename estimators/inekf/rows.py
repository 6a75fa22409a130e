"""What each source measures: h(X), and its row H = dh(Exp(xi) X) / dxi, filled in place.

What is measured in the body, R^T (v + u), has rows that do not depend on the velocity; what is
measured in the world does.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.inekf.group import skew, times, turn, turn_back
from estimators.inekf.layout import ATTITUDE, FRONT_SCALE, GYRO_BIAS, SLIP, VELOCITY
from estimators.inekf.motion import rates, there
from estimators.kalman import Array, Record
from twin.compute.compiled import compiled


@compiled
def along(axis: int, slipping: bool, nominal: Record, memory: Record, h: Array) -> float:
    """Velocity of the rear-axle centre along a body axis, or with u that of its wheels [m/s].

    (R^T (v + u) - w x l)_axis,   l the inertial unit's place
    """
    moving = memory.v.copy()
    if slipping:
        moving += memory.u
    place = np.ascontiguousarray(nominal.imu_m)
    lever = skew(place)
    by_bias = times(lever, there(memory.gyro))
    h[:] = 0.0
    for k in range(3):
        h[VELOCITY + k] = memory.world_from_body[k, axis]
        if slipping:
            h[SLIP + k] = memory.world_from_body[k, axis]
        h[GYRO_BIAS + k] = -by_bias[axis, k]
    turning = turn(lever, rates(memory))  # -w x l = l x w
    return float(turn_back(memory.world_from_body, moving)[axis] + turning[axis])


@compiled
def towed(nominal: Record, memory: Record, h: Array) -> float:
    """Speed of the towed wheels at the rear-axle centre [m/s]: (1 + scale) times `along`."""
    speed = along(0, False, nominal, memory, h)
    for k in range(len(h)):
        h[k] *= 1.0 + memory.front_scale
    h[FRONT_SCALE] = speed
    return float((1.0 + memory.front_scale) * speed)


@compiled
def antenna(axis: int, nominal: Record, memory: Record, h: Array) -> float:
    """Velocity of the main antenna along a world axis [m/s].

    (v + R (w x d))_axis,   d from the inertial unit to the antenna
    """
    place = np.ascontiguousarray(nominal.antenna_m) - np.ascontiguousarray(nominal.imu_m)
    lever = skew(place)
    swung = turn(memory.world_from_body, -turn(lever, rates(memory)))
    speed = memory.v + swung
    turned = skew(speed)
    by_bias = times(memory.world_from_body, times(lever, there(memory.gyro)))
    h[:] = 0.0
    for k in range(3):
        h[ATTITUDE + k] = -turned[axis, k]
        h[GYRO_BIAS + k] = by_bias[axis, k]
    h[VELOCITY + axis] = 1.0
    return float(speed[axis])


@compiled
def heading(nominal: Record, memory: Record, h: Array) -> float:
    """Direction of the antennas' baseline in the horizontal plane, from east [rad]."""
    mount = nominal.heading_mount_rad
    level = np.zeros(3)
    level[0], level[1] = math.cos(mount), math.sin(mount)
    baseline = turn(memory.world_from_body, level)
    size = max(baseline[0] ** 2 + baseline[1] ** 2, 1e-6)
    h[:] = 0.0
    h[ATTITUDE] = -baseline[0] * baseline[2] / size
    h[ATTITUDE + 1] = -baseline[1] * baseline[2] / size
    h[ATTITUDE + 2] = 1.0
    return math.atan2(baseline[1], baseline[0])


@compiled
def lean(axis: int, memory: Record, h: Array) -> float:
    """How far the body's z axis leans along a world axis, 0 (east) or 1 (north)."""
    up = memory.world_from_body[:, 2].copy()
    by = -skew(up)
    h[:] = 0.0
    for k in range(3):
        h[ATTITUDE + k] = by[axis, k]
    return float(up[axis])
