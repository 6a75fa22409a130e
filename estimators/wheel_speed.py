"""Wheel speeds from what the wheels' sensors give: counts or speeds."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.kalman import Record
from estimators.layout import STALE_S
from twin.compute.compiled import compiled

TICKS, SPEEDS, ACCELS, SD = 0, 4, 8, 12
"""Where each block begins in `layout.WHEEL_COLUMNS`."""
GAP_STEPS, GAP_S = 10.0, 0.5
"""After a gap longer than this many steps and seconds, counters may have begun anew: no speed."""
FASTEST_MPS = 30.0
"""A faster wheel is a counter that has begun anew; 100 km/h is 28 m/s."""
DEFAULT_SD_MPS = 0.05
"""Taken where a source of speeds states none [m/s]."""


@compiled
def read(
    sample: NDArray[np.float64], epoch_ns: int, nominal: Record, memory: Record, signal: Record
) -> None:
    """Theoretical speeds w R of the four wheels, with the nominal radius.

    w R = 2 pi R (n_k - n_k-1) / (N (t_k - t_k-1))

    The difference is the mean over the interval, so the speed of half an interval ago; each count
    is off by up to one, so the difference of two has sd (2 pi R / N) / sqrt(6). NaN in the first
    sample, in the first after a gap, and where the difference is none that a wheel makes: counters
    begin anew when the ignition comes on. Speeds that a source gives are taken unchanged, at their
    epoch.
    """
    for i in range(4):
        ticks = sample[TICKS + i]
        if math.isfinite(ticks):
            dt = (epoch_ns - memory.tick_ns[i]) * 1e-9
            step = memory.tick_step_s[i]
            gap = step > 0.0 and dt > max(GAP_STEPS * step, GAP_S)
            if math.isfinite(memory.tick[i]) and dt < STALE_S and not gap:
                per_tick = 2.0 * math.pi * nominal.radius_m[i] / nominal.counts_per_turn
                speed = per_tick * (ticks - memory.tick[i]) / dt
                if not abs(speed) > FASTEST_MPS:
                    signal.wheel_mps[i] = speed
                    signal.wheel_sd_mps[i] = per_tick / math.sqrt(6.0) / dt
                    signal.wheel_age_s[i] = 0.5 * dt
                memory.tick_step_s[i] = dt
            memory.tick[i] = ticks
            memory.tick_ns[i] = epoch_ns
        else:
            signal.wheel_mps[i] = sample[SPEEDS + i]
            signal.wheel_sd_mps[i] = sample[SD] if sample[SD] > 0.0 else DEFAULT_SD_MPS
        signal.wheel_accel_mps2[i] = sample[ACCELS + i]
    signal.one_driven_speed = _one_speed(sample, nominal, 1.0)
    signal.one_towed_speed = _one_speed(sample, nominal, 0.0)
    speed = driven_mean(signal.wheel_mps, nominal)
    if speed != 0.0 and math.isfinite(speed):
        memory.direction = math.copysign(1.0, speed)


@compiled
def set_back(sample: NDArray[np.float64], memory: Record) -> None:
    """Forget the counts if a sample that is out of order goes beyond them: the clock was set back.

    A sample that comes late, or twice, has counts that were passed already.
    """
    for i in range(4):
        if (sample[TICKS + i] - memory.tick[i]) * memory.direction > 0.0:
            memory.tick[i] = np.nan


@compiled
def driven_mean(values: NDArray[np.float64], nominal: Record) -> float:
    """Mean over the driven wheels that have a value; NaN if none has. values: (4,)."""
    return _mean(values, nominal, 1.0)


@compiled
def towed_mean(values: NDArray[np.float64], nominal: Record) -> float:
    """Mean over the wheels that are not driven and have a value; NaN if none has. values: (4,)."""
    return _mean(values, nominal, 0.0)


@compiled
def _mean(values: NDArray[np.float64], nominal: Record, driven: float) -> float:
    total, count = 0.0, 0
    for i in range(4):
        if nominal.driven[i] == driven and math.isfinite(values[i]):
            total += values[i]
            count += 1
    return total / count if count else np.nan


@compiled
def mean_variance(sd: NDArray[np.float64], nominal: Record, driven: float, one: int) -> float:
    """Variance of that mean: sum sd^2 / n^2, or the mean of sd^2 where all are one and the same."""
    total, count = 0.0, 0
    for i in range(4):
        if nominal.driven[i] == driven and math.isfinite(sd[i]):
            total += sd[i] ** 2
            count += 1
    if count == 0:
        return np.nan
    return total / count if one else total / count**2


@compiled
def _one_speed(sample: NDArray[np.float64], nominal: Record, driven: float) -> int:
    """1 if these wheels' speeds are a single number repeated: their errors do not average."""
    first = np.nan
    for i in range(4):
        if nominal.driven[i] == driven:
            if math.isnan(first):
                first = sample[SPEEDS + i]
            elif sample[SPEEDS + i] != first:
                return 0
    return 1 if math.isfinite(first) else 0
