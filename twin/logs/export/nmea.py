"""A GNSS receiver's log as NMEA 0183: GGA, VTG and HDT of every epoch."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.logs.export import maps
from twin.streams import Setup, Streams

_HELD = {"gnss": {"east_m", "north_m", "up_m", "v_east_mps", "v_north_mps", "heading_rad",
                  "quality", "satellites_main"}}  # fmt: skip
_DAY_MS = 86_400_000


def write_nmea(streams: Streams, setup: Setup, directory: Path) -> list[str]:
    """`gnss.nmea` and `map.toml`; what is not in them. Times of day count from midnight as 0.

    Raises:
        BadInput: there is no gnss stream.
    """
    if "gnss" not in streams:
        raise BadInput("NMEA 0183 holds GNSS alone, and the streams have none")
    latitude, longitude, height = maps.geodetic(streams, setup)
    course, speed = maps.course_and_speed(streams)
    heading = streams.column("gnss", "heading_rad")
    quality = streams.column("gnss", "quality")
    satellites = streams.column("gnss", "satellites_main")
    with (directory / "gnss.nmea").open("w", encoding="ascii", newline="") as file:
        for i, epoch_ns in enumerate(streams["gnss"]["epoch_ns"].tolist()):
            at = _clock(epoch_ns)
            bodies = [_gga(at, latitude[i], longitude[i], height[i], quality[i], satellites[i])]
            if math.isfinite(speed[i]):
                bearing = float(maps.bearing_deg(course[i]))
                knots, kmh = speed[i] * 3600.0 / 1852.0, speed[i] * 3.6
                bodies.append(f"GNVTG,{bearing:.3f},T,,M,{knots:.4f},N,{kmh:.4f},K,A")
            if math.isfinite(heading[i]):
                bodies.append(f"GNHDT,{float(maps.bearing_deg(heading[i])):.4f},T")
            file.writelines(sentence(body) for body in bodies)
    (directory / "map.toml").write_text(maps.map_text({}, setup), encoding="utf-8")
    return maps.left_out(streams, _HELD)


def sentence(body: str) -> str:
    """A body with its dollar sign, its checksum and its end."""
    from pynmeagps import calc_checksum

    return f"${body}*{calc_checksum(body)}\r\n"


def _clock(epoch_ns: int) -> str:
    day_ms = (epoch_ns + 500_000) // 1_000_000 % _DAY_MS
    minutes, ms = divmod(day_ms, 60_000)
    return f"{minutes // 60:02d}{minutes % 60:02d}{ms // 1000:02d}.{ms % 1000:03d}"


def _gga(
    at: str, latitude: float, longitude: float, height: float, quality: float, satellites: float
) -> str:
    fix = math.isfinite(latitude) and math.isfinite(longitude)
    place = f"{_angle(latitude, 2, 'NS')},{_angle(longitude, 3, 'EW')}" if fix else ",,,"
    state = int(quality) if math.isfinite(quality) else int(fix)
    used = int(satellites) if math.isfinite(satellites) else 0
    up = f"{height:.4f}" if np.isfinite(height) else ""
    return f"GNGGA,{at},{place},{state if fix else 0},{used:02d},,{up},M,,M,,"


def _angle(degrees: float, digits: int, letters: str) -> str:
    """(d)ddmm.mmmmmmmm and its hemisphere; 1e-8 minutes are 19 micrometres."""
    units = round(abs(degrees) * 60.0 * 1e8)
    whole, minutes = divmod(units, 60 * 10**8)
    letter = letters[0] if degrees >= 0.0 else letters[1]
    return f"{whole:0{digits}d}{minutes // 10**8:02d}.{minutes % 10**8:08d},{letter}"
