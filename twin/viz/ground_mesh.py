"""The mesh of the ground: fine where it is worked, coarse beyond, drawn anew where it changes.

With several passes the mesh is cut along them into strips, one between each two walls of furrows.
A strip is drawn again only when a pass begins before which it has changed, so that a recording of a
day grows with the number of passes and not with its square. A mesh has at most MOST_CORNERS
corners; where they do not suffice, the lines across the passes lie further apart.
"""

from __future__ import annotations

import numpy as np
import rerun as rr

from twin.plugins.lookup import Thing
from twin.streams import Table
from twin.viz.bodies import Bodies
from twin.viz.furrows import (
    BANK_M,
    Cut,
    Pass,
    leaning_rad,
    left_by,
    worked_by,
)
from twin.viz.ground import OTHER, TURNED, WET, Ground, soil_colour, worked
from twin.viz.mesh import normals, triangles
from twin.viz.paths import GROUND
from twin.viz.tools import Array, every, position_w, times

CELL_M, FAR_CELL_M, FINE_M, FAR_M = 0.3, 3.0, 7.0, 45.0
"""Mesh near the path and beyond it, and how far each reaches."""
MOST_CORNERS = 400_000
FAR_SHARE = 0.25
"""Share of the lines across that may lie beyond the worked ground."""
Furrows = list[tuple[Cut, Pass]]
Near = dict[int, tuple[Cut, Pass]]
"""Number of a pass -> the furrow before it, and its way."""


def log_ground(
    recording: rr.RecordingStream, truth: Table, scenario: Thing, ground: Ground
) -> None:
    """A mesh of the ground about the path: fine beside it, coarse beyond; soils by colour.

    With several passes each strip is drawn anew at the start of a pass before which it changed. The
    furrows of a pass are open from its start; `log_ploughing` lays the land over them that is still
    to be ploughed, and the slices into them that were turned.
    """
    moments = every(truth, 1.0)
    found = worked(moments, scenario, ground)
    s_m, t_m = lines(position_w(moments) @ ground.world_from_ground, found, scenario, ground)
    s, t = np.meshgrid(s_m, t_m, indexing="ij")  # (n, m)
    soil = _soil_colours(scenario, ground, s, t)
    grain = np.random.default_rng(0).normal(1.0, 0.035, s.shape)[..., None]
    start_ns = truth["epoch_ns"][0]
    parts = strips(t_m, found)
    for number, (first, end) in enumerate(parts):
        entity = GROUND if len(parts) == 1 else f"{GROUND}/strip_{number}"
        corners = triangles(len(s_m), end - first).astype(np.uint32)
        recording.log(entity, rr.Mesh3D.from_fields(triangle_indices=corners), static=True)
        part = slice(max(first - 1, 0), end + 1)  # with a line beyond each edge, for the normals
        own = slice(first - part.start, end - part.start)
        near = reaching(found, ground, float(t_m[first]), float(t_m[end - 1]))
        for k in begins(near, len(found)):
            lifted_m, cut = _lifted_m(scenario, ground, near, k, s[:, part], t[:, part])
            points = ground.surface_w(s[:, part], t[:, part], lifted_m)  # (n, m, 3)
            colours = np.clip(_blend(soil[:, part], TURNED, cut) * grain[:, part], 0.0, 255.0)
            shown = (points[:, own], normals(points)[:, own], colours[:, own])
            at_ns = found[k][0].from_ns if k else start_ns
            recording.send_columns(
                entity,
                times({"epoch_ns": np.array([at_ns])}),
                rr.Mesh3D.columns(
                    vertex_positions=shown[0].reshape(-1, 3).astype(np.float32),
                    vertex_normals=shown[1].reshape(-1, 3).astype(np.float32),
                    vertex_colors=shown[2].reshape(-1, 3).astype(np.uint8),
                ).partition([len(s_m) * (end - first)]),
            )


def strips(t_m: Array, found: Furrows) -> list[tuple[int, int]]:
    """First line of each strip and the line after its last; strips share the line at their wall."""
    walls_m = sorted({cut.wall_m for cut, _ in found})
    if len(walls_m) < 2:
        return [(0, len(t_m))]
    at = np.unique(np.clip(np.searchsorted(t_m, walls_m), 1, len(t_m) - 2))
    return list(zip([0, *at.tolist()], [*(at + 1).tolist(), len(t_m)], strict=True))


def reaching(found: Furrows, ground: Ground, low_m: float, high_m: float) -> Near:
    """Those furrows and passes that reach between two lines along them, by their number."""
    if ground.bodies is None:
        return {}
    wide_m = 1.0 + ground.bodies.open_m + ground.bodies.count * ground.bodies.width_m
    reach_m = [max(wide_m, cut.ploughed_m) for cut, _ in found]
    return {
        k: each
        for k, each in enumerate(found)
        if low_m - reach_m[k] < each[0].wall_m < high_m + reach_m[k]
    }


def begins(near: Near, count: int) -> list[int]:
    """The passes, of `count`, at whose start a strip may have changed; at 0 it is first drawn."""
    return sorted({0, *near, *(k + 1 for k in near if k + 1 < count)})


def lines(place: Array, found: Furrows, scenario: Thing, ground: Ground) -> tuple[Array, Array]:
    """Lines of the mesh across the ground's axis and along it, s (n,) and t (m,), rising.

    Args:
        place: the path on the ground (k, 3).
        found: furrows and passes.
        scenario, ground: what is driven, and what on.
    """
    course = getattr(scenario, "course", None)
    edge_m = getattr(course, "edge_m", None)
    if edge_m is not None:
        low, high = float(place[:, 0].min()), float(place[:, 0].max())
        return np.arange(low - 1.0, high + 2.0, 0.1), np.linspace(-edge_m, edge_m, 21)
    t_m = _nodes(place[:, 1], place[:, 1], CELL_M, FAR_CELL_M)
    if found and ground.bodies is not None:
        t_m = _with_edges(t_m, found, ground.bodies, scenario)
    most = MOST_CORNERS / len(t_m)
    driven = [way.s_m for _, way in found if len(way.s_m)]
    near = np.concatenate(driven) if len(found) > 1 and driven else place[:, 0]
    cell_m = max(CELL_M, np.ptp(near) / 1000.0, np.ptp(near) / ((1.0 - FAR_SHARE) * most))
    far_m = max(FAR_CELL_M, (np.ptp(place[:, 0]) + 2.0 * FAR_M) / (FAR_SHARE * most))
    return _nodes(near, place[:, 0], cell_m, far_m), t_m


def _nodes(near: Array, path: Array, cell_m: float, far_m: float) -> Array:
    """Lines along one axis: close about places that are near, far apart up to beyond the path."""
    low, high = float(path.min()) - FINE_M - FAR_M, float(path.max()) + FINE_M + FAR_M
    fine = np.arange(near.min() - FINE_M, near.max() + FINE_M, cell_m)
    below = np.arange(low, fine[0] - 0.1, far_m)
    above = np.arange(fine[-1] + far_m, high, far_m)
    return np.concatenate([below, fine, above])


def _with_edges(t_m: Array, found: Furrows, bodies: Bodies, scenario: Thing) -> Array:
    """Lines of the mesh with some more: where walls stand, and at valleys and crests of slices."""
    rising_m = bodies.width_m * np.cos(leaning_rad(scenario.plough.depth_m, bodies.width_m)) ** 2
    last_m = bodies.wall_m - bodies.edge_m[-1]
    lines = [t_m]
    for cut, _ in found:
        valleys = np.arange(bodies.open_m + bodies.width_m, cut.ploughed_m, bodies.width_m)
        edges = [
            0.0, 0.04, bodies.open_m, bodies.open_m + BANK_M, *valleys,
            *(valleys - bodies.width_m + rising_m), -last_m, -last_m + 0.04,
        ]  # fmt: skip
        lines.append(cut.wall_m + bodies.side * np.array(edges))
    joined = np.unique(np.round(np.concatenate(lines), 3))
    return np.asarray(joined[np.append(True, np.diff(joined) > 0.005)])


def _lifted_m(
    scenario: Thing, ground: Ground, near: Near, k: int, s: Array, t: Array
) -> tuple[Array, Array]:
    """Height of the ground above the field as it was, and where it was worked.

    The furrows before pass k and those before it, and all that it and the later ones will open.
    """
    lifted, worked = np.zeros_like(s), np.zeros(s.shape, bool)
    if not near or ground.bodies is None:
        return lifted, worked
    bodies, depth_m = ground.bodies, scenario.plough.depth_m
    done = [left_by(cut, bodies, depth_m, s, t) for i, (cut, _) in near.items() if i <= k]
    to_come = [
        worked_by(way, bodies, depth_m, s, t, slices=False)[:2]
        for i, (_, way) in near.items()
        if i >= k
    ]
    for height, here in (*done, *to_come):
        lifted, worked = np.where(here, height, lifted), worked | here
    return lifted, worked


def _soil_colours(scenario: Thing, ground: Ground, s: Array, t: Array) -> Array:
    """Colour of each node before it is ploughed: the soil, the other soil, weaker stretches."""
    colour = np.broadcast_to(np.array(soil_colour(scenario), float), (*s.shape, 3))
    mixture = ground.maps.get("mixture")
    if mixture is not None:
        colour = _blend(colour, OTHER, mixture.at(s, t))
    friction = np.ones(s.shape)
    for patch in getattr(getattr(scenario, "field", None), "patches", ()):
        inside = (s >= patch.start_m) & (s <= patch.start_m + patch.length_m)
        friction = np.where(inside, friction * patch.friction_factor, friction)
    return _blend(colour, WET, friction < 1.0)


def _blend(colour: Array, other: tuple[int, int, int], share: Array) -> Array:
    weight = np.asarray(share, float)[..., None]
    return np.asarray((1.0 - weight) * colour + weight * np.array(other, float))
