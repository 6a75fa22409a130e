"""The scene: machine, ground, furrow, path and fixes."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.palette import SEA
from twin.streams import Setup, Streams, Table
from twin.viz.paths import FOLLOW, FURROW, GNSS, GROUND, MAP, ORANGE, PATH, TRACTOR
from twin.viz.shapes import Shapes, body_poses, log_shapes
from twin.viz.tools import axes_w, every, position_w, rgba, times

Array = NDArray[Any]

GROUND_WIDTH_M, GROUND_MARGIN_M = 40.0, 40.0
FURROW_BEHIND_M, SHALLOWEST_M = 3.0, 0.05


def log_machine(recording: rr.RecordingStream, truth: Table, model: Any) -> None:
    """Every body of the model that can be seen, where truth says it was."""
    shapes = Shapes.of(model)
    positions_w, world_from_body = body_poses(model, truth)  # (n, nbody, 3), (n, nbody, 4)
    for body, name in shapes.bodies.items():
        log_shapes(recording, f"{TRACTOR}/{name}", shapes, body)
        _send_poses(
            recording, f"{TRACTOR}/{name}", truth, positions_w[:, body], world_from_body[:, body]
        )
    log_frame(recording, truth)


def log_frame(recording: rr.RecordingStream, truth: Table) -> None:
    """The body frame, and a frame that is level and turns with it, which the eye rides on."""
    forward, _, _ = axes_w(truth)
    half_heading_rad = 0.5 * np.arctan2(forward[:, 1], forward[:, 0])
    zero = np.zeros_like(half_heading_rad)
    level = np.stack([np.cos(half_heading_rad), zero, zero, np.sin(half_heading_rad)], axis=1)
    _send_poses(recording, FOLLOW, truth, position_w(truth), level)
    pose = np.stack([truth[c] for c in ("qw", "qx", "qy", "qz")], axis=1)  # (n, 4)
    _send_poses(recording, f"{TRACTOR}/frame", truth, position_w(truth), pose)
    recording.log(f"{TRACTOR}/frame", rr.TransformAxes3D(0.6), static=True)


def _send_poses(
    recording: rr.RecordingStream, entity: str, truth: Table, position_w: Array, wxyz: Array
) -> None:
    xyzw = wxyz[:, [1, 2, 3, 0]].astype(np.float32)  # rerun keeps the scalar last
    recording.send_columns(
        entity,
        times(truth),
        rr.Transform3D.columns(translation=position_w.astype(np.float32), quaternion=xyzw),
    )


def log_path(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """Where the rear-axle centre goes, laid on the ground; what is behind it is drawn stronger."""
    moments = every(truth, 4.0)
    _, _, up = axes_w(moments)
    centre = (position_w(moments) - (_wheel_radius_m(setup) - 0.04) * up).astype(np.float32)
    whole = rr.LineStrips3D([centre], colors=[ORANGE], radii=[0.012])
    recording.log(f"{PATH}/whole", whole, static=True)
    pieces = np.stack([centre[:-1], centre[1:]], axis=1)  # (n - 1, 2, 3)
    recording.send_columns(
        PATH,
        times({"epoch_ns": moments["epoch_ns"][1:]}),
        rr.LineStrips3D.columns(strips=list(pieces)),
    )
    style = rr.LineStrips3D.from_fields(colors=[ORANGE], radii=[0.04])
    recording.log(PATH, style, static=True)


def log_ground(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """A ribbon of ground under the path, as steep as the tractor stood on it."""
    moments = every(truth, 2.0)
    forward, left, up = axes_w(moments)  # (n, 3) each
    centre = position_w(moments) - _wheel_radius_m(setup) * up
    before = centre[:1] - GROUND_MARGIN_M * forward[:1]
    beyond = centre[-1:] + GROUND_MARGIN_M * forward[-1:]
    centre = np.concatenate([before, centre, beyond])
    left = np.concatenate([left[:1], left, left[-1:]])
    half = 0.5 * GROUND_WIDTH_M * left
    ribbon = np.stack([centre + half, centre - half], axis=1)  # (m, 2, 3)
    recording.log(GROUND, _strip_mesh(ribbon), static=True)


def log_furrow(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """Turned soil behind the tractor: one flat box per half second, staying as time passes."""
    moments = every(truth, 2.0)
    rows = moments.get("depth_m", np.zeros(len(moments["epoch_ns"]))) > SHALLOWEST_M
    if not np.any(rows):
        return
    done = {name: column[rows] for name, column in moments.items()}
    forward, _, up = axes_w(done)
    centre = position_w(done) - _wheel_radius_m(setup) * up - FURROW_BEHIND_M * forward
    half_length_m = 0.3 * np.abs(done["speed_mps"]) + 0.1  # half a second of way, overlapping
    flat = np.stack([half_length_m, np.full(len(centre), 0.7), np.full(len(centre), 0.02)], axis=1)
    wxyz = np.stack([done[c] for c in ("qw", "qx", "qy", "qz")], axis=1)
    recording.send_columns(
        FURROW,
        times(done),
        rr.Boxes3D.columns(centers=centre, half_sizes=flat, quaternions=wxyz[:, [1, 2, 3, 0]]),
    )
    style = rr.Boxes3D.from_fields(colors=[[101, 74, 48, 255]], fill_mode="solid")
    recording.log(FURROW, style, static=True)


def _wheel_radius_m(setup: Setup) -> float:
    return setup.wheels.radius_m.get("rl", 0.8) if setup.wheels else 0.8


def _strip_mesh(ribbon: Array) -> rr.Mesh3D:
    n = len(ribbon)
    first = 2 * np.arange(n - 1)[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2]), first + np.array([2, 1, 3])])
    normal = np.cross(ribbon[1, 1] - ribbon[0, 1], ribbon[0, 0] - ribbon[0, 1])
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    return rr.Mesh3D(
        vertex_positions=ribbon.reshape(-1, 3).astype(np.float32),
        triangle_indices=triangles,
        vertex_normals=np.tile(normal, (2 * n, 1)),
        albedo_factor=[171, 148, 115, 255],
    )


def log_gnss(recording: rr.RecordingStream, streams: Streams) -> None:
    """Antenna fixes as points, thinned."""
    if "gnss" not in streams or "east_m" not in streams["gnss"]:
        return
    fixes = every(streams["gnss"], 2.0)
    up_m = fixes.get("up_m", np.zeros(len(fixes["epoch_ns"])))
    points = np.stack([fixes["east_m"], fixes["north_m"], up_m], axis=1)
    points = points[np.isfinite(points).all(axis=1)].astype(np.float32)
    recording.log(GNSS, rr.Points3D(points, colors=[rgba(SEA)], radii=[0.04]), static=True)


def log_map(recording: rr.RecordingStream, streams: Streams, setup: Setup) -> None:
    """The drive on a map: small angles about the set-up's origin, on a sphere."""
    assert setup.origin is not None
    fixes = every(streams["gnss"], 1.0)
    metres_per_degree = np.pi / 180.0 * 6_371_000.0
    latitude_deg = setup.origin[0] + fixes["north_m"] / metres_per_degree
    shrink = np.cos(np.radians(setup.origin[0]))
    longitude_deg = setup.origin[1] + fixes["east_m"] / (metres_per_degree * shrink)
    line = np.stack([latitude_deg, longitude_deg], axis=1)
    line = line[np.isfinite(line).all(axis=1)]
    strip = rr.GeoLineStrings(lat_lon=[line], colors=[rgba(SEA)], radii=[rr.Radius.ui_points(2.0)])
    recording.log(MAP, strip, static=True)
