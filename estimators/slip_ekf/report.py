"""The estimate of now, from the state."""

from __future__ import annotations

import math

from estimators.estimate import SLOW_MPS
from estimators.kalman import Array, Record, slip_and_sd
from estimators.layout import NO_GROUND_SPEED, STALE_S
from estimators.slip_ekf import rows
from estimators.slip_ekf.consensus import disagreement
from estimators.slip_ekf.imu import pitch
from estimators.slip_ekf.judge import has_accelerometer
from estimators.slip_ekf.layout import (
    FROM_GNSS,
    FROM_TOWED,
    NO_FRONT,
    NO_IMU,
    NUMBER,
    SIZE,
    V_Y,
    V,
)
from estimators.slip_ekf.update import variance
from estimators.slip_ekf.wheels import radius
from twin.compute.compiled import array_law

MOUNT_SD_RAD = 0.00175
"""sd of the antennas' mounting angle, 0.1 degree."""


@array_law
def slip(x: Array, p: Array, rim: float, turned: float, h: Array) -> tuple[float, float, float]:
    """Speed of the driven wheels over the ground [m/s], slip, and its sd.

    Args:
        x, p: mean and covariance of the state.
        rim: counted speed of the driven wheels, averaged [m/s].
        turned: what the body's pitching adds to the wheels' speed [m/s].
        h: room for a row, (SIZE,).
    """
    wheel, covariance = rows.wheel_speed(x, rim, h) + turned, 0.0
    for i in range(SIZE):
        covariance += h[i] * p[i, V]
    found, sd = slip_and_sd(wheel, x[V], variance(p, h, 0.0), p[V, V], covariance)
    return wheel, found, sd


@array_law
def report(row: Record, signal: Record, h: Array, nominal: Record, memory: Record) -> None:
    """Write the estimate of now; nothing before the first ground speed."""
    row.epoch_ns = memory.time_ns
    if not memory.known or (memory.time_ns - memory.measured_ns) * 1e-9 > STALE_S:
        memory.flags |= NO_GROUND_SPEED
    if memory.seen_ns[FROM_TOWED] < 0 or (memory.time_ns - memory.seen_ns[FROM_TOWED]) > 1e9:
        memory.flags |= NO_FRONT
    if not has_accelerometer(memory):
        memory.flags |= NO_IMU
    row.flags = memory.flags
    memory.flags = 0
    if not memory.known:
        return
    x, p = memory.x, memory.p
    # the driveline turns with the body: over the ground the wheels turn by its pitching more
    _, rate = pitch(memory.time_ns, memory)
    turned = radius(nominal, 1.0) * rate
    wheel, row.slip, sd = slip(x, p, memory.rim_mps, turned, h)
    fastest = max(abs(wheel), abs(x[V]), SLOW_MPS)
    row.speed_mps, row.wheel_speed_mps = x[V], wheel
    row.slip_sd = math.hypot(sd, 0.5 * _conflict(memory) / fastest)
    across = 0.5 * memory.yaw_rate * nominal.track_rear_m
    left, right = wheel - 0.5 * memory.difference_mps[0], wheel + 0.5 * memory.difference_mps[0]
    row.slip_rl = (left - x[V] + across) / max(abs(left), abs(x[V] - across), SLOW_MPS)
    row.slip_rr = (right - x[V] - across) / max(abs(right), abs(x[V] + across), SLOW_MPS)
    if math.isfinite(signal.v_y_held_mps):
        _report_across(row, signal, nominal, memory)


@array_law
def _conflict(memory: Record) -> float:
    """How far GNSS is refused, where the other sources do not speak for the estimate [m/s]."""
    since = (memory.time_ns - memory.seen_ns[FROM_GNSS]) * 1e-9
    if memory.refused_ns[FROM_GNSS] < 0 or since > STALE_S:
        return 0.0
    stated = memory.seen_mps[FROM_GNSS]
    if disagreement(memory.x[V], NUMBER[FROM_GNSS], memory) < disagreement(
        stated, NUMBER[FROM_GNSS], memory
    ):
        return 0.0
    return float(abs(stated - memory.x[V]))


@array_law
def _report_across(row: Record, signal: Record, nominal: Record, memory: Record) -> None:
    """Sideslip: its sd is that of v_y and of the antennas' mounting angle, not observed."""
    ground, v_y = memory.x[V], memory.x[V_Y]
    v_y_cg = v_y + nominal.cg_x_m * signal.yaw_rate_radps
    row.v_y_mps = v_y_cg
    row.sideslip_m, row.sideslip_rear_m = signal.sideslip_m, signal.sideslip_rear_m
    row.sideslip_sd_m = math.hypot(signal.sideslip_sd_m, MOUNT_SD_RAD * memory.travelled_m)
    if abs(ground) >= SLOW_MPS:
        row.sideslip_rear_rad = math.atan2(v_y, ground)
        row.sideslip_rad = math.atan2(v_y_cg, ground)
        row.sideslip_sd_rad = math.sqrt(memory.p[V_Y, V_Y] / ground**2 + MOUNT_SD_RAD**2)
