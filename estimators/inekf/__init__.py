"""Right-invariant extended Kalman filter with the slip velocity as a state of its group."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import signals
from estimators.estimate import State, begin, unknown
from estimators.inekf.filter import kept_innovations, loop
from estimators.inekf.layout import MEMORY, TUNING
from estimators.innovations import KEPT, MOST, as_table
from estimators.layout import GNSS, GNSS_COLUMNS, IMU
from twin.streams import ESTIMATES, Setup, Streams, Table

IMU_COLUMNS = (
    "gyro_x_radps", "gyro_y_radps", "gyro_z_radps", "accel_x_mps2", "accel_y_mps2", "accel_z_mps2",
)  # fmt: skip
SENSORS = ("gnss", "imu", "wheels")


@dataclass(frozen=True, kw_only=True)
class InvariantEkf:
    """Attitude R, velocity v and slip velocity u in SE_2(3), beside biases of the IMU.

    R' = R (w - b_g)^,   v' = R (f - b_f) + g,   u' = R n_u                    (`motion`)
    driven wheels (w R, 0, 0) = R^T (v + u),   slip = (w R - v_x) / max(|w R|, |v_x|)
    towed wheels (1 + scale) v_x;  GNSS v + R (w x d), and the heading of its antennas     (`rows`)

    The error is X = Exp(xi) X^: it is the machine's own turning that turns v and u, so the law of
    the error does not depend on the attitude. The velocities are those of the inertial unit, so
    lever arms are exact. Slopes are attitude and no bias.

    Source: Yu et al. (2023), IROS, arXiv 2209.15140: the slip velocity in the group and the
    wheels' measurement. The paper has no GNSS and carries the position, which nothing here needs:
    its group is SE_3(3). Without GNSS this is the paper's filter. What it states of no noise is
    chosen here; grade assumed.
    """

    accel_psd_m2ps3: float = 8e-4
    """Density of the accelerometer's noise, vibration included [m2/s3]: 0.2 m/s2 at 50 Hz."""
    gyro_psd_rad2ps: float = 1e-6
    """Density of the gyro's noise, vibration included [rad2/s]: 0.06 degrees in 1 s."""
    slip_psd_m2ps3: float = 5e-3
    """Density of the slip velocity's walk along the body [m2/s3]: 0.07 m/s in 1 s."""
    skid_psd_m2ps3: float = 1e-4
    """Density of the slip velocity's walk across it and upwards [m2/s3]: 0.01 m/s in 1 s."""
    accel_bias_psd_m2ps5: float = 1e-7
    """Density of the walk of the accelerometer's bias [m2/s5]."""
    gyro_bias_psd_rad2ps3: float = 1e-11
    """Density of the walk of the gyro's bias [rad2/s3]."""
    skid_sd_mps: float = 0.1
    """sd of the velocity across and upwards that v + u does not have [m/s]."""
    front_scale_sd: float = 0.02
    """sd of the towed wheels' scale, from radius and skid."""
    front_scale_psd_ps: float = 1e-7
    """Density of its walk [1/s]: 0.25 points in a minute, as load and soil change."""
    front_quick_sd: float = 0.005
    """sd of its quick part, as the load changes, taken as white."""

    tunable: ClassVar[Mapping[str, str]] = {
        "accel_psd_m2ps3": "assumed",
        "gyro_psd_rad2ps": "assumed",
        "slip_psd_m2ps3": "assumed",
        "skid_psd_m2ps3": "assumed",
        "skid_sd_mps": "assumed",
        "front_quick_sd": "assumed",
    }
    """Fields that `twin tune` finds from innovations -> grade of the values above."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.array([dataclasses.astuple(self)], TUNING)
        memory = np.zeros(1, MEMORY)
        for name in ("time_ns", "first_ns", "imu_ns", "gnss_ns", "heading_ns"):
            memory[name] = -1
        memory["gyro"] = memory["accel"] = memory["heading_rad"] = np.nan
        return begin(setup, tuning, memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is out of order, or over 5 s older than the newest sample, gives no row.
        """
        reader, samples, raw = _read(state, chunk)
        memory, rows = state.memory.copy(), unknown(len(samples))
        nominal, tuning, count = reader.nominal[0], state.tuning[0], 0
        if len(samples):
            count = loop(samples, raw, nominal, tuning, memory[0], rows)
        table = {name: np.ascontiguousarray(rows[name][:count]) for name in ESTIMATES}
        return State(reader, state.tuning, memory), table

    def innovations(self, setup: Setup, streams: Streams) -> Table:
        """Innovation of each measurement, and its predicted variance."""
        state = self.init(setup)
        reader, samples, raw = _read(state, streams)
        memory, kept = state.memory.copy(), np.zeros(MOST * len(samples), KEPT)
        memory["notes"]["wanted"] = 1
        nominal, tuning, count = reader.nominal[0], state.tuning[0], 0
        if len(samples):
            count = kept_innovations(samples, raw, nominal, tuning, memory[0], kept)
        return as_table(kept[:count])


INEKF = InvariantEkf()
"""Invariant extended Kalman filter with slip velocity as a state (Yu et al. 2023), with GNSS."""


def _read(state: State, chunk: Streams) -> tuple[signals.Reader, NDArray[Any], NDArray[np.float64]]:
    """The signals of a chunk, and beside each what GNSS or the inertial unit gave, (samples, 7)."""
    reader, samples = signals.read(state.reader, chunk, SENSORS)
    used = chunk.only(SENSORS)
    sensor, row = used.merge_order()
    raw = np.full((len(sensor), len(GNSS_COLUMNS)), np.nan)
    for number, name, columns in ((GNSS, "gnss", GNSS_COLUMNS), (IMU, "imu", IMU_COLUMNS)):
        own = sensor == number
        for k, column in enumerate(columns):
            raw[own, k] = used.column(name, column)[row[own]] if own.any() else np.nan
    return reader, samples, raw
