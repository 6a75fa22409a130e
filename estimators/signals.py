"""From streams to signals: the samples of a chunk in order of arrival, each turned into speeds.

What every filter here needs and none should do twice: wheel speeds from ticks, the velocity of the
rear-axle centre along and across the body from the antenna's, the body acceleration without the
part of gravity that is known. Everything is carried from chunk to chunk sample by sample, so how
the samples are cut changes no bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import antenna, inertial, wheel_speed
from estimators.kalman import Record
from estimators.layout import (
    CAMERA,
    CAMERA_COLUMNS,
    GNSS,
    GNSS_COLUMNS,
    HISTORY,
    IMU,
    IMU_COLUMNS,
    MEMORY,
    NOMINAL,
    OUT_OF_ORDER,
    SIGNALS,
    WHEEL_COLUMNS,
    WHEELS,
    blank,
    nominal,
)
from twin.compute.compiled import compiled
from twin.streams import COLUMNS, Setup, Streams

Records = NDArray[Any]
"""A structured array."""


@dataclass(frozen=True)
class Reader:
    """What the signals so far leave behind; a plain value."""

    nominal: Records
    """One record of `layout.NOMINAL`: the set-up as numbers."""
    memory: Records
    """One record of `layout.MEMORY`."""


def start(setup: Setup) -> Reader:
    """A reader that has seen nothing."""
    memory = blank(MEMORY, 1)
    return Reader(np.array([nominal(setup)], NOMINAL), memory)


def read(
    reader: Reader, chunk: Streams, sensors: tuple[str, ...] = ("gnss", "imu", "wheels")
) -> tuple[Reader, Records]:
    """The signals of a chunk.

    Args:
        reader: what the signals so far have left behind.
        chunk: the streams.
        sensors: which of them are read; "camera" too, for who knows what to do with it.

    Returns:
        The reader after the chunk, and one record of `layout.SIGNALS` per sample of those sensors,
        in order of arrival.
    """
    used = chunk.only(sensors)
    sensor, row = used.merge_order()
    memory, signals = reader.memory.copy(), blank(SIGNALS, len(sensor))
    if len(sensor):
        gnss, imu, wheels, camera = (
            _matrix(used, "gnss", GNSS_COLUMNS),
            _matrix(used, "imu", IMU_COLUMNS),
            _matrix(used, "wheels", WHEEL_COLUMNS),
            _matrix(used, "camera", CAMERA_COLUMNS),
        )
        signals["sensor"], signals["epoch_ns"] = sensor, epochs(used, sensor, row)
        _read(row, gnss, imu, wheels, camera, reader.nominal[0], memory[0], signals)
    return Reader(reader.nominal, memory), signals


def epochs(chunk: Streams, sensor: NDArray[np.int64], row: NDArray[np.int64]) -> NDArray[np.int64]:
    """Epoch of each sample in the order of `Streams.merge_order`, which gives the rest [ns]."""
    epochs = np.zeros(len(sensor), np.int64)
    for index, name in enumerate(COLUMNS):
        if name in chunk and len(chunk[name]["epoch_ns"]):
            chosen = sensor == index
            epochs[chosen] = chunk[name]["epoch_ns"][row[chosen]]
    return epochs


def _matrix(chunk: Streams, sensor: str, columns: tuple[str, ...]) -> NDArray[np.float64]:
    """The named columns side by side, NaN where there is none. Shape (samples, columns)."""
    table = chunk.tables.get(sensor, {})
    count = len(table.get("epoch_ns", ()))
    if not count:
        return np.empty((0, len(columns)))
    matrix = np.empty((count, len(columns)))
    for index, name in enumerate(columns):
        matrix[:, index] = table.get(name, np.nan)
    return matrix


@compiled
def _read(
    rows: NDArray[np.int64],
    gnss: NDArray[np.float64],
    imu: NDArray[np.float64],
    wheels: NDArray[np.float64],
    camera: NDArray[np.float64],
    nominal: Record,
    memory: Record,
    signals: Records,
) -> None:
    """Fill one record of signals per sample; a sample older than its sensor's last is flagged."""
    for i in range(len(signals)):
        signal = signals[i]
        sensor, epoch_ns = signal.sensor, signal.epoch_ns
        if epoch_ns <= memory.epoch_ns[sensor]:
            signal.flags = OUT_OF_ORDER
            if sensor == WHEELS:
                wheel_speed.set_back(wheels[rows[i]], memory)
            continue
        first = memory.epoch_ns[sensor] < 0
        dt = 0.0 if first else (epoch_ns - memory.epoch_ns[sensor]) * 1e-9
        memory.epoch_ns[sensor] = epoch_ns
        if sensor == GNSS:
            antenna.read(gnss[rows[i]], epoch_ns, dt, nominal, memory, signal)
        elif sensor == IMU:
            inertial.read(imu[rows[i]], epoch_ns, dt, nominal, memory, signal)
        elif sensor == WHEELS:
            wheel_speed.read(wheels[rows[i]], epoch_ns, nominal, memory, signal)
        elif sensor == CAMERA:
            speed, variance, used = camera[rows[i]]
            if used == 1.0 and variance >= 0.0:
                signal.v_x_mps = speed + memory.yaw_rate_radps * nominal.camera_y_m
                signal.v_sd_mps = math.sqrt(variance)
        signal.yaw_rate_radps = memory.yaw_rate_radps
        signal.pitch_rate_radps = memory.history[memory.imu_samples % HISTORY, 1]
        signal.v_y_held_mps = memory.v_y_mps
        signal.v_y_held_sd_mps = memory.v_y_sd_mps
        known = memory.sideslip_var_m2 > 0.0  # some lateral velocity has been integrated
        signal.sideslip_m = memory.sideslip_m if known else np.nan
        signal.sideslip_rear_m = memory.sideslip_rear_m if known else np.nan
        signal.sideslip_sd_m = math.sqrt(memory.sideslip_var_m2) if known else np.nan
