"""What the filter says of now."""

from __future__ import annotations

import math

from estimators.estimate import SLOW_MPS
from estimators.kalman import Record
from estimators.layout import NO_GROUND_SPEED, STALE_S
from estimators.slip_ekf import model
from estimators.slip_ekf.driven import radius
from estimators.slip_ekf.layout import NO_FRONT, NO_IMU, V
from estimators.slip_ekf.pitch import rate_now
from twin.compute.compiled import compiled


@compiled
def report(row: Record, signal: Record, nominal: Record, tuning: Record, memory: Record) -> None:
    """Write the estimate of now; nothing where the ground speed is unknown for too long."""
    row.epoch_ns = memory.time_ns
    unknown = not memory.known or (memory.time_ns - memory.measured_ns) * 1e-9 > STALE_S
    if unknown:
        memory.flags |= NO_GROUND_SPEED
    if (memory.time_ns - memory.front_ns) * 1e-9 > 1.0 or memory.front_ns < 0:
        memory.flags |= NO_FRONT
    if (memory.time_ns - memory.imu_ns) * 1e-9 > 1.0 or memory.imu_ns < 0:
        memory.flags |= NO_IMU
    row.flags = memory.flags
    memory.flags = 0
    if not memory.known:
        return
    x, p = memory.x, memory.cov
    # the driveline turns with the body: over the ground the wheels turn by its pitching more
    wheel = model.rim_speed(x, memory.rim_mps) + radius(nominal, 1.0) * rate_now(memory)
    row.speed_mps, row.wheel_speed_mps = x[V], wheel
    row.slip = (wheel - x[V]) / max(abs(wheel), abs(x[V]), SLOW_MPS)
    row.slip_sd = math.sqrt(model.slip_var(p, x[V], wheel, memory.rim_mps, SLOW_MPS))
    conflict = 0.0
    for source in range(len(memory.conflict_mps)):
        conflict = max(conflict, memory.conflict_mps[source])
    # who is right, the estimate or the speed that it refuses, is not known yet
    row.slip_sd = math.hypot(row.slip_sd, 0.5 * conflict / max(abs(wheel), abs(x[V]), SLOW_MPS))
    across = 0.5 * signal.yaw_rate_radps * nominal.track_rear_m
    for side, at in ((-1.0, 2), (1.0, 3)):
        rim = wheel + side * 0.5 * memory.apart_mps
        ground = x[V] + side * across
        largest = max(abs(rim), abs(ground), SLOW_MPS)
        if at == 2:
            row.slip_rl = (rim - ground) / largest
        else:
            row.slip_rr = (rim - ground) / largest
    if memory.v_y_ns >= 0:
        _report_across(row, signal, nominal, tuning, memory)


@compiled
def _report_across(
    row: Record, signal: Record, nominal: Record, tuning: Record, memory: Record
) -> None:
    """Sideslip: its sd is that of v_y and of the antennas' mounting angle, which nothing tells."""
    ground = memory.x[V]
    since = max(0.0, (memory.time_ns - memory.v_y_ns) * 1e-9)
    v_y_cg = memory.v_y + nominal.cg_x_m * signal.yaw_rate_radps
    row.v_y_mps = v_y_cg
    row.sideslip_m, row.sideslip_rear_m = signal.sideslip_m, signal.sideslip_rear_m
    row.sideslip_sd_m = math.hypot(signal.sideslip_sd_m, tuning.mount_sd * memory.travelled_m)
    if abs(ground) >= SLOW_MPS:
        row.sideslip_rear_rad = math.atan2(memory.v_y, ground)
        row.sideslip_rad = math.atan2(v_y_cg, ground)
        variance = memory.v_y_var + tuning.v_y_psd * since
        row.sideslip_sd_rad = math.sqrt(variance / ground**2 + tuning.mount_sd**2)
