"""The ground as it is drawn: its heights and soils, the last furrow, and what has been ploughed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from twin.scenario.plough import FURROW_SIDES
from twin.streams import Table
from twin.viz.bodies import Bodies
from twin.viz.paths import FURROW, GROUND
from twin.viz.tools import every, position_w, times

Array = NDArray[Any]

CELL_M, FAR_CELL_M, FINE_M, FAR_M = 0.3, 3.0, 7.0, 45.0
"""Mesh near the path and beyond it, and how far each reaches."""
FURROW_AT_M, FURROW_WIDTH_M = 0.72, 0.45
"""Wall and width of the last furrow beside the line, as drawn."""
SHALLOWEST_M, STRIPS_HZ, LEAN_RAD = 0.05, 2.0, 0.6
SLICE_HALF_WIDTH = 0.61
"""Half the width of a slice, as it leans, over that of its body."""
COLOURS = {"asphalt": (104, 104, 108), "gravel": (150, 141, 128), "grass": (118, 142, 84)}
SOIL, OTHER, WET, TURNED = (176, 152, 118), (118, 96, 76), (140, 122, 104), (104, 77, 54)


@dataclass(frozen=True, kw_only=True)
class Ground:
    """What of a machine's ground can be seen."""

    world_from_ground: Array = field(default_factory=lambda: np.eye(3))
    maps: Mapping[str, Any] = field(default_factory=dict)
    """`heights` and `mixture`, each with `at(s_m, t_m)`."""
    bodies: Bodies | None = None
    """Those of the plough that turns it over; None where none is known, and nothing is turned."""

    def surface_w(self, s_m: Array, t_m: Array, above_m: Array | float = 0.0) -> Array:
        """Points of the surface, lifted by `above_m`. Shape (n, 3)."""
        heights = self.maps.get("heights")
        height = 0.0 if heights is None else heights.at(s_m, t_m)
        local = np.stack([s_m, t_m, np.broadcast_to(height + above_m, np.shape(s_m))], axis=-1)
        return np.asarray(local @ self.world_from_ground.T)


@dataclass(frozen=True, kw_only=True)
class Cut:
    """An open furrow: where its wall is, and from when on and over which stretch it lies there."""

    from_ns: int
    wall_m: float
    low_m: float
    high_m: float


def log_ground(recording: rr.RecordingStream, truth: Table, scenario: Any, ground: Ground) -> None:
    """A mesh of the ground about the path: fine beside it, coarse beyond; soils by colour.

    With several passes it is drawn anew at the start of each, with what the one before has cut.
    """
    place = position_w(every(truth, 1.0)) @ ground.world_from_ground
    side, found = cuts(every(truth, 1.0), scenario, ground)
    edge_m = getattr(getattr(scenario, "course", None), "edge_m", None)
    s_m = _nodes(place[:, 0], edge_m is None, 1.0)
    t_m = _nodes(place[:, 1], edge_m is None, 0.0)
    if edge_m is not None:
        t_m = np.linspace(-edge_m, edge_m, 21)
    elif found:  # the mesh has lines where walls stand
        walls_m = np.array([cut.wall_m for cut in found])[:, None]
        edges_m = walls_m + side * np.array([0.0, 0.04, FURROW_WIDTH_M, FURROW_WIDTH_M + 0.05])
        t_m = np.unique(np.concatenate([t_m, edges_m.ravel()]))
    s, t = np.meshgrid(s_m, t_m, indexing="ij")  # (n, m)
    width_m = 1.0 if ground.bodies is None else ground.bodies.width_m  # nothing is cut without
    triangles = rr.Mesh3D.from_fields(triangle_indices=_triangles(len(s_m), len(t_m)))
    recording.log(GROUND, triangles, static=True)
    for k in range(max(1, len(found))):
        lifted_m = _lifted_m(scenario, side, found[: k + 1], width_m, s, t)
        points = ground.surface_w(s, t, lifted_m)  # (n, m, 3)
        recording.send_columns(
            GROUND,
            times({"epoch_ns": np.array([found[k].from_ns if k else truth["epoch_ns"][0]])}),
            rr.Mesh3D.columns(
                vertex_positions=points.reshape(-1, 3).astype(np.float32),
                vertex_normals=_normals(points).reshape(-1, 3).astype(np.float32),
                vertex_colors=_colours(scenario, ground, s, t, lifted_m).reshape(-1, 3),
            ).partition([s.size]),
        )


def cuts(moments: Table, scenario: Any, ground: Ground) -> tuple[int, list[Cut]]:
    """The furrow beside each pass: the one that was there, then what each pass left for the next.

    Returns:
        side: of the line on which the first furrow lies, 1 left and -1 right; 0 without one.
        cuts: in the order of the passes.
    """
    plough = getattr(scenario, "plough", None)
    side = FURROW_SIDES.get(getattr(plough, "furrow", "none"), 0)
    if plough is None or side == 0 or ground.bodies is None:
        return 0, []
    first_m = ground.bodies.ahead_m[0]
    local = position_w(moments) @ ground.world_from_ground
    deep = moments.get("depth_m", np.zeros(len(local))) > SHALLOWEST_M
    edges = np.flatnonzero(np.diff(deep.astype(int), prepend=0, append=0))  # in, out, in, out, ...
    start_ns, low_m, high_m = int(moments["epoch_ns"][0]), scenario.course.approach_m - 2.0, np.inf
    found = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        s_m, t_m = local[first:last, 0], float(np.median(local[first:last, 1]))
        wall_m = t_m + side * FURROW_AT_M
        found.append(Cut(from_ns=start_ns, wall_m=wall_m, low_m=low_m, high_m=high_m))
        start_ns = int(moments["epoch_ns"][last - 1])
        low_m, high_m = float(s_m.min()) + first_m, float(s_m.max()) - first_m
    if not found:  # the plough never came down
        found = [Cut(from_ns=start_ns, wall_m=side * FURROW_AT_M, low_m=low_m, high_m=high_m)]
    return side, found


def log_furrow(recording: rr.RecordingStream, truth: Table, scenario: Any, ground: Ground) -> None:
    """Turned slices behind the shares, which stay as time passes."""
    if ground.bodies is None:
        return
    moments = every(truth, STRIPS_HZ)
    rows, centre, half_m, xyzw = slices(moments, scenario, ground, ground.bodies)
    if not len(rows):
        return
    recording.send_columns(
        FURROW,
        times({"epoch_ns": moments["epoch_ns"][rows]}),
        rr.Boxes3D.columns(
            centers=centre.reshape(-1, 3), half_sizes=half_m.reshape(-1, 3),
            quaternions=xyzw.reshape(-1, 4),
        ).partition([ground.bodies.count] * len(rows)),
    )  # fmt: skip
    style = rr.Boxes3D.from_fields(colors=[[*TURNED, 255]], fill_mode="solid")
    recording.log(FURROW, style, static=True)


def slices(
    moments: Table, scenario: Any, ground: Ground, bodies: Bodies
) -> tuple[Array, Array, Array, Array]:
    """What the shares turned over between moments, each slice leaning on the one before.

    Returns:
        rows: of the moments in which the plough is in the ground. Shape (n,).
        centre, half sizes, quaternion xyzw of each slice. Shapes (n, m, 3), (n, m, 3), (n, m, 4)
            for m bodies.
    """
    rows = np.flatnonzero(moments.get("depth_m", np.zeros(1)) > SHALLOWEST_M)
    place = (position_w(moments) @ ground.world_from_ground)[rows]
    yaw = _headings(moments, ground)
    base = FURROW_SIDES.get(getattr(getattr(scenario, "plough", None), "furrow", "right"), -1) or -1
    side = base * np.where(
        np.cos(yaw[rows] - yaw[0]) > 0.0, 1.0, -1.0
    )  # turned over on the way back
    yaw, count = yaw[rows], bodies.count
    number = 0.5 * (count + 1) - np.arange(count)  # the slice lies one width beside its body
    aside_m = side[:, None] * number * bodies.width_m  # towards the furrow
    ahead_m = np.array(bodies.ahead_m)
    s = place[:, :1] + np.cos(yaw)[:, None] * ahead_m - np.sin(yaw)[:, None] * aside_m
    t = place[:, 1:2] + np.sin(yaw)[:, None] * ahead_m + np.cos(yaw)[:, None] * aside_m
    reach_m = 0.6 * np.abs(moments["speed_mps"][rows]) / STRIPS_HZ + 0.05
    half_m = np.empty((len(rows), count, 3))
    half_m[:] = np.array([0.0, SLICE_HALF_WIDTH * bodies.width_m, 0.07])
    half_m[..., 0] = reach_m[:, None]
    if not len(rows):
        return rows, np.empty((0, count, 3)), half_m, np.empty((0, count, 4))
    leaning = Rotation.from_euler("ZX", np.stack([yaw, -LEAN_RAD * side], axis=1))
    turned = (Rotation.from_matrix(ground.world_from_ground) * leaning).as_quat()  # (n, 4)
    xyzw = np.repeat(turned[:, None], count, axis=1)
    return rows, ground.surface_w(s, t, 0.05), half_m, xyzw


def _headings(truth: Table, ground: Ground) -> Array:
    w, x, y, z = (truth[c] for c in ("qw", "qx", "qy", "qz"))
    ahead = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
    local = ahead @ ground.world_from_ground
    return np.asarray(np.arctan2(local[:, 1], local[:, 0]))


def _nodes(places: Array, field_beyond: bool, margin_m: float) -> Array:
    """Lines of the mesh along one axis: close near the path, and far apart beyond."""
    low, high = float(places.min()), float(places.max())
    if not field_beyond:
        return np.arange(low - margin_m, high + margin_m + 1.0, 0.1)
    cell = max(CELL_M, (high - low) / 1000.0)
    near = np.arange(low - FINE_M, high + FINE_M, cell)
    below = np.arange(near[0] - FAR_M, near[0] - 0.1, FAR_CELL_M)
    above = np.arange(near[-1] + FAR_CELL_M, near[-1] + FAR_M, FAR_CELL_M)
    return np.concatenate([below, near, above])


def _lifted_m(
    scenario: Any, side: int, found: list[Cut], width_m: float, s: Array, t: Array
) -> Array:
    """Height of the ground above the field as it was: open furrow, and ridges of turned soil."""
    ridges = 0.05 * np.sin(2.0 * np.pi * t / width_m) + 0.03 * np.sin(3.1 * s + 5.0 * t)
    lifted = np.zeros_like(s)
    for cut in found:
        along = np.clip((s - cut.low_m) / 3.0, 0.0, 1.0) * np.clip((cut.high_m - s) / 3.0, 0.0, 1.0)
        aside = side * (t - cut.wall_m)
        open_ = (aside > 1e-6) & (aside < FURROW_WIDTH_M + 0.05)
        turned = (aside >= FURROW_WIDTH_M + 0.05 - 1e-6) & (aside < 6.0)
        cut_m = open_ * -scenario.plough.depth_m + turned * (ridges + 0.03)
        lifted += along * (open_ | turned) * (cut_m - lifted)
    return np.asarray(lifted)


def _colours(scenario: Any, ground: Ground, s: Array, t: Array, lifted: Array) -> Array:
    """Colour of each node: the soil, the other soil, weaker stretches, what was ploughed."""
    preset = getattr(getattr(scenario, "soil", None), "preset", "")
    colour = np.broadcast_to(np.array(COLOURS.get(preset, SOIL), float), (*s.shape, 3))
    mixture = ground.maps.get("mixture")
    if mixture is not None:
        colour = _blend(colour, OTHER, mixture.at(s, t))
    for patch in getattr(getattr(scenario, "field", None), "patches", ()):
        inside = (s >= patch.start_m) & (s <= patch.start_m + patch.length_m)
        colour = _blend(colour, WET, inside * float(patch.friction_factor < 1.0))
    colour = _blend(colour, TURNED, np.abs(lifted) > 1e-6)
    grain = np.random.default_rng(0).normal(1.0, 0.035, s.shape)[..., None]
    return np.clip(colour * grain, 0.0, 255.0).astype(np.uint8)


def _blend(colour: Array, other: tuple[int, int, int], share: Array) -> Array:
    weight = np.asarray(share, float)[..., None]
    return np.asarray((1.0 - weight) * colour + weight * np.array(other, float))


def _triangles(n: int, m: int) -> Array:
    corner = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()  # (k,)
    lower = np.stack([corner, corner + m, corner + 1], axis=1)
    upper = np.stack([corner + 1, corner + m, corner + m + 1], axis=1)
    return np.concatenate([lower, upper]).astype(np.uint32)


def _normals(points: Array) -> Array:
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))
