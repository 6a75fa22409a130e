"""A drive as one table of about a row a second: what reports and comparisons of drives are made of.

Sensors differ in rate and phase. Here every quantity has the same rows, each with its duration, so
that means and totals weigh time and not samples.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.logs.gaps import GAP_STEPS, between
from twin.logs.speeds import driven_speed_mps, ground_speed_mps
from twin.streams import Array, Streams, Table

MOVING_MPS = 0.5
"""Below this speed the slip of an estimate is left out: a ratio of two noises says nothing."""
COURSE_MPS = 0.5
"""Below this speed a course is noise and gives no yaw rate."""
YAW_WINDOW_S = 4.0
"""A yaw rate from headings is their change over so long."""
MACHINE = (
    "draft_pin_n", "axle_torque_nm", "hitch_m", "engine_radps", "engine_load", "fuel_lph",
)  # fmt: skip
"""Columns of the machine's stream that come along."""

SECOND_NS = 1_000_000_000


def timeline(streams: Streams, estimate: Table | None = None) -> Table:
    """The drive in rows of a second; seconds without any measurement have no row.

    A column is the mean over the second; where its source is slower it is interpolated linearly,
    and NaN in the source's gaps. Slip is not interpolated.

    Args:
        streams: what was measured.
        estimate: an estimator's table, whose slip and speed come along.

    Returns:
        epoch_ns, duration_s (of each row) and, where known, east_m, north_m,
        speed_mps (ground), wheel_speed_mps, yaw_rate_radps, slip, slip_sd, and those of MACHINE.
    """
    epoch_ns = _epochs(streams, estimate)
    rows: Table = {"epoch_ns": epoch_ns, "duration_s": _durations_s(epoch_ns)}
    for name, (times_ns, values) in _measured(streams).items():
        rows[name] = brought(times_ns, values, epoch_ns)
    rows["yaw_rate_radps"] = _yaw_rate_radps(streams, epoch_ns)
    if estimate is not None:
        rows |= _estimated(estimate, epoch_ns)
    if "speed_mps" not in rows and "estimated_mps" in rows:
        rows["speed_mps"] = rows["estimated_mps"]
    return {name: column for name, column in rows.items() if _known(column)}


def _known(column: Array) -> bool:
    return column.dtype.kind == "i" or bool(np.isfinite(column).any())


def _epochs(streams: Streams, estimate: Table | None) -> NDArray[np.int64]:
    """The middle of each second in which anything was measured."""
    tables = [t for n, t in streams.tables.items() if n != "camera"] or [estimate or {}]
    found = [np.unique(t["epoch_ns"] // SECOND_NS) for t in tables if len(t.get("epoch_ns", []))]
    whole = np.unique(np.concatenate(found)) if found else np.empty(0, np.int64)
    return whole.astype(np.int64) * SECOND_NS + SECOND_NS // 2


def _durations_s(epoch_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Time to the next row; before a gap, and at the end, the median step."""
    if len(epoch_ns) < 2:
        return np.ones(len(epoch_ns))
    steps_s = np.diff(epoch_ns) * 1e-9
    usual_s = float(np.median(steps_s))
    return np.append(np.where(steps_s > GAP_STEPS * usual_s, usual_s, steps_s), usual_s)


def _measured(streams: Streams) -> dict[str, tuple[NDArray[np.int64], Array]]:
    """Quantity -> times and values of its source."""
    found: dict[str, tuple[NDArray[np.int64], Array]] = {}
    if "gnss" in streams:
        gnss = streams["gnss"]
        for axis in ("east_m", "north_m"):
            if axis in gnss:
                found[axis] = gnss["epoch_ns"], gnss[axis]
        if "v_east_mps" in gnss:
            found["speed_mps"] = gnss["epoch_ns"], ground_speed_mps(streams)
    if "wheels" in streams and {"speed_rl_mps", "speed_rr_mps"} <= set(streams["wheels"]):
        found["wheel_speed_mps"] = streams["wheels"]["epoch_ns"], driven_speed_mps(streams)
    if "machine" in streams:
        machine = streams["machine"]
        found |= {c: (machine["epoch_ns"], machine[c]) for c in MACHINE if c in machine}
    return found


def _estimated(estimate: Table, epoch_ns: NDArray[np.int64]) -> Table:
    """Means over each second of an estimate's slip, its sd and its two speeds."""
    times_ns = estimate["epoch_ns"]
    rows: Table = {}
    speed = estimate.get("speed_mps")
    slow = np.zeros(len(times_ns), np.bool_) if speed is None else ~(np.abs(speed) > MOVING_MPS)
    for column in ("slip", "slip_sd"):
        if column in estimate:
            values = np.where(slow, np.nan, estimate[column])
            rows[column] = _means(times_ns, values, epoch_ns)
    for column, name in (("speed_mps", "estimated_mps"), ("wheel_speed_mps", "wheel_speed_mps")):
        if column in estimate:
            rows[name] = np.abs(_means(times_ns, estimate[column], epoch_ns))
    return rows


def _means(
    times_ns: NDArray[np.int64], values: Array, epoch_ns: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Mean of the known values within each row's second; NaN where there is none."""
    means = np.full(len(epoch_ns), np.nan)
    known = np.isfinite(values)
    seconds, place = np.unique(times_ns[known] // SECOND_NS, return_inverse=True)
    if not len(seconds):
        return means
    sums = np.bincount(place, np.asarray(values, np.float64)[known])
    row = np.searchsorted(epoch_ns // SECOND_NS, seconds)
    held = row < len(epoch_ns)
    held[held] = (epoch_ns[row[held]] // SECOND_NS) == seconds[held]
    means[row[held]] = (sums / np.bincount(place))[held]
    return means


def brought(
    times_ns: NDArray[np.int64], values: Array, epoch_ns: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Means over each second, and between the seconds of a slower source linear."""
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(epoch_ns), np.nan)
    order = np.argsort(times_ns[known], kind="stable")
    own_ns, own = times_ns[known][order], np.asarray(values, np.float64)[known][order]
    start_ns = int(epoch_ns[0])
    _, place = np.unique(own_ns // SECOND_NS, return_inverse=True)
    count = np.bincount(place)
    at_s = np.bincount(place, (own_ns - start_ns) * 1e-9) / count
    found = between((epoch_ns - start_ns) * 1e-9, at_s, np.bincount(place, own) / count)
    exact = _means(times_ns, np.asarray(values, np.float64), epoch_ns)
    return np.where(np.isfinite(exact), exact, found)


def _yaw_rate_radps(streams: Streams, epoch_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """From the gyro; else from headings; else from the course of the velocity. Left positive."""
    if np.isfinite(streams.column("imu", "gyro_z_radps")).any():
        rate = streams.column("imu", "gyro_z_radps")
        return brought(streams["imu"]["epoch_ns"], rate, epoch_ns)
    angle = streams.column("gnss", "heading_rad")
    if not np.isfinite(angle).any():
        east, north = (streams.column("gnss", f"v_{axis}_mps") for axis in ("east", "north"))
        angle = np.where(np.hypot(east, north) > COURSE_MPS, np.arctan2(north, east), np.nan)
    known = np.isfinite(angle)
    if known.sum() < 2:
        return np.full(len(epoch_ns), np.nan)
    start_ns = int(epoch_ns[0])
    own_s = (streams["gnss"]["epoch_ns"][known] - start_ns) * 1e-9
    order = np.argsort(own_s, kind="stable")
    own_s, turned = own_s[order], np.unwrap(angle[known][order])
    at_s, half_s = (epoch_ns - start_ns) * 1e-9, 0.5 * YAW_WINDOW_S
    ends = [
        between(at_s + side, own_s, turned, longest_s=YAW_WINDOW_S) for side in (-half_s, half_s)
    ]
    return np.asarray((ends[1] - ends[0]) / YAW_WINDOW_S)
