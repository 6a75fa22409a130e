"""Quantities of one log that must agree: what does not is a wrong unit, sign or column.

Over stretches of about 20 m, the way between two positions is the integral of the velocity; over
turns, the change of heading is the integral of the yaw rate; on the move, the heading is nearly the
course, and the wheels' speed nearly the ground's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from twin.logs.checks.engine import engine_notes
from twin.logs.speeds import paired_speeds
from twin.logs.units import UNITS
from twin.streams import Array, Streams, Table

STRETCH_M = 20.0
RATIO = 1.25
ANGLE_RAD = math.radians(20.0)
TURN_RAD = math.radians(10.0)
SMALL_RAD, SMALL_ROWS, TOGETHER = math.radians(0.5), 20, 0.8
"""Spread, number and least correlation of turns that are compared where none is large."""
SLIP = 0.25
MOVING_MPS = 0.5
LONGEST_STEP_S, LONGEST_S = 5.0, 120.0
"""Steps and stretches that take longer are not compared, unless all steps are long."""
MOST_ROWS = 200_000
"""Rows of a sensor that are compared: those in the middle of a longer log."""


def disagreements(tables: Mapping[str, Table], mount_rad: float = 0.0) -> list[str]:
    """A note for everything that does not agree; mount_rad from body to antenna baseline."""
    tables = {name: _middle(table) for name, table in tables.items()}
    notes = []
    if "gnss" in tables:
        notes += _way(tables["gnss"]) + _heading_course(tables["gnss"], mount_rad)
        if "imu" in tables:
            notes += _yaw(tables["gnss"], tables["imu"])
    return notes + _speeds(Streams(tables)) + engine_notes(tables)


def _middle(table: Table) -> Table:
    start = max(len(table["epoch_ns"]) - MOST_ROWS, 0) // 2
    return {k: v[start : start + MOST_ROWS] for k, v in table.items()}


def _way(gnss: Table) -> list[str]:
    """Way between positions against speed x time, in length and in direction."""
    if not {"east_m", "north_m", "v_east_mps", "v_north_mps"} <= set(gnss):
        return []
    known = np.all([np.isfinite(gnss[c]) for c in
                    ("east_m", "north_m", "v_east_mps", "v_north_mps")], axis=0)  # fmt: skip
    if known.sum() < 3:
        return []
    east, north = gnss["east_m"][known], gnss["north_m"][known]
    time_s = (gnss["epoch_ns"][known] - gnss["epoch_ns"][known][0]) * 1e-9
    way_east = _integral(time_s, gnss["v_east_mps"][known])
    way_north = _integral(time_s, gnss["v_north_mps"][known])
    moved = np.hypot(np.diff(east), np.diff(north)).sum()
    driven = np.hypot(np.diff(way_east), np.diff(way_north)).sum()
    ends = _stretches(way_east, way_north, time_s)
    if driven < STRETCH_M:
        chord = math.hypot(east.max() - east.min(), north.max() - north.min())
        if chord < 3.0 * STRETCH_M or chord < 3.0 * driven:
            return []
        return [_far(moved if moved < 2.0 * chord else chord, driven, time_s[-1])]
    a, b = ends[:-1], ends[1:]
    short = time_s[b] - time_s[a] < max(LONGEST_S, 10.0 * float(np.median(np.diff(time_s))))
    a, b = a[short], b[short]
    if not len(a):
        return []
    by_place = (east[b] - east[a]) + 1j * (north[b] - north[a])
    by_speed = (way_east[b] - way_east[a]) + 1j * (way_north[b] - way_north[a])
    far = np.abs(by_speed) > 0.5 * STRETCH_M
    if not far.any():
        return []
    if moved < 1.0:
        stays = f"gnss: the positions stay at one place, speed x time is {driven:.4g} m"
        return [stays] if driven > 3.0 * STRETCH_M else []
    notes = []
    ratio = float(np.median(np.abs(by_place[far]) / np.abs(by_speed[far])))
    if not 1.0 / RATIO < ratio < RATIO:
        notes.append(_far(ratio * driven, driven, time_s[-1]))
    off = float(np.median(np.abs(np.angle(by_place[far] / by_speed[far]))))
    if off > ANGLE_RAD:
        notes.append(
            "gnss: positions and velocity disagree in direction by"
            f" {math.degrees(off):.0f} deg at the median; are latitude and longitude swapped, or is"
            " the convention of an angle wrong?"
        )
    return notes


def _far(moved_m: float, driven_m: float, time_s: float) -> str:
    return (
        f"gnss: positions and velocity disagree: the positions move {moved_m:.4g} m in {time_s:.4g}"
        f" s, speed x time is {driven_m:.4g} m; is the unit of time, speed or position wrong"
        f"{_unit_hint(moved_m / max(driven_m, 1e-9))}?"
    )


def _unit_hint(ratio: float) -> str:
    """The pair of units whose mix-up would make a ratio, if there is one."""
    pairs = [
        (f"{is_} taken for {as_}", by_is / by_as)
        for kind in ("speed", "time")
        for is_, by_is in UNITS[kind].items()
        for as_, by_as in UNITS[kind].items()
        if is_ != as_
    ]
    near = [name for name, factor in pairs if abs(ratio / factor - 1.0) < 0.06]
    return f" ({' or '.join(near[:2])})" if near else ""


def _integral(time_s: Array, rate: Array) -> NDArray[np.float64]:
    """Trapezoids; nothing is driven in a gap."""
    step = np.diff(time_s)
    part = np.where(step < _longest_step_s(step), 0.5 * (rate[1:] + rate[:-1]) * step, 0.0)
    return np.concatenate([[0.0], np.cumsum(part)])


def _longest_step_s(step_s: Array) -> float:
    return max(LONGEST_STEP_S, 2.5 * float(np.median(step_s))) if len(step_s) else LONGEST_STEP_S


def _stretches(east: Array, north: Array, time_s: Array) -> NDArray[np.int64]:
    """Rows between which about STRETCH_M are driven, cut at gaps."""
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(east), np.diff(north)))])
    piece = np.floor(driven / STRETCH_M) + 1e6 * np.concatenate(
        [[0.0], np.cumsum(np.diff(time_s) >= _longest_step_s(np.diff(time_s)))]
    )
    return np.concatenate([[0], np.flatnonzero(np.diff(piece) > 0) + 1]).astype(np.int64)


def _heading_course(gnss: Table, mount_rad: float) -> list[str]:
    if not {"heading_rad", "v_east_mps", "v_north_mps"} <= set(gnss):
        return []
    east, north = gnss["v_east_mps"], gnss["v_north_mps"]
    off = gnss["heading_rad"] - mount_rad - np.arctan2(north, east)
    with np.errstate(invalid="ignore"):
        moving = (np.hypot(east, north) > MOVING_MPS) & np.isfinite(off)
    if moving.sum() < 10:
        return []
    turn = np.exp(1j * off[moving])
    apart = float(np.median(np.abs(np.angle(turn))))
    if apart < ANGLE_RAD:
        return []
    mean = math.degrees(float(np.angle(turn.mean())))
    return [
        f"gnss: heading and course are {math.degrees(apart):.0f} deg apart at the median on the"
        f" move (mean {mean:+.0f}); heading_mount_rad in [setup.gnss] turns the antennas, or the"
        " convention of one of them is wrong"
    ]


def _yaw(gnss: Table, imu: Table) -> list[str]:
    """Change of heading, or of course, against the integral of the yaw rate."""
    rate = imu.get("gyro_z_radps")
    if rate is None or not np.isfinite(rate).any():
        return []
    heading = gnss.get("heading_rad", np.full(len(gnss["epoch_ns"]), np.nan))
    if not np.isfinite(heading).any() and "v_east_mps" in gnss:
        east, north = gnss["v_east_mps"], gnss["v_north_mps"]
        fast = np.hypot(east, north) > MOVING_MPS
        heading = np.where(fast, np.arctan2(north, east), np.nan)
    known, turned = np.isfinite(heading), np.isfinite(rate)
    if known.sum() < 3 or turned.sum() < 3:
        return []
    start = imu["epoch_ns"][0]
    at_s = (gnss["epoch_ns"][known] - start) * 1e-9
    time_s = (imu["epoch_ns"][turned] - start) * 1e-9
    by_gyro = np.interp(at_s, time_s, _integral(time_s, rate[turned]))
    by_angle = np.unwrap(heading[known])
    rows = max(round(5.0 / max(float(np.median(np.diff(at_s))), 1e-3)), 1)
    change = np.stack([by_gyro[rows:] - by_gyro[:-rows], by_angle[rows:] - by_angle[:-rows]])
    inside = (at_s[rows:] <= time_s[-1]) & (at_s[:-rows] >= time_s[0])
    inside &= at_s[rows:] - at_s[:-rows] < 10.0
    turning = inside & (np.abs(change[1]) > TURN_RAD) & (np.abs(change[1]) < math.pi)
    if turning.sum() >= 5:
        share = float(np.median(change[0][turning] / change[1][turning]))
    else:
        share = _small_turns(change[:, inside])
    if 1.0 / RATIO < share < RATIO:
        return []
    return [
        f"imu: gyro_z turns {share:.3g} times as far as the heading does; is its unit, its sign or"
        f" the axes wrong{_rate_hint(share)}?"
    ]


def _small_turns(change: Array) -> float:
    """Slope of the gyro's turns against the heading's where none is large, if it is a unit's.

    slope = cov(gyro, heading) / var(heading); 1 where they do not go together or it is no unit's
    """
    gyro, heading = change - change.mean(axis=1, keepdims=True) if change.size else change
    spread = float(np.std(heading)) * float(np.std(gyro)) if len(heading) >= SMALL_ROWS else 0.0
    if spread == 0.0 or float(np.std(heading)) < SMALL_RAD:
        return 1.0
    together = float(np.mean(gyro * heading)) / spread
    slope = float(np.mean(gyro * heading) / np.mean(heading**2))
    return slope if abs(together) > TOGETHER and _rate_hint(slope) else 1.0


def _rate_hint(share: float) -> str:
    """Degrees taken for radians or the other way round, where a ratio of turns says so."""
    for factor, hint in (
        (math.degrees(1.0), "deg/s taken for rad/s"),
        (math.radians(1.0), "rad/s taken for deg/s"),
    ):
        if 1.0 / RATIO < abs(share) / factor < RATIO:
            return f" ({hint})"
    return ""


def _speeds(streams: Streams) -> list[str]:
    """Wheel speed against ground speed, as slip."""
    ground, wheel = paired_speeds(streams)
    moving = (ground > MOVING_MPS) & (wheel > MOVING_MPS)
    if moving.sum() < 10:
        return []
    ratio = float(np.median(wheel[moving] / ground[moving]))
    slip = 1.0 - 1.0 / ratio if ratio > 1.0 else ratio - 1.0
    if abs(slip) <= SLIP:
        return []
    hints = [
        f"{is_} taken for {as_} would give {_slip(ratio * by_is / by_as):+.3f}"
        for is_, by_is in UNITS["speed"].items()
        for as_, by_as in UNITS["speed"].items()
        if is_ != as_ and -0.05 < _slip(ratio * by_is / by_as) < 0.2
    ]
    hint = f" ({hints[0]})" if hints else ""
    return [
        f"median slip of the raw speeds is {slip:+.3f}, beyond {SLIP}: is a unit, the radius or a"
        f" column of the wheels or of the ground speed wrong{hint}?"
    ]


def _slip(ratio: float) -> float:
    return 1.0 - 1.0 / ratio if ratio > 1.0 else ratio - 1.0
