"""What the sensors of a run measure, how late, and with what noise by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

EXACT = 1e-10
"""Variance of a row whose noise is a state."""
HIDDEN_PERIODS = 3.0
"""GNSS counts as hidden without a speed for this many of its periods."""


def hidden_at(streams: Streams, epoch_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
    """At which epochs GNSS has had no speed for HIDDEN_PERIODS."""
    if "gnss" not in streams or len(streams["gnss"]["epoch_ns"]) < 2:
        return np.zeros(len(epoch_ns), bool)
    gnss = streams["gnss"]
    measured = gnss["epoch_ns"][np.isfinite(streams.column("gnss", "v_east_mps"))]
    if not len(measured):
        return np.ones(len(epoch_ns), bool)
    before = np.searchsorted(measured, epoch_ns, side="right") - 1
    since = np.where(before >= 0, epoch_ns - measured[np.maximum(before, 0)], np.inf)
    return np.asarray(since > HIDDEN_PERIODS * 1e9 * period_s(streams, "gnss"))


def late_steps(streams: Streams, sensor: str, step_s: float) -> int:
    """By how many steps a sample arrives later than the wheels' of the same epoch."""
    if sensor not in streams or not len(streams[sensor]["epoch_ns"]):
        return 0
    late = np.median(streams[sensor]["arrival_ns"] - streams[sensor]["epoch_ns"]) * 1e-9
    return int(np.floor(float(late) / step_s))


def period_s(streams: Streams, sensor: str) -> float:
    """Median time between two samples [s]."""
    return float(np.median(np.diff(streams[sensor]["epoch_ns"]))) * 1e-9


def frames_seen(streams: Streams, column: str) -> int:
    """Number of a camera's frames with a speed."""
    if column not in streams.tables.get("camera", {}):
        return 0
    used = streams.column("camera", "used") == 1.0
    return int((used & np.isfinite(streams.column("camera", column))).sum())


def camera_var(streams: Streams, column: str, step_s: float) -> float:
    """Variance of a camera's speed by step, with the share of frames that are used."""
    used = streams.column("camera", "used") == 1.0
    variance = streams.column("camera", column).astype(np.float64)[used]
    per_step = step_s / period_s(streams, "camera") * float(np.mean(used))
    return max(float(np.nanmedian(variance)) / per_step, EXACT)


def travel_var(setup: Setup, streams: Streams, pair: tuple[str, str]) -> float:
    """Variance of the mean travel two counters show, rounding alone: (2 pi R / N)^2 / 24."""
    table = streams.tables.get("wheels", {})
    counted = [w for w in pair if f"ticks_{w}" in table]
    if not counted or setup.wheels is None or not setup.wheels.counts_per_turn:
        return np.nan
    per_tick = 2.0 * np.pi * setup.wheels.radius_m[counted[0]] / setup.wheels.counts_per_turn
    return float(per_tick**2 / 12.0 / len(counted))


def accel_var(streams: Streams, truth: Table, part: Table) -> float:
    """White part of what the accelerometer is off by: E (e_k - 2 e_k-1 + e_k-2)^2 / 6."""
    imu = streams["imu"]
    start = truth["epoch_ns"][0]
    time = (truth["epoch_ns"] - start) * 1e-9
    at = (imu["epoch_ns"] - start) * 1e-9
    motion = np.interp(at, time, np.gradient(np.asarray(truth["speed_mps"], np.float64), time))
    first, last = (part["epoch_ns"][i] for i in (0, -1))
    inside = (imu["epoch_ns"] >= first) & (imu["epoch_ns"] <= last)
    error = (np.asarray(imu["accel_x_mps2"], np.float64) - motion)[inside]
    second = error[2:] - 2.0 * error[1:-1] + error[:-2]
    return max(float(np.nanmean(second**2)) / 6.0, 1e-8)
