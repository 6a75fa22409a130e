"""The ground as it is drawn: its heights, the furrow before each pass, and what a pass turns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import rerun as rr

from twin.compute import quaternion
from twin.plugins.lookup import Thing
from twin.scenario.plough import FURROW_SIDES
from twin.streams import Table
from twin.viz.bodies import Bodies
from twin.viz.furrows import PLOUGHED_M, Cut, Pass, leaning_rad
from twin.viz.paths import FURROW, LAND
from twin.viz.tools import Array, every, position_w, times

SHALLOWEST_M, STRIPS_HZ = 0.05, 2.0
SHADES = np.array([1.0, 0.88, 1.06, 0.94])
"""Brightness of slices that lie side by side."""
COLOURS = {"asphalt": (104, 104, 108), "gravel": (150, 141, 128), "grass": (118, 142, 84)}
SOIL, OTHER, WET, TURNED = (176, 152, 118), (118, 96, 76), (140, 122, 104), (104, 77, 54)


@dataclass(frozen=True, kw_only=True)
class Ground:
    """What is needed to draw a machine's ground: orientation, maps, and the plough's bodies."""

    world_from_ground: Array = field(default_factory=lambda: np.eye(3))
    maps: Mapping[str, Any] = field(default_factory=dict)
    """`heights` and `mixture`, each with `at(s_m, t_m)`."""
    bodies: Bodies | None = None
    """Bodies of the plough; None without a plough, and then no soil is drawn as turned."""

    def surface_w(self, s_m: Array, t_m: Array, above_m: Array | float = 0.0) -> Array:
        """Points of the surface, lifted by `above_m`. Shape (n, 3)."""
        heights = self.maps.get("heights")
        height = 0.0 if heights is None else heights.at(s_m, t_m)
        local = np.stack([s_m, t_m, np.broadcast_to(height + above_m, np.shape(s_m))], axis=-1)
        return np.asarray(local @ self.world_from_ground.T)


def worked(moments: Table, scenario: Thing, ground: Ground) -> list[tuple[Cut, Pass]]:
    """Each pass with a plough: the open furrow before it, and the tractor's track while it ploughs.

    A pass ploughs where the plough is deeper than 5 cm, and leaves the furrow of the next pass. The
    first furrow exists only if the plough has a furrow side.
    """
    plough, bodies = getattr(scenario, "plough", None), ground.bodies
    if plough is None or bodies is None:
        return []
    local = position_w(moments) @ ground.world_from_ground
    deep = moments.get("depth_m", np.zeros(len(local))) > SHALLOWEST_M
    edges = np.flatnonzero(np.diff(deep.astype(int), prepend=0, append=0))  # in, out, in, out, ...
    start_ns, low_m, high_m = int(moments["epoch_ns"][0]), np.inf, np.inf
    if FURROW_SIDES.get(getattr(plough, "furrow", "none"), 0) != 0:  # one before the first pass
        low_m = scenario.course.approach_m - 2.0
    found: list[tuple[Cut, Pass]] = []
    last = Pass(s_m=np.zeros(0), t_m=np.zeros(0))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        s_m, t_m = local[first:end, 0], local[first:end, 1]
        wall_m = float(np.median(t_m)) + bodies.side * bodies.wall_m
        cut = Cut(
            from_ns=start_ns, wall_m=wall_m, low_m=low_m, high_m=high_m,
            ploughed_m=bodies.open_m + bodies.count * bodies.width_m if found else PLOUGHED_M,
        )  # fmt: skip
        found.append((cut, Pass(s_m=s_m, t_m=t_m)))
        start_ns = int(moments["epoch_ns"][end - 1])
        behind_m = bodies.ahead_m[-1] if s_m[-1] >= s_m[0] else -bodies.ahead_m[-1]
        low_m, high_m = float(s_m.min()) + behind_m, float(s_m.max()) + behind_m
    if not found:  # the plough never came down
        wall_m = bodies.side * bodies.wall_m
        found = [(Cut(from_ns=start_ns, wall_m=wall_m, low_m=low_m, high_m=high_m), last)]
    return found


def log_ploughing(
    recording: rr.RecordingStream, truth: Table, scenario: Thing, ground: Ground
) -> None:
    """Turned slices behind each plough body, and the unploughed ground that it will cut.

    Each piece is logged once, at the time when the body is there. A slice is shown from that time
    on, unploughed ground until that time (`twin.viz.blueprint`).
    """
    if ground.bodies is None:
        return
    moments = every(truth, STRIPS_HZ)
    for entity, pieces, colour in (
        (FURROW, slices(moments, ground, ground.bodies), TURNED),
        (LAND, land(moments, scenario, ground, ground.bodies), soil_colour(scenario)),
    ):
        rows, centre, half_m, xyzw = pieces
        if not len(rows):
            continue
        recording.send_columns(
            entity,
            times({"epoch_ns": moments["epoch_ns"][rows]}),
            rr.Boxes3D.columns(
                centers=centre.reshape(-1, 3), half_sizes=half_m.reshape(-1, 3),
                quaternions=xyzw.reshape(-1, 4),
            ).partition([ground.bodies.count] * len(rows)),
        )  # fmt: skip
        shade = SHADES[np.arange(ground.bodies.count) % len(SHADES)] if entity == FURROW else [1.0]
        colours = (np.outer(shade, colour)).astype(np.uint8)
        style = rr.Boxes3D.from_fields(colors=colours, fill_mode="solid")
        recording.log(entity, style, static=True)


Pieces = tuple[Array, Array, Array, Array]
"""Rows of the moments in which the plough is in the ground (n,); centre (n, m, 3), half sizes
(n, m, 3) and quaternion xyzw (n, m, 4) of a box for each of m bodies."""


def slices(moments: Table, ground: Ground, bodies: Bodies) -> Pieces:
    """The slices that the plough's bodies turned over. Each leans on the one beside it.

    The width w of a slice of depth d is inclined to the furrow's bottom by
    a = asin(min(d / w, 0.85)), its upper edge away from the unploughed ground. So the slice reaches
    up to w sin(a) + d cos(a) above the bottom.

    Args:
        moments: rows of the truth, two per second (n).
        ground: orientation and heights of the ground.
        bodies: of the plough (m).
    """
    rows, s, t, yaw, way = _at_the_bodies(moments, ground, bodies, bodies.open_m)
    depth_m = np.maximum(moments.get("depth_m", np.zeros(1))[rows], SHALLOWEST_M)
    half_m, xyzw = np.empty((len(rows), bodies.count, 3)), np.empty((len(rows), bodies.count, 4))
    half_m[..., 0] = _reach_m(moments, rows)[:, None]
    half_m[..., 1], half_m[..., 2] = 0.5 * bodies.width_m, 0.5 * depth_m[:, None]
    if not len(rows):
        return rows, np.empty((0, bodies.count, 3)), half_m, xyzw
    lean = np.array([leaning_rad(d, bodies.width_m) for d in depth_m])
    middle_m = 0.5 * (bodies.width_m * np.sin(lean) + depth_m * np.cos(lean)) - depth_m
    xyzw[:] = _turned_xyzw(ground.world_from_ground, yaw, way * bodies.side * lean)[:, None]
    return rows, ground.surface_w(s, t, middle_m[:, None]), half_m, xyzw


def land(moments: Table, scenario: Thing, ground: Ground, bodies: Bodies) -> Pieces:
    """The ground that each body will cut, from row to row; the first body's reaches to the wall."""
    over_m = np.zeros(bodies.count)
    over_m[0] = bodies.wall_m - bodies.edge_m[0] - bodies.width_m
    rows, s, t, yaw, _ = _at_the_bodies(moments, ground, bodies, 0.5 * over_m)
    depth_m = getattr(getattr(scenario, "plough", None), "depth_m", 0.25)
    half_m = np.empty((len(rows), bodies.count, 3))
    half_m[..., 0] = _reach_m(moments, rows)[:, None]
    half_m[..., 1], half_m[..., 2] = 0.5 * (bodies.width_m + over_m), 0.5 * depth_m
    if not len(rows):
        return rows, np.empty((0, bodies.count, 3)), half_m, np.empty((0, bodies.count, 4))
    upright = _turned_xyzw(ground.world_from_ground, yaw, np.zeros(len(yaw)))
    xyzw = np.repeat(upright[:, None], bodies.count, axis=1)
    return rows, ground.surface_w(s, t, -0.5 * depth_m), half_m, xyzw


def _turned_xyzw(world_from_ground: Array, yaw_rad: Array, lean_rad: Array) -> Array:
    """Rotations of the ground's axes by a yaw, then a lean about what is ahead. Shape (n, 4)."""
    none = np.zeros(len(yaw_rad))
    yaw = np.stack([np.cos(0.5 * yaw_rad), none, none, np.sin(0.5 * yaw_rad)])
    lean = np.stack([np.cos(0.5 * lean_rad), np.sin(0.5 * lean_rad), none, none])
    level = quaternion.multiplied(quaternion.from_matrix(world_from_ground), yaw)
    return quaternion.multiplied(level, lean)[[1, 2, 3, 0]].T


def _at_the_bodies(
    moments: Table, ground: Ground, bodies: Bodies, aside_m: Array | float
) -> tuple[Array, Array, Array, Array, Array]:
    """Where the bodies are while they are in the ground, or places beside them.

    Args:
        moments: of truth.
        ground: what they stand on.
        bodies: of the plough; on the way back it is turned over, and works to the same land.
        aside_m: how far from each body to the side that it turns to.

    Returns:
        rows (n,); s and t (n, m); yaw (n,); way (n,), 1 there and -1 back.
    """
    rows = np.flatnonzero(moments.get("depth_m", np.zeros(1)) > SHALLOWEST_M)
    place = (position_w(moments) @ ground.world_from_ground)[rows]
    yaws = _headings(moments, ground)
    yaw = yaws[rows]
    way = np.where(np.cos(yaw - yaws[0]) > 0.0, 1.0, -1.0)
    ahead_m = np.array(bodies.ahead_m)
    left_m = way[:, None] * bodies.side * (bodies.aside_m + aside_m)
    s = place[:, :1] + np.cos(yaw)[:, None] * ahead_m - np.sin(yaw)[:, None] * left_m
    t = place[:, 1:2] + np.sin(yaw)[:, None] * ahead_m + np.cos(yaw)[:, None] * left_m
    return rows, s, t, yaw, way


def _reach_m(moments: Table, rows: Array) -> Array:
    """Half the length of a piece, so that it meets the next."""
    return np.asarray(0.5 * np.abs(moments["speed_mps"][rows]) / STRIPS_HZ + 0.03)


def _headings(truth: Table, ground: Ground) -> Array:
    w, x, y, z = (truth[c] for c in ("qw", "qx", "qy", "qz"))
    ahead = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
    local = ahead @ ground.world_from_ground
    return np.asarray(np.arctan2(local[:, 1], local[:, 0]))


def soil_colour(scenario: Thing) -> tuple[int, int, int]:
    """Colour of the land."""
    return COLOURS.get(getattr(getattr(scenario, "soil", None), "preset", ""), SOIL)
