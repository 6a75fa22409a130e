"""Sideslip from camera, GNSS, IMU and wheels, with mounting errors and the tyres' law of sliding.

One filter for level ground, slopes, furrows and turns, whatever sensors there are. Its state is the
motion of the rear-axle centre in the ground plane, the body's attitude, and the errors of all
sensors (`layout`). The motion is rigid-body kinematics driven by the IMU (`motion`); `rows` has the
measurement of each source.

Two things separate sideslip from mounting errors of antennas. Tyres slide by an angle that grows
with the force across them, which an accelerometer feels (`rows.slide`; cornering compliance, Wong
2008, section 1.4). On level ground, on which the IMU measures the same there and back, nothing
slides (`ground`). Without either the stated sd stays large.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.innovations import KEPT, MOST, as_table
from estimators.sideslip_ekf.filter import loop
from estimators.sideslip_ekf.layout import READ, first_memory, nominal
from estimators.sideslip_ekf.report import TOLD
from estimators.signals import epochs
from estimators.slip_ekf import SLIP_EKF, SlipEkf
from estimators.slip_ekf import State as SlipState
from estimators.slip_ekf.held import PLOUGH
from twin.streams import Setup, Streams, Table

USED = ("gnss", "imu", "wheels", "camera")


@dataclass(frozen=True)
class State:
    """State between chunks; a plain value."""

    slip: SlipState
    nominal: NDArray[Any]
    tuning: NDArray[Any]
    memory: NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class SideslipEkf:
    """Extended Kalman filter of camera, GNSS, IMU and wheels for sideslip.

    Ground speed and slip are `slip-ekf`'s. The sideslip amounts are integrals, whose sd knows of
    the biases they share. Through a masking of GNSS the camera, the IMU and the law of sliding go
    on alone; without a heading of GNSS, course, gyro and that law replace it.

    Values are from physics and from other seeds and logs than the tests'; their grade is "assumed"
    where no source is named.
    """

    free_psd: float = 0.05
    """Density of the walk of a speed without an accelerometer [m2/s3]; it is learnt."""
    free_turn_psd: float = 1e-2
    """Density of the heading's walk without a gyro [rad2/s]."""
    gyro_scale_sd: float = 1e-3
    """Of a calibrated unit."""
    gyro_bias_psd: float = 1e-11
    """Of the gyros' biases [rad2/s3]."""
    askew_rad: float = 0.0035
    """By so much a unit is set askew, and feels a turning as a rolling: 0.2 degrees."""
    askew_s: float = 3.0
    """How long a turning or rolling lasts [s]."""
    accel_bias_psd: float = 1e-8
    """Of the accelerometers' biases [m2/s5]."""
    lean_sd: float = 0.1
    """sd of roll and pitch before anything is felt [rad]."""
    misaligned_sd: float = math.radians(0.5)
    """sd of the antennas' mounting angle [rad]: a square sets it to 0.2 degrees, the eye to 1."""
    misaligned_psd: float = 1e-12
    """Of its walk [rad2/s]."""
    lasting_share: float = 0.85
    """sd of the part of a fixed position's error that lasts, over the sd it states."""
    white_share: float = 0.55
    """The same of its white part."""
    receiver_s: float = 60.0
    """Correlation time of the part that lasts [s]."""
    compliance: float = 0.014
    """Slide of the rear tyres per force across [rad s2/m]: cornering stiffnesses of 5 to 11 per rad
    of slip angle and unit of load, as agricultural and road tyres have (Crolla and El-Razaz 1987).
    """
    compliance_sd: float = 0.006
    compliance_psd: float = 2e-7
    """Of its walk [rad2 s3/m2]: a quarter in a minute, as the soil changes."""
    law_share: float = 0.2
    """Share of a slide that the law is off by for a second."""
    rough_rad: float = 0.01
    """sd of the slide on level but rough ground, of one sample in 20 ms [rad]."""
    push_sd: float = 0.03
    """sd of the slide that an implement makes [rad]."""
    push_psd: float = 3e-6
    """Of its walk [rad2/s]: 0.3 degrees in 10 s, as the draft changes."""
    unfelt_slide: float = 0.005
    """sd of a slide that lasts where no force is felt [rad]: on a road with a camber."""
    stance_sd: float = 0.0015
    """sd of the body's pitch against level ground [rad], whose axes are those of the machine as it
    was measured on level ground: fuel, driver and tyre pressure move an axle by 2 mm each, 2.3 m
    before the other (derived)."""
    speed_sd_mps: float = 0.02
    """Least sd of the slip filter's speed [m/s]."""
    level_sd_mps: float = 0.0003
    """Least sd of the lateral speed on level ground, of one sample in 20 ms [m/s]."""
    camera_yaw_sd: float = math.radians(1.0)
    """sd of the camera's mounting angle [rad]."""
    camera_yaw_psd: float = 1e-12
    """Of its walk [rad2/s]."""
    camera_pitch_sd: float = math.radians(0.5)
    """sd of its mounting's pitch [rad]."""
    sunk_sd: float = 5e-4
    """sd of what the antennas seem to be turned by as the body leans in a furrow [rad]: 0.2 degrees
    by which the IMU is askew, seen 9 degrees from the side."""
    camera_sunk_sd: float = 1e-4
    """The same of the camera, which feels no gravity [rad]."""
    camera_scale_sd: float = 0.02
    """sd of the camera's height, and of how far its tilt makes the ground seem nearer."""
    camera_scale_psd: float = 1e-8
    """Of its walk [1/s]."""
    camera_work_psd: float = 1e-3
    """The same while an implement is pulled, and the chassis sinks and rises [1/s]."""
    camera_ahead_sd: float = 0.003
    """sd of a frame's own error of scale: a chassis that bounces."""
    camera_pull_sd_mps: float = 0.01e-3
    """Lateral speed that all frames of a drive err by alike: detail finer than the pixels pulls a
    displacement by 0.0002 px rms of 1.6 mm at 30 frames/s."""
    frame_psd: float = 0.0007
    """Of the lateral speed's walk between frames that do not follow each other [m2/s3]."""

    slip: SlipEkf = SLIP_EKF
    """The filter of speed and slip."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        names = [f.name for f in dataclasses.fields(self) if f.name != "slip"]
        tuning = np.zeros(1, [(name, "f8") for name in names])
        for name in names:
            tuning[name] = getattr(self, name)
        return State(self.slip.init(setup), nominal(setup), tuning, first_memory())

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is not newer than the last one, or over 5 s older than the newest sample
        of any sensor, gives no row.
        """
        slip, table, memory, _ = self._through(state, chunk, state.memory.copy())
        return State(slip, state.nominal, state.tuning, memory), table

    def innovations(self, setup: Setup, streams: Streams) -> Table:
        """Innovations of heading, velocity and fixed positions of GNSS, with their variances.

        Those of the filter of slip are its own: `self.slip.innovations`.
        """
        state = self.init(setup)
        memory = state.memory.copy()
        memory["notes"]["wanted"] = 1
        return as_table(self._through(state, streams, memory)[-1])

    def _through(
        self, state: State, chunk: Streams, memory: NDArray[Any]
    ) -> tuple[SlipState, Table, NDArray[Any], NDArray[Any]]:
        """State of the slip filter, table, memory and innovations after a chunk."""
        used = chunk.only(USED)
        sensor, row = used.merge_order()
        slip, table, slower = self.slip.run_and_held(state.slip, chunk)
        epoch_ns = epochs(used, sensor, row)
        values = {s: _matrix(used, s, names) for s, names in READ.items()}
        speed = _speeds(table)
        told = np.full((len(speed), len(TOLD)), np.nan)
        wanted = bool(memory["notes"]["wanted"][0])
        kept, count = np.zeros(MOST * len(values["gnss"]) if wanted else 1, KEPT), 0
        if len(sensor):
            count = loop(
                sensor, row, epoch_ns, values["gnss"], values["imu"], values["camera"],
                slower[:, PLOUGH].copy(), speed, state.nominal[0], state.tuning[0], memory[0], told,
                kept,
            )  # fmt: skip
        table |= {name: told[:, i].copy() for i, name in enumerate(TOLD)}
        return slip, table, memory, kept[:count]


def _speeds(table: Table) -> NDArray[np.float64]:
    """Ground speed, its sd and slip of each row, and a place to be filled. Shape (rows, 4)."""
    wheel = np.maximum(np.abs(table["wheel_speed_mps"]), np.abs(table["speed_mps"]))
    sd = table["slip_sd"] * wheel
    return np.column_stack([table["speed_mps"], sd, table["slip"], np.full(len(sd), np.nan)])


def _matrix(chunk: Streams, sensor: str, columns: tuple[str, ...]) -> NDArray[np.float64]:
    """The named columns side by side, NaN where there is none. Shape (samples, columns)."""
    count = len(chunk[sensor]["epoch_ns"]) if sensor in chunk else 0
    matrix = np.empty((count, len(columns)))
    for index, name in enumerate(columns):
        matrix[:, index] = chunk.column(sensor, name) if count else np.nan
    return matrix
