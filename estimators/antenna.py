"""GNSS samples: the velocity of the rear-axle centre, along and across the body."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.inertial import turning_at
from estimators.kalman import Record
from estimators.layout import GRAVITY_MPS2, REPEATED, STALE_S
from twin.compute.compiled import compiled

GRADE_S = 2.0
"""Time over which the climb is averaged [s]."""
GRADE_SPEED_MPS = 0.5
"""Below this the climb is noise."""


@compiled
def read(
    sample: NDArray[np.float64],
    epoch_ns: int,
    dt: float,
    nominal: Record,
    memory: Record,
    signal: Record,
) -> None:
    """Velocity of the rear-axle centre in the ground plane, and the sideslip amounts it sums to.

    v_x = (v_e cos h + v_n sin h - (w x l)_x) sqrt(1 + grade^2)
    v_y = (v_n cos h - v_e sin h - (w x l)_y) / cos(roll)

    with the heading h and the turning w of the sample's own epoch, however late it arrives. Without
    a heading (not for `STALE_S`), v_x is the horizontal speed with the sign of the driven wheels,
    and v_y unknown. A sample of quality 0 has no velocity.
    """
    east, north, up, heading, quality = sample[0], sample[1], sample[2], sample[3], sample[4]
    p, q, r, yaw = turning_at(epoch_ns, memory)
    repeated = True
    for i in range(4):
        repeated = repeated and sample[i] == memory.gnss[i]
        memory.gnss[i] = sample[i]
    if repeated:
        signal.flags |= REPEATED
    if math.isfinite(heading):
        memory.heading_offset_rad = heading - nominal.heading_mount_rad - yaw
        memory.heading_ns = epoch_ns
    if quality == 0.0 or not (math.isfinite(east) and math.isfinite(north)):
        return
    lever = nominal.antenna_m
    turn_x, turn_y = q * lever[2] - r * lever[1], r * lever[0] - p * lever[2]
    if memory.heading_ns >= 0 and (epoch_ns - memory.heading_ns) * 1e-9 < STALE_S:
        psi = memory.heading_offset_rad + yaw
        v_x = east * math.cos(psi) + north * math.sin(psi) - turn_x
        v_y = north * math.cos(psi) - east * math.sin(psi) - turn_y
    else:
        v_x = memory.direction * math.hypot(east, north) - turn_x
        v_y = np.nan
    memory.gnss_samples += 1
    _average_grade(v_x, up - (p * lever[1] - q * lever[0]), dt, memory)
    v_x *= math.sqrt(1.0 + memory.grade**2)
    v_y /= math.sqrt(1.0 - min(0.75, (memory.accel_y_mps2 / GRAVITY_MPS2) ** 2))
    sd = sample[5] if sample[5] > 0.0 else nominal.velocity_sd_mps
    heading_sd = sample[6] if sample[6] > 0.0 else nominal.heading_sd_rad
    signal.v_x_mps, signal.v_sd_mps = v_x, sd
    signal.horizontal_mps = math.hypot(east, north)
    _add_sideslip(v_y, v_y + nominal.cg_x_m * r, math.hypot(sd, v_x * heading_sd), epoch_ns, memory)
    memory.v_x_mps = v_x


@compiled
def _average_grade(v_x: float, up: float, dt: float, memory: Record) -> None:
    """Mean of v_up / v_x, the tangent of the grade, while the machine moves."""
    if abs(v_x) > GRADE_SPEED_MPS and math.isfinite(up):
        gain = max(dt / (GRADE_S + dt), 1.0 / memory.gnss_samples)
        memory.grade += gain * (up / v_x - memory.grade)


@compiled
def _add_sideslip(v_y: float, v_y_cg: float, sd: float, epoch_ns: int, memory: Record) -> None:
    """Integrate v_y by the trapezoid rule from the last GNSS sample to this one.

    The sd is that of independent errors; what a constant heading error adds is not in it.
    """
    dt = (epoch_ns - memory.v_ns) * 1e-9
    if memory.v_ns >= 0 and dt < STALE_S and math.isfinite(v_y) and math.isfinite(memory.v_y_mps):
        memory.sideslip_rear_m += 0.5 * (memory.v_y_mps + v_y) * dt
        memory.sideslip_m += 0.5 * (memory.v_y_cg_mps + v_y_cg) * dt
        memory.sideslip_var_m2 += (sd * dt) ** 2
    memory.v_y_mps, memory.v_y_cg_mps = v_y, v_y_cg
    memory.v_y_sd_mps = sd if math.isfinite(v_y) else np.nan
    memory.v_ns = epoch_ns
