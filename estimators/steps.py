"""Samples of several sensors as steps: one vector of measurements at each wheel sample.

The filters that adapt to innovations need them together, at one epoch. A step takes the newest
sample of each sensor since the last step; what did not come is NaN.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.kalman import Record
from estimators.layout import GNSS, IMU, NO_GROUND_SPEED, OUT_OF_ORDER, STALE_S, WHEELS
from estimators.wheel_speed import driven_mean, mean_variance, towed_mean
from twin.compute.compiled import compiled

FRONT_SPEED, GNSS_SPEED, BODY_ACCEL, REAR_SPEED, REAR_ACCEL = range(5)
MEASURED = 5
"""Measurements of a step: ground speed twice, its acceleration, the driven wheels' two."""
STEP_S = 0.02
"""The paper's sampling period, to which its Q belongs."""

STEP = np.dtype(
    [
        ("epoch_ns", "i8"),
        ("last_ns", "i8"),
        ("flags", "i8"),
        ("ground_ns", "i8"),
        ("dt_s", "f8"),
        ("z", "f8", MEASURED),
        ("sd", "f8", MEASURED),
        ("age_s", "f8", MEASURED),
        ("z_ns", "i8", MEASURED),
    ],
    align=True,
)
"""A step and what waits for it: `z` [m/s, m/s2], NaN where nothing came; `sd` as the source states
it; `age_s` how long before the step's epoch that was; `dt_s` since the last step, 0 at the first;
`ground_ns` when a ground speed was last measured."""


def first_step() -> NDArray[Any]:
    """One record of STEP before anything came."""
    step = np.zeros(1, STEP)
    step["epoch_ns"] = step["last_ns"] = step["ground_ns"] = -1
    step["z"] = step["sd"] = np.nan
    return step


@compiled
def gather(signal: Record, nominal: Record, step: Record) -> bool:
    """Take a sample into the step; true if that completes it. `clear` it after use.

    Args:
        signal: record of `layout.SIGNALS`.
        nominal: record of `layout.NOMINAL`.
        step: record of STEP, changed in place.
    """
    step.flags |= signal.flags
    if signal.flags & OUT_OF_ORDER:
        return False
    if signal.sensor == GNSS:
        _put(step, GNSS_SPEED, signal.v_x_mps, signal.v_sd_mps, signal.epoch_ns, 0.0)
    elif signal.sensor == IMU:
        _put(step, BODY_ACCEL, signal.accel_mps2, nominal.accel_sd_mps2, signal.epoch_ns, 0.0)
    elif signal.sensor == WHEELS:
        age, epoch_ns = signal.wheel_age_s.max(), signal.epoch_ns
        var = mean_variance(signal.wheel_sd_mps, nominal, 0.0, signal.one_towed_speed)
        _put(
            step, FRONT_SPEED, towed_mean(signal.wheel_mps, nominal), math.sqrt(var), epoch_ns, age
        )
        var = mean_variance(signal.wheel_sd_mps, nominal, 1.0, signal.one_driven_speed)
        _put(
            step, REAR_SPEED, driven_mean(signal.wheel_mps, nominal), math.sqrt(var), epoch_ns, age
        )
        accel = driven_mean(signal.wheel_accel_mps2, nominal)
        _put(step, REAR_ACCEL, accel, np.nan, epoch_ns, 0.0)
        _complete(step, epoch_ns)
        return True
    return False


@compiled
def clear(step: Record) -> None:
    """Make room for the next step."""
    step.last_ns = step.epoch_ns
    step.flags = 0
    step.z[:] = np.nan
    step.sd[:] = np.nan


@compiled
def _put(step: Record, which: int, z: float, sd: float, epoch_ns: int, age_s: float) -> None:
    if math.isfinite(z):
        step.z[which], step.sd[which] = z, sd
        step.z_ns[which], step.age_s[which] = epoch_ns, age_s


@compiled
def _complete(step: Record, epoch_ns: int) -> None:
    step.epoch_ns = epoch_ns
    step.dt_s = 0.0 if step.last_ns < 0 else (epoch_ns - step.last_ns) * 1e-9
    for which in range(MEASURED):
        if math.isfinite(step.z[which]):
            step.age_s[which] += (epoch_ns - step.z_ns[which]) * 1e-9
            if step.age_s[which] > STALE_S:
                step.z[which] = np.nan
                step.flags |= OUT_OF_ORDER
            elif which in (FRONT_SPEED, GNSS_SPEED):
                step.ground_ns = epoch_ns
    if step.ground_ns < 0 or (epoch_ns - step.ground_ns) * 1e-9 > STALE_S:
        step.flags |= NO_GROUND_SPEED
