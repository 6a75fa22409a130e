"""Slip as the ratio of the newest speeds, without a filter, as a slip meter shows it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.estimate import State, advance, begin, each_sample, write
from estimators.kalman import Record
from estimators.layout import GNSS, NO_GROUND_SPEED, STALE_S, WHEELS
from estimators.wheel_speed import mean_variance, towed_mean
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

TUNING = np.dtype([("towed", "i8")])
ACCEL_SD_MPS2 = 0.3
"""sd of a tractor's acceleration while it works or turns; a start from rest takes 1 m/s2."""
MEMORY = np.dtype([("flags", "i8"), ("v_ns", "i8"), ("v_mps", "f8"), ("v_var", "f8")], align=True)


@dataclass(frozen=True, kw_only=True)
class Ratio:
    """s = (w R - v) / max(|w R|, |v|, 0.05 m/s) at every sample of the wheels.

    w R is the mean of the driven wheels with the nominal radius. v is the last GNSS velocity along
    the body, brought to the rear axle, or the mean speed of the towed wheels (steered straight and
    free of slip). slip_sd is that of the data sheets' noise, and of how the machine may have sped
    up since the velocity's epoch: it knows nothing of a wrong radius or of the tick intervals' own.
    """

    towed: bool = False
    """Take the ground speed from the wheels that are not driven."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        memory = np.array([(0, -1, np.nan, np.nan)], MEMORY)
        return begin(setup, np.array([(self.towed,)], TUNING), memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        An out-of-order wheel sample gives no row.
        """
        return advance(_loop, state, chunk)


RATIO = Ratio()
"""Slip from the newest wheel and GNSS speeds, without a filter, as a slip meter shows it."""
RATIO_FRONT = Ratio(towed=True)
"""Slip from the newest speeds of the driven and the free front wheels, without a filter."""


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    return each_sample(_take, signals, nominal, tuning, memory, rows)


@compiled
def _take(signal: Record, nominal: Record, tuning: Record, memory: Record, row: Record) -> bool:
    if signal.sensor == GNSS and not tuning.towed and math.isfinite(signal.v_x_mps):
        memory.v_ns, memory.v_mps = signal.epoch_ns, signal.v_x_mps
        memory.v_var = signal.v_sd_mps**2
    if signal.sensor != WHEELS:
        return False
    if tuning.towed:
        memory.v_ns, memory.v_mps = signal.epoch_ns, towed_mean(signal.wheel_mps, nominal)
        memory.v_var = mean_variance(signal.wheel_sd_mps, nominal, 0.0, signal.one_towed_speed)
    if (signal.epoch_ns - memory.v_ns) * 1e-9 > STALE_S:
        memory.v_mps = np.nan
    if math.isnan(memory.v_mps):
        memory.flags |= NO_GROUND_SPEED
    age_s = max(signal.epoch_ns - memory.v_ns, 0) * 1e-9
    v_var = memory.v_var + (ACCEL_SD_MPS2 * age_s) ** 2
    write(row, signal, nominal, memory.v_mps, v_var, signal.wheel_mps, signal.wheel_sd_mps)
    row.epoch_ns, row.flags = signal.epoch_ns, memory.flags
    memory.flags = 0
    return True
