"""A column map as TOML text, and what writers share."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from twin.streams import WHEELS, Array, Setup, Streams

BUS_PERIOD_NS = 100_000_000
"""Time between two wheel speeds of a bus (J1939 CCVS1: 100 ms)."""


def map_text(
    sections: Mapping[str, Mapping[str, Mapping[str, object]]],
    setup: Setup | None,
    log: Mapping[str, object] | None = None,
) -> str:
    """A column map as TOML: section -> key -> column, unit and more; [log]; the set-up."""
    lines = []
    if log:
        lines += ["[log]", *(f"{key} = {_value(value)}" for key, value in log.items()), ""]
    for section, sources in sections.items():
        if sources:
            lines += [f"[{section}]", *(f"{k} = {_value(v)}" for k, v in sources.items()), ""]
    return "\n".join([*lines, *(_setup_lines(setup) if setup else [])])


def _setup_lines(setup: Setup) -> list[str]:
    plain = {k: v for k, v in dataclasses.asdict(setup).items() if v is not None}
    plain = {k: v for k, v in plain.items() if k not in ("extra", "camera")}
    blocks = {k: v for k, v in plain.items() if isinstance(v, dict)}
    lines = ["[setup]", *(f"{k} = {_value(v)}" for k, v in plain.items() if k not in blocks), ""]
    for name, block in blocks.items():
        known = {k: v for k, v in block.items() if v is not None}
        lines += [f"[setup.{name}]", *(f"{k} = {_value(v)}" for k, v in known.items()), ""]
    return lines


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(float(value)) if isinstance(value, float) else str(value)


def _key(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() else json.dumps(name)


def wheel_speeds(streams: Streams, setup: Setup) -> tuple[NDArray[np.int64], dict[str, Array]]:
    """Times and theoretical speeds of the wheels as a bus would give them, each 100 ms from counts.

    w R = 2 pi R (n_k - n_j) / (N (t_k - t_j)), at the middle of the interval
    """
    table = streams.tables.get("wheels", {})
    speeds = {w: table[f"speed_{w}_mps"] for w in WHEELS if f"speed_{w}_mps" in table}
    if speeds or "epoch_ns" not in table or setup.wheels is None:
        return table.get("epoch_ns", np.empty(0, np.int64)), speeds
    step_ns = float(np.median(np.diff(table["epoch_ns"]))) if len(table["epoch_ns"]) > 1 else 1.0
    at = np.arange(0, len(table["epoch_ns"]), max(round(BUS_PERIOD_NS / step_ns), 1))
    epoch_ns = table["epoch_ns"][at]
    seconds = np.diff(epoch_ns) * 1e-9
    for wheel in WHEELS:
        counts = setup.wheels.counts_per_turn
        if f"ticks_{wheel}" in table and counts:
            per_tick = 2.0 * math.pi * setup.wheels.radius_m[wheel] / counts
            speeds[wheel] = per_tick * np.diff(table[f"ticks_{wheel}"][at]) / seconds
    return epoch_ns[:-1] + np.diff(epoch_ns) // 2, speeds


def driven_speed(speeds: Mapping[str, Array], setup: Setup) -> Array | None:
    """Mean of the driven wheels' speeds; None without them."""
    own = [speeds[w] for w in setup.driven if w in speeds]
    return None if not own else np.asarray(np.mean(own, axis=0))


def geodetic(
    streams: Streams, setup: Setup
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Latitude, longitude [deg] and height [m] of the positions; NaN without an origin."""
    from twin.logs.geodesy import geodetic_rad

    east, north, up = (streams.column("gnss", f"{axis}_m") for axis in ("east", "north", "up"))
    if setup.origin is None:
        nothing = np.full(len(east), np.nan)
        return nothing, nothing, nothing
    known_up = np.where(np.isfinite(up), up, 0.0)
    origin = (math.radians(setup.origin[0]), math.radians(setup.origin[1]), setup.origin[2])
    latitude, longitude, height = geodetic_rad(east, north, known_up, origin)
    return np.degrees(latitude), np.degrees(longitude), height


def bearing_deg(angle_rad: Array) -> NDArray[np.float64]:
    """Clockwise from north, in [0, 360)."""
    degrees = np.mod(90.0 - np.degrees(angle_rad), 360.0)
    return np.where(degrees >= 360.0 - 1e-9, 0.0, degrees)


def course_and_speed(streams: Streams) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Course [rad, from east] and speed [m/s] over ground."""
    east, north = (streams.column("gnss", f"v_{axis}_mps") for axis in ("east", "north"))
    return np.arctan2(north, east), np.hypot(east, north)


def left_out(streams: Streams, held: Mapping[str, set[str]]) -> list[str]:
    """What of the streams a format does not hold, as sensor.column."""
    return [
        f"{sensor}.{column}"
        for sensor, table in streams.tables.items()
        for column in table
        if column not in ("epoch_ns", "arrival_ns") and column not in held.get(sensor, set())
    ]
