"""GNSS columns as logged (latitude, speed, course, compass angles) to those of the stream."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.checks.spikes import spikes
from twin.logs.geodesy import enu_m
from twin.logs.losses import Loss
from twin.logs.quantity_columns import Remarks
from twin.streams import Array, Table

Origin = tuple[float, float, float]
FARTHEST_M = 100e3
"""Distance from the first fix at which a position is taken for a mistake."""
STANDING_MPS = 0.5
"""Below this a receiver may leave the course blank; the last one then holds."""
LONGEST_S = 2.5
"""Positions further apart in time than this give no speed."""
BLOCK_ROWS = 100_000
"""Positions that are projected at once: a dozen arrays of as many numbers."""
_GEODETIC = ("latitude_rad", "longitude_rad", "height_m")
_DIRECTED = ("speed_mps", "course_rad", "v_forward_mps", "v_left_mps")


def gnss_table(
    values: Table,
    epoch_ns: NDArray[np.int64],
    remarks: Remarks,
    given: Origin | None = None,
    mount_rad: float = 0.0,
) -> tuple[Table, Origin | None]:
    """Columns of the `gnss` stream (angles in `values` are already counter-clockwise from east).

    v_east = speed cos(course), v_north = speed sin(course)

    Args:
        values: logged columns in SI units. Shape (n,).
        epoch_ns: epochs of the rows [ns]. Shape (n,).
        remarks: notes and losses, added to.
        given: the geodetic origin [deg, deg, m]; None for the first fix.
        mount_rad: angle from the body x axis to the antenna baseline [rad]; the log has the
            heading of the baseline.

    Returns:
        the columns without stamps; the geodetic origin [deg, deg, m] if there is one.
    """
    table = {k: v for k, v in values.items() if k not in (*_GEODETIC, *_DIRECTED)}
    origin = _add_position(table, values, epoch_ns, remarks, given)
    body = {"heading_rad": values["heading_rad"] - mount_rad} if "heading_rad" in values else {}
    _add_velocity(table, {**values, **body}, remarks)
    if "v_east_mps" not in table and {"east_m", "north_m"} <= set(table):
        _differentiate(table, epoch_ns, remarks)
    if "heading_rad" in table:
        table["heading_rad"] = _wrapped(table["heading_rad"])
    return table, origin


def _add_position(
    table: Table,
    values: Table,
    epoch_ns: NDArray[np.int64],
    remarks: Remarks,
    given: Origin | None,
) -> Origin | None:
    if "latitude_rad" not in values and "longitude_rad" not in values:
        if "height_m" in values:
            table["up_m"] = values["height_m"]
        return None
    if not {"latitude_rad", "longitude_rad"} <= set(values):
        raise BadInput("gnss.latitude and gnss.longitude go together; one is missing")
    lat, lon = values["latitude_rad"].copy(), values["longitude_rad"].copy()
    remarks.notes += _drop_non_fixes(lat, lon, values.get("quality"))
    fixed = np.isfinite(lat) & np.isfinite(lon)
    if not fixed.any():
        remarks.notes.append("gnss: no position fix")
        return None
    origin = _project(table, lat, lon, values.get("height_m"), fixed, remarks, given)
    _drop_jumps(table, epoch_ns, remarks)
    return origin


def _drop_non_fixes(lat: Array, lon: Array, quality: Array | None) -> list[str]:
    """Make NaN of what receivers write before a fix: zero and zero, or any place at quality 0."""
    no_fix = (lat == 0.0) & (lon == 0.0)
    if quality is not None:
        no_fix |= (quality == 0) & np.isfinite(lat)
    lat[no_fix] = lon[no_fix] = np.nan
    return [f"gnss: {int(no_fix.sum())} positions without a fix left out"] if no_fix.any() else []


def _project(
    table: Table,
    lat: Array,
    lon: Array,
    height: Array | None,
    fixed: Array,
    remarks: Remarks,
    given: Origin | None,
) -> Origin:
    measured = np.full(len(lat), np.nan) if height is None else height
    heights = measured[np.isfinite(measured)]
    ground_m = float(heights[0]) if len(heights) else 0.0
    filled = np.where(np.isfinite(measured), measured, ground_m)
    # the first fix that is no more than 1 degree from where the log mostly is
    near = fixed & (np.abs(lat - np.nanmedian(lat)) < 0.0175)
    near &= np.abs(lon - np.nanmedian(lon)) < 0.0175
    first = int(np.argmax(near if near.any() else fixed))
    origin = (float(lat[first]), float(lon[first]), ground_m)
    if given is not None:
        origin = (math.radians(given[0]), math.radians(given[1]), given[2])
        filled = np.where(np.isfinite(measured), measured, given[2])
    east, north, up = (np.empty(len(lat)) for _ in range(3))
    for start in range(0, len(lat), BLOCK_ROWS):
        part = slice(start, start + BLOCK_ROWS)
        east[part], north[part], up[part] = enu_m(lat[part], lon[part], filled[part], origin)
    far = np.hypot(east, north) > FARTHEST_M
    if far.any():
        row = int(np.argmax(far))
        distance_km = np.hypot(east[row], north[row]) / 1e3
        says = (
            f"row {row + 1}: a position {distance_km:.0f} km from the first fix;"
            " are the units right?"
        )
        remarks.losses.append(Loss("log", np.flatnonzero(far) + 1, len(far), says))
        east, north, up = (np.where(far, np.nan, v) for v in (east, north, up))
    table["east_m"], table["north_m"] = east, north
    if len(heights):
        table["up_m"] = np.where(np.isfinite(measured), up, np.nan)
    return given or (math.degrees(origin[0]), math.degrees(origin[1]), ground_m)


def _drop_jumps(table: Table, epoch_ns: NDArray[np.int64], remarks: Remarks) -> None:
    """Make NaN of single positions far from those before and after."""
    time_s = (epoch_ns - epoch_ns[0]) * 1e-9
    jump = spikes(table["east_m"], time_s, "position")
    jump |= spikes(table["north_m"], time_s, "position")
    if not jump.any():
        return
    says = f"row {int(np.argmax(jump)) + 1}: a single position far from its neighbours"
    remarks.losses.append(Loss("log", np.flatnonzero(jump) + 1, len(jump), says))
    for column in ("east_m", "north_m", "up_m"):
        if column in table:
            table[column] = np.where(jump, np.nan, table[column])


def _add_velocity(table: Table, values: Table, remarks: Remarks) -> None:
    if "v_forward_mps" in values:
        _add_body_velocity(table, values, remarks)
        return
    if "speed_mps" not in values:
        return
    if "v_east_mps" in values or "v_north_mps" in values:
        raise BadInput("gnss.speed and gnss.v_east or v_north are both given; name one")
    speed = values["speed_mps"]
    course = values.get("course_rad")
    if course is None or not np.isfinite(course).any():
        course = values.get("heading_rad")
        if course is None or not np.isfinite(course).any():
            course = np.zeros(len(speed))
            remarks.notes.append(
                "gnss: speed without course or heading stands along east: good for slip, not for"
                " the track"
            )
        else:
            remarks.notes.append(
                "gnss: no course given, velocity taken along the heading: no sideslip in it"
            )
    held, count = _held(course, speed)
    if count:
        remarks.notes.append(f"gnss: {count} rows at standstill without a course keep the last one")
    table["v_east_mps"], table["v_north_mps"] = speed * np.cos(held), speed * np.sin(held)
    lost = np.isfinite(speed) & np.isnan(table["v_east_mps"])
    if lost.sum() > 0.1 * np.isfinite(speed).sum():
        remarks.notes.append(
            f"gnss: {int(lost.sum())} speeds have no course or heading on their row and are no"
            " velocity"
        )


def _add_body_velocity(table: Table, values: Table, remarks: Remarks) -> None:
    """v_east = v_forward cos(heading) - v_left sin(heading); v_north likewise."""
    if {"speed_mps", "v_east_mps", "v_north_mps"} & set(values):
        raise BadInput("gnss.v_forward and another velocity are both given; name one")
    forward = values["v_forward_mps"]
    left = values.get("v_left_mps", np.zeros(len(forward)))
    heading = values.get("heading_rad")
    if heading is None:
        heading = np.zeros(len(forward))
        remarks.notes.append(
            "gnss: body velocity without a heading stands along east: good for slip, not for the"
            " track"
        )
    table["v_east_mps"] = forward * np.cos(heading) - left * np.sin(heading)
    table["v_north_mps"] = forward * np.sin(heading) + left * np.cos(heading)


def _differentiate(table: Table, epoch_ns: NDArray[np.int64], remarks: Remarks) -> None:
    """Velocity of positions alone: (p_k+1 - p_k-1) / (t_k+1 - t_k-1); no longer than LONGEST_S."""
    known = np.flatnonzero(np.isfinite(table["east_m"]) & np.isfinite(table["north_m"]))
    if len(known) < 3:
        return
    time_s = (epoch_ns[known] - epoch_ns[0]) * 1e-9
    step_s = time_s[2:] - time_s[:-2]
    usable = step_s < 2.0 * LONGEST_S
    for axis in ("east", "north"):
        place = table[f"{axis}_m"][known]
        rate = np.full(len(epoch_ns), np.nan)
        rate[known[1:-1][usable]] = ((place[2:] - place[:-2]) / step_s)[usable]
        table[f"v_{axis}_mps"] = rate
    remarks.notes.append(
        "gnss: no speed is mapped, velocity made of the positions: as exact as they are"
    )


def _held(course: Array, speed: Array) -> tuple[Array, int]:
    """The course, with the last one (east at first) where it is blank at standstill."""
    blank = np.isnan(course) & (np.abs(speed) < STANDING_MPS)
    last = np.maximum.accumulate(np.where(np.isnan(course), -1, np.arange(len(course))))
    known = np.where(last >= 0, course[last], 0.0)
    return np.where(blank, known, course), int(blank.sum())


def _wrapped(angle_rad: Array) -> Array:
    """The angle in (-pi, pi]."""
    return -((np.pi - angle_rad) % (2.0 * np.pi) - np.pi)
