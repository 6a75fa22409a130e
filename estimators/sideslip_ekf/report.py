"""What the filter says of now: its state carried on by the IMU's samples that still wait."""

from __future__ import annotations

import math

import numpy as np

from estimators.estimate import SLOW_MPS
from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.sideslip_ekf import motion
from estimators.sideslip_ekf.layout import (
    BIAS_R,
    F_Y,
    IMU,
    R_RATE,
    SLIDE,
    SLIDE_REAR,
    V_X,
    V_Y,
)  # fmt: skip
from twin.compute.compiled import array_law

TOLD = (
    "v_y_mps", "sideslip_rad", "sideslip_sd_rad", "sideslip_m", "sideslip_sd_m",
    "sideslip_rear_rad", "sideslip_rear_m",
)  # fmt: skip
"""The columns of what is told."""


@array_law
def report(
    out: Array, x: Array, now: Array, mean: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    """Fill a row of `TOLD`, NaN where nothing is known.

    Args:
        out: the row, (7,).
        x, now, mean: room, (SIZE,), (5,), (5,).
        nominal, tuning, memory: records; none is changed.
    """
    out[:] = np.nan
    if memory.lateral_ns < 0:
        return
    p = memory.p
    ahead_s = max((memory.newest_ns - memory.epoch_ns) * 1e-9, 0.0)
    out[3], out[6] = memory.x[SLIDE], memory.x[SLIDE_REAR]
    out[4] = math.sqrt(max(p[SLIDE, SLIDE], 0.0))
    if ahead_s > STALE_S or not memory.known:  # after a gap nothing is known of the speeds yet
        return
    x[:] = memory.x
    last_ns = memory.epoch_ns
    now[:] = memory.imu
    lean = motion.across(x, memory)
    for k in range(memory.count):
        if memory.waiting[k].sensor != IMU or memory.waiting[k].epoch_ns <= last_ns:
            continue
        dt = (memory.waiting[k].epoch_ns - last_ns) * 1e-9
        for i in range(5):
            value = memory.waiting[k].values[i]
            value = value if math.isfinite(value) else now[i]
            mean[i], now[i] = 0.5 * (now[i] + value), value
        motion.step(x, mean, lean, dt, nominal, memory)
        last_ns = memory.waiting[k].epoch_ns
    rest = (memory.newest_ns - last_ns) * 1e-9
    if rest > 0.0:  # as it was felt last
        motion.step(x, now, lean, rest, nominal, memory)
    r, v_y = motion.turning(x, now), x[V_Y]
    v_y_cg = v_y + nominal.cg_x_m * r
    psd = memory.accel_psd if memory.heard[F_Y] else tuning.free_psd * memory.unrest
    var = p[V_Y, V_Y] + psd * (ahead_s + memory.lapse_s)
    blurred = p[BIAS_R, BIAS_R] + nominal.gyro_sd_radps**2
    if not memory.heard[R_RATE]:
        blurred = tuning.free_turn_psd
    arm = nominal.cg_x_m
    var += arm * arm * blurred - 2.0 * arm * p[V_Y, BIAS_R]
    out[0] = v_y_cg
    if abs(x[V_X]) >= SLOW_MPS:
        out[1] = math.atan2(v_y_cg, x[V_X])
        out[2] = math.sqrt(max(var, 0.0)) / abs(x[V_X])
        out[5] = math.atan2(v_y, x[V_X])
    out[3], out[6] = x[SLIDE], x[SLIDE_REAR]
    slide = p[SLIDE, SLIDE] + 2.0 * ahead_s * p[SLIDE, V_Y] + ahead_s**2 * p[V_Y, V_Y]
    out[4] = math.sqrt(max(slide, 0.0))
