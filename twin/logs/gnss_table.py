"""GNSS columns as logged (latitude, speed, course, compass angles) to those of the stream."""

from __future__ import annotations

import math

import numpy as np

from twin.errors import BadInput
from twin.logs.geodesy import enu_m
from twin.streams import Array, Table

Origin = tuple[float, float, float]
FARTHEST_M = 100e3
"""Distance from the first fix at which a position is taken for a mistake."""
STANDING_MPS = 0.5
"""Below this a receiver may leave the course blank; the last one then holds."""
_GEODETIC = ("latitude_rad", "longitude_rad", "height_m")
_DIRECTED = ("speed_mps", "course_rad")


def gnss_table(values: Table) -> tuple[Table, Origin | None, list[str]]:
    """Columns of the `gnss` stream (angles in `values` are already counter-clockwise from east).

    v_east = speed cos(course), v_north = speed sin(course)

    Returns:
        the columns without stamps; the geodetic origin [deg, deg, m] if there is one; notes.
    """
    table = {k: v for k, v in values.items() if k not in (*_GEODETIC, *_DIRECTED)}
    origin, notes = _add_position(table, values)
    notes += _add_velocity(table, values)
    if "heading_rad" in table:
        table["heading_rad"] = _wrapped(table["heading_rad"])
    return table, origin, notes


def _add_position(table: Table, values: Table) -> tuple[Origin | None, list[str]]:
    if "latitude_rad" not in values and "longitude_rad" not in values:
        if "height_m" in values:
            table["up_m"] = values["height_m"]
        return None, []
    if not {"latitude_rad", "longitude_rad"} <= set(values):
        raise BadInput("gnss.latitude and gnss.longitude go together; one is missing")
    lat, lon = values["latitude_rad"].copy(), values["longitude_rad"].copy()
    notes = _drop_non_fixes(lat, lon, values.get("quality"))
    fixed = np.isfinite(lat) & np.isfinite(lon)
    if not fixed.any():
        return None, [*notes, "gnss: no position fix"]
    return _project(table, lat, lon, values.get("height_m"), int(np.argmax(fixed))), notes


def _drop_non_fixes(lat: Array, lon: Array, quality: Array | None) -> list[str]:
    """Make NaN of what receivers write before a fix: zero and zero, or any place at quality 0."""
    no_fix = (lat == 0.0) & (lon == 0.0)
    if quality is not None:
        no_fix |= (quality == 0) & np.isfinite(lat)
    lat[no_fix] = lon[no_fix] = np.nan
    return [f"gnss: {int(no_fix.sum())} positions without a fix left out"] if no_fix.any() else []


def _project(table: Table, lat: Array, lon: Array, height: Array | None, first: int) -> Origin:
    measured = np.full(len(lat), np.nan) if height is None else height
    heights = measured[np.isfinite(measured)]
    ground_m = float(heights[0]) if len(heights) else 0.0
    filled = np.where(np.isfinite(measured), measured, ground_m)
    origin = (float(lat[first]), float(lon[first]), ground_m)
    east, north, up = enu_m(lat, lon, filled, origin)
    far = np.hypot(east, north) > FARTHEST_M
    if far.any():
        row = int(np.argmax(far))
        distance_km = np.hypot(east[row], north[row]) / 1e3
        raise BadInput(
            f"row {row + 1}: a position {distance_km:.0f} km from the first fix;"
            " are the units right?"
        )
    table["east_m"], table["north_m"] = east, north
    if len(heights):
        table["up_m"] = np.where(np.isfinite(measured), up, np.nan)
    return math.degrees(origin[0]), math.degrees(origin[1]), ground_m


def _add_velocity(table: Table, values: Table) -> list[str]:
    if "speed_mps" not in values:
        return []
    if "v_east_mps" in values or "v_north_mps" in values:
        raise BadInput("gnss.speed and gnss.v_east or v_north are both given; name one")
    speed, notes = values["speed_mps"], []
    course = values.get("course_rad")
    if course is None:
        course = values.get("heading_rad")
        notes.append("gnss: no course given, velocity taken along the heading: no sideslip in it")
    if course is None:
        raise BadInput("gnss.speed needs gnss.course or gnss.heading to be a velocity")
    held, count = _held(course, speed)
    if count:
        notes.append(f"gnss: {count} rows at standstill without a course keep the last one")
    table["v_east_mps"], table["v_north_mps"] = speed * np.cos(held), speed * np.sin(held)
    return notes


def _held(course: Array, speed: Array) -> tuple[Array, int]:
    """The course, with the last one (east at first) where it is blank at standstill."""
    blank = np.isnan(course) & (np.abs(speed) < STANDING_MPS)
    last = np.maximum.accumulate(np.where(np.isnan(course), -1, np.arange(len(course))))
    known = np.where(last >= 0, course[last], 0.0)
    return np.where(blank, known, course), int(blank.sum())


def _wrapped(angle_rad: Array) -> Array:
    """The angle in (-pi, pi]."""
    return -((np.pi - angle_rad) % (2.0 * np.pi) - np.pi)
