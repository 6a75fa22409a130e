"""A tractor's bus as candump writes it: J1939, ISO 11783 and NMEA 2000 frames in order of time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.export import maps
from twin.logs.readers import bus_parameters as bus
from twin.streams import Array, Setup, Streams

CHANNEL = "can0"
_SENDERS = {
    61444: 0x00, 61443: 0x00, 65266: 0x00, 65265: 0x03, 65215: 0x0B, 65096: 0x03, 65093: 0x05,
    129025: 0x1C, 129026: 0x1C, 129029: 0x1C, 127250: 0x1C, 127251: 0x1C,
}  # fmt: skip
"""Parameter group -> source address: engine, transmission, brakes, hitch, GNSS."""
_PRIORITY = {61444: 3, 61443: 3, 129025: 2, 129026: 2, 127250: 2, 127251: 2, 129029: 3, 65096: 3}
_HELD = {
    "gnss": {"east_m", "north_m", "up_m", "v_east_mps", "v_north_mps", "heading_rad", "quality",
             "satellites_main"},
    "imu": {"gyro_z_radps"},
    "wheels": {f"{k}_{w}{u}" for k, u in (("ticks", ""), ("speed", "_mps")) for w in
               ("fl", "fr", "rl", "rr")},
    "machine": {"engine_radps", "engine_load", "fuel_lph", "draft_pin_n"},
}  # fmt: skip
_Frames = tuple[NDArray[np.int64], int, NDArray[np.uint8]]
"""Times, identifier and data (n, 8) of the frames of one group."""


def write_candump(streams: Streams, setup: Setup, directory: Path) -> list[str]:
    """`bus.candump` and `map.toml`; what is not in them. Raises BadInput if nothing is."""
    groups = [*_machine(streams), *_wheels(streams, setup), *_gnss(streams, setup)]
    if not groups:
        raise BadInput("the streams hold nothing that a bus carries")
    times = np.concatenate([times for times, _, _ in groups])
    which = np.repeat(np.arange(len(groups)), [len(times) for times, _, _ in groups])
    row = np.concatenate([np.arange(len(times)) for times, _, _ in groups])
    order = np.lexsort((row, which, times))
    with (directory / "bus.candump").open("w", encoding="ascii") as file:
        for i in order:
            _, identifier, data = groups[which[i]]
            stamp_us = (int(times[i]) + 500) // 1000
            stamp = f"{stamp_us // 1_000_000}.{stamp_us % 1_000_000:06d}"
            file.write(
                f"({stamp}) {CHANNEL} {identifier:08X}#{data[row[i]].tobytes().hex().upper()}\n"
            )
    (directory / "map.toml").write_text(maps.map_text({}, setup), encoding="utf-8")
    return maps.left_out(streams, _HELD)


def _group(pgn: int, epoch_ns: NDArray[np.int64], values: dict[str, Array]) -> _Frames:
    """Frames of a group with some of its parameters; the rest is not available."""
    data = np.full((len(epoch_ns), 8), 0xFF, np.uint8)
    for parameter in bus.PARAMETERS:
        if parameter.pgn == pgn and parameter.name in values:
            put(data, parameter, values[parameter.name])
    return epoch_ns, identifier_of(pgn), data


def put(data: NDArray[np.uint8], parameter: bus.Parameter, values: Array) -> None:
    """Write a parameter into frames, in place."""
    raw = parameter.coded(np.asarray(values, np.float64))
    for i in range(parameter.size):
        data[:, parameter.byte - 1 + i] = (raw >> np.uint64(8 * i)).astype(np.uint8)


def identifier_of(pgn: int) -> int:
    """29-bit identifier of a group that goes to all."""
    return (_PRIORITY.get(pgn, 6) << 26) | (pgn << 8) | _SENDERS.get(pgn, 0xFE)


def _machine(streams: Streams) -> Iterator[_Frames]:
    if "machine" not in streams:
        return
    epoch_ns = streams["machine"]["epoch_ns"]
    for pgn, name, column, per_unit in (
        (61444, "engine_speed", "engine_radps", 30.0 / math.pi),
        (61443, "engine_load", "engine_load", 100.0),
        (65266, "fuel_rate", "fuel_lph", 1.0),
        (65093, "draft", "draft_pin_n", 1.0),
    ):
        values = streams.column("machine", column) * per_unit
        known = np.isfinite(values)
        if known.any():
            yield _group(pgn, epoch_ns, {name: values})


def _wheels(streams: Streams, setup: Setup) -> Iterator[_Frames]:
    """CCVS1, ISO 11783's wheel-based speed, and EBC2 wheel by wheel."""
    epoch_ns, speeds = maps.wheel_speeds(streams, setup)
    driven = maps.driven_speed(speeds, setup)
    if driven is None:
        return
    yield _group(65265, epoch_ns, {"wheel_speed": np.abs(driven) * 3.6})
    times, identifier, data = _group(65096, epoch_ns, {"speed": np.abs(driven)})
    data[:, 7] = np.where(driven < 0.0, 0xFC, 0xFD)
    yield times, identifier, data
    if {"fl", "fr", "rl", "rr"} <= set(speeds):
        yield _ebc2(epoch_ns, speeds)


def _ebc2(epoch_ns: NDArray[np.int64], speeds: dict[str, Array]) -> _Frames:
    data = np.full((len(epoch_ns), 8), 0xFF, np.uint8)
    axle = 0.5 * 3.6 * (np.abs(speeds["fl"]) + np.abs(speeds["fr"]))
    put(data, bus.AXLE, axle)
    told = bus.AXLE.of(data)
    for wheel, (_, byte) in bus.EBC2_WHEELS.items():
        own = bus.Parameter(65215, "", byte, 1, bus.RELATIVE.scale, bus.RELATIVE.offset, "")
        put(data, own, np.abs(speeds[wheel]) * 3.6 - told)
    return epoch_ns, identifier_of(65215), data


def _gnss(streams: Streams, setup: Setup) -> Iterator[_Frames]:
    """NMEA 2000: rapid position, course and speed, heading, the whole fix, and the rate of turn."""
    if "imu" in streams and "gyro_z_radps" in streams["imu"]:
        rate = -streams["imu"]["gyro_z_radps"]
        yield _group(127251, streams["imu"]["epoch_ns"], {"rate": rate})
    if "gnss" not in streams:
        return
    epoch_ns = streams["gnss"]["epoch_ns"]
    course, speed = maps.course_and_speed(streams)
    if np.isfinite(speed).any():
        compass = np.radians(maps.bearing_deg(course))
        times, identifier, data = _group(129026, epoch_ns, {"course": compass, "speed": speed})
        data[:, 1] = 0xFC  # true north
        yield times, identifier, data
    heading = streams.column("gnss", "heading_rad")
    if np.isfinite(heading).any():
        compass = np.radians(maps.bearing_deg(heading))
        times, identifier, data = _group(127250, epoch_ns, {"heading": compass})
        data[:, 7] = 0xFC
        yield times, identifier, data
    latitude, longitude, height = maps.geodetic(streams, setup)
    if np.isfinite(latitude).any():
        yield _group(129025, epoch_ns, {"latitude": latitude, "longitude": longitude})
        yield from _fixes(streams, epoch_ns, latitude, longitude, height)


def _fixes(
    streams: Streams, epoch_ns: NDArray[np.int64], latitude: Array, longitude: Array, height: Array
) -> Iterator[_Frames]:
    """129029 in seven frames: sequence and counter, the length, then 6 and 7 bytes at a time."""
    body = np.full((len(epoch_ns), 48), 0xFF, np.uint8)
    satellites = streams.column("gnss", "satellites_main").astype(np.float64)
    values = {"latitude": latitude, "longitude": longitude, "height": height,
              "satellites": satellites}  # fmt: skip
    for parameter in bus.PARAMETERS:
        if parameter.pgn == 129029:
            put(body, parameter, values[parameter.name])
    quality = streams.column("gnss", "quality").astype(np.float64)
    method = np.where(np.isfinite(quality), quality, 15.0).astype(np.uint8)
    body[:, 31] = method << 4
    sequence = (np.arange(len(epoch_ns)) % 8).astype(np.uint8) << 5
    length, start = 43, 0
    for counter in range(7):
        size = 6 if counter == 0 else 7
        data = np.full((len(epoch_ns), 8), 0xFF, np.uint8)
        data[:, 0] = sequence | counter
        if counter == 0:
            data[:, 1] = length
        part = body[:, start : min(start + size, length)]
        data[:, 8 - size : 8 - size + part.shape[1]] = part
        start += size
        yield epoch_ns, identifier_of(129029), data
