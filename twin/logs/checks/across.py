"""A heading across the course: antennas that stand side by side, where the map does not say so."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array, Table

ACROSS_RAD = math.radians(60.0), math.radians(120.0)
"""Between heading and course: no tractor drives so, and a speed along the heading is near zero."""
MOVING_MPS = 0.5
STRAIGHT_RAD, STRAIGHT_S = math.radians(5.0), 1.0
"""The course turns less than this in this time."""
LEAST_ROWS = 10
TOGETHER = 0.9
"""Length of the mean of twice the angles as unit vectors, 1 where all are the same."""
SQUARE_RAD = math.radians(10.0)
"""A mount so near to a right angle is taken for one."""


def mount_across_rad(
    heading_rad: Array, course_rad: Array, speed_mps: Array, time_s: Array
) -> float | None:
    """The mount that lays the heading along the course; None where it is not across.

    mount = angle(mean exp(2 i (heading - course))) / 2   over rows of straight driving

    Twice the angle is the same forwards and in reverse; most rows are taken to be driven forwards.

    Args:
        heading_rad, course_rad: counter-clockwise from east, shape (n,).
        speed_mps: over ground, shape (n,).
        time_s: rising, shape (n,).
    """
    with np.errstate(invalid="ignore"):
        known = (speed_mps > MOVING_MPS) & np.isfinite(heading_rad) & np.isfinite(course_rad)
    if known.sum() < LEAST_ROWS:
        return None
    course = course_rad[known]
    straight = _straight(course, time_s[known])
    turn = np.exp(1j * (heading_rad[known] - course))[straight]
    if len(turn) < LEAST_ROWS or abs(np.mean(turn**2)) < TOGETHER:
        return None
    axis = 0.5 * float(np.angle(np.mean(turn**2)))
    ahead = float(np.mean(np.cos(np.angle(turn) - axis))) >= 0.0
    mount = axis if ahead else math.remainder(axis + math.pi, 2.0 * math.pi)
    if not ACROSS_RAD[0] < abs(mount) < ACROSS_RAD[1]:
        return None
    square = math.copysign(math.pi / 2, mount)
    return square if abs(mount - square) < SQUARE_RAD else mount


def along_course(gnss: Table, mount_rad: float) -> tuple[Table, list[str]]:
    """The table without a heading that lies across the course, and a note that says so."""
    if not {"heading_rad", "v_east_mps", "v_north_mps"} <= set(gnss):
        return gnss, []
    east, north = gnss["v_east_mps"], gnss["v_north_mps"]
    time_s = (gnss["epoch_ns"] - gnss["epoch_ns"][0]) * 1e-9
    off = mount_across_rad(
        gnss["heading_rad"] - mount_rad, np.arctan2(north, east), np.hypot(east, north), time_s
    )
    if off is None:
        return gnss, []
    would = math.remainder(mount_rad + off, 2.0 * math.pi)
    note = (
        "gnss: the heading is not used and the course stands for it: they are"
        f" {math.degrees(abs(off)):.0f} deg apart in straight driving, as where the antennas stand"
        f" side by side; heading_mount_rad = {would:.4f} in [setup.gnss] would use it"
    )
    return {name: column for name, column in gnss.items() if name != "heading_rad"}, [note]


def _straight(course_rad: Array, time_s: Array) -> NDArray[np.bool_]:
    rows = max(round(STRAIGHT_S / max(float(np.median(np.diff(time_s))), 1e-3)), 1)
    later = np.minimum(np.arange(len(course_rad)) + rows, len(course_rad) - 1)
    return np.asarray(
        np.abs(np.angle(np.exp(1j * (course_rad[later] - course_rad)))) < STRAIGHT_RAD
    )
