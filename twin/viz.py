"""The picture: everything about rerun is here, entity paths, logging and blueprint.

Entities mirror the frames: `world/truth/tractor/<body>` moves, what does not move is static, truth
and estimates are siblings. Two timelines, `sim_time` and `step`; bulk by `send_columns`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twin.palette import SEA, colours
from twin.runfolder import RunLike
from twin.scores import moving
from twin.streams import Setup, Streams, Table
from twin.viz_shapes import Shapes, body_poses, log_shapes

Array = NDArray[Any]

APPLICATION = "tractor-twin"
SIM_TIME, STEP = "sim_time", "step"

WORLD = "world"
TRACTOR = "world/truth/tractor"
PATH = "world/truth/path"
FURROW = "world/truth/furrow"
FOLLOW = "world/truth/follow"
GROUND = "world/ground"
GNSS = "world/sensors/gnss"
MAP = "map/gnss"
SLIP, SPEED, SIDESLIP, DRAFT, DEPTH = (
    "plots/slip", "plots/speed", "plots/sideslip", "plots/draft", "plots/depth",
)  # fmt: skip

DARK, SKY, ORANGE = [22, 23, 26], [214, 226, 235], [230, 159, 0]
TRUTH_COLOUR = "#F5F5F5"
"""Truth is white here, on plots that are dark whatever the viewer's theme."""

POSE_RATE_HZ = 15.0
PLOT_RATE_HZ = 20.0
STEP_S = 0.002
"""`step` counts physics steps [s]."""
GROUND_WIDTH_M, GROUND_MARGIN_M = 40.0, 40.0
FURROW_BEHIND_M, SHALLOWEST_M = 3.0, 0.05


def record(run: RunLike, path: Path, *, model: Any | None = None) -> None:
    """Write a simulated run as a recording.

    Args:
        run: with truth (pose and joint columns).
        path: the .rrd file.
        model: compiled mujoco.MjModel whose visual geoms are drawn; None draws the path alone.
    """
    truth = run.truth
    assert truth is not None, "a simulated run has its truth"
    with _Recording(path, _simulated(truth)) as recording:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        moments = _every(truth, POSE_RATE_HZ)
        _log_ground(recording, truth, run.setup)
        _log_furrow(recording, truth, run.setup)
        _log_path(recording, truth, run.setup)
        _log_gnss(recording, run.streams)
        if model is not None:
            _log_machine(recording, moments, model)
        else:
            _log_frame(recording, moments)
        _plot_all(recording, run.estimates, truth)


def log(
    path: Path,
    *,
    streams: Streams,
    setup: Setup,
    estimates: Mapping[str, Table],
    reference: Table | None = None,
) -> None:
    """Write the estimates of a recorded drive, on a map where its set-up has an origin."""
    geodetic = setup.origin is not None and "gnss" in streams
    spans = [t for t in (*estimates.values(), *streams.tables.values()) if len(t["epoch_ns"])]
    with _Recording(path, _logged(spans[0], geodetic)) as recording:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        _log_gnss(recording, streams)
        if geodetic:
            _log_map(recording, streams, setup)
        _plot_all(recording, estimates, reference or {})


def view(path: Path) -> None:
    """Open a recording in the viewer and return."""
    import subprocess
    import sys

    command = [sys.executable, "-m", "rerun", str(path)]
    quiet = subprocess.DEVNULL
    subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True)


# --- what is logged -------------------------------------------------------------------------


def _log_machine(recording: rr.RecordingStream, truth: Table, model: Any) -> None:
    shapes = Shapes.of(model)
    positions_w, world_from_body = body_poses(model, truth)  # (n, nbody, 3), (n, nbody, 4)
    for body, name in shapes.bodies.items():
        log_shapes(recording, f"{TRACTOR}/{name}", shapes, body)
        _send_poses(
            recording, f"{TRACTOR}/{name}", truth, positions_w[:, body], world_from_body[:, body]
        )
    _log_frame(recording, truth)


def _log_frame(recording: rr.RecordingStream, truth: Table) -> None:
    """The body frame, and a frame that is level and turns with it, which the eye rides on."""
    forward, _, _ = _axes_w(truth)
    half_heading_rad = 0.5 * np.arctan2(forward[:, 1], forward[:, 0])
    zero = np.zeros_like(half_heading_rad)
    level = np.stack([np.cos(half_heading_rad), zero, zero, np.sin(half_heading_rad)], axis=1)
    _send_poses(recording, FOLLOW, truth, _position_w(truth), level)
    pose = np.stack([truth[c] for c in ("qw", "qx", "qy", "qz")], axis=1)  # (n, 4)
    _send_poses(recording, f"{TRACTOR}/frame", truth, _position_w(truth), pose)
    recording.log(f"{TRACTOR}/frame", rr.TransformAxes3D(0.6), static=True)


def _send_poses(
    recording: rr.RecordingStream, entity: str, truth: Table, position_w: Array, wxyz: Array
) -> None:
    xyzw = wxyz[:, [1, 2, 3, 0]].astype(np.float32)  # rerun keeps the scalar last
    recording.send_columns(
        entity,
        _times(truth),
        rr.Transform3D.columns(translation=position_w.astype(np.float32), quaternion=xyzw),
    )


def _log_path(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """Where the rear-axle centre goes, laid on the ground; what is behind it is drawn stronger."""
    moments = _every(truth, 4.0)
    _, _, up = _axes_w(moments)
    centre = (_position_w(moments) - (_wheel_radius_m(setup) - 0.04) * up).astype(np.float32)
    whole = rr.LineStrips3D([centre], colors=[ORANGE], radii=[0.012])
    recording.log(f"{PATH}/whole", whole, static=True)
    pieces = np.stack([centre[:-1], centre[1:]], axis=1)  # (n - 1, 2, 3)
    recording.send_columns(
        PATH,
        _times({"epoch_ns": moments["epoch_ns"][1:]}),
        rr.LineStrips3D.columns(strips=list(pieces)),
    )
    style = rr.LineStrips3D.from_fields(colors=[ORANGE], radii=[0.04])
    recording.log(PATH, style, static=True)


def _log_ground(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """A ribbon of ground under the path, as steep as the tractor stood on it."""
    moments = _every(truth, 2.0)
    forward, left, up = _axes_w(moments)  # (n, 3) each
    centre = _position_w(moments) - _wheel_radius_m(setup) * up
    before = centre[:1] - GROUND_MARGIN_M * forward[:1]
    beyond = centre[-1:] + GROUND_MARGIN_M * forward[-1:]
    centre = np.concatenate([before, centre, beyond])
    left = np.concatenate([left[:1], left, left[-1:]])
    half = 0.5 * GROUND_WIDTH_M * left
    ribbon = np.stack([centre + half, centre - half], axis=1)  # (m, 2, 3)
    recording.log(GROUND, _strip_mesh(ribbon), static=True)


def _log_furrow(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """Turned soil behind the tractor: one flat box per half second, staying as time passes."""
    moments = _every(truth, 2.0)
    rows = moments.get("depth_m", np.zeros(len(moments["epoch_ns"]))) > SHALLOWEST_M
    if not np.any(rows):
        return
    done = {name: column[rows] for name, column in moments.items()}
    forward, _, up = _axes_w(done)
    centre = _position_w(done) - _wheel_radius_m(setup) * up - FURROW_BEHIND_M * forward
    half_length_m = 0.3 * np.abs(done["speed_mps"]) + 0.1  # half a second of way, overlapping
    flat = np.stack([half_length_m, np.full(len(centre), 0.7), np.full(len(centre), 0.02)], axis=1)
    wxyz = np.stack([done[c] for c in ("qw", "qx", "qy", "qz")], axis=1)
    recording.send_columns(
        FURROW,
        _times(done),
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


def _log_gnss(recording: rr.RecordingStream, streams: Streams) -> None:
    """Antenna fixes as points, thinned."""
    if "gnss" not in streams or "east_m" not in streams["gnss"]:
        return
    fixes = _every(streams["gnss"], 2.0)
    up_m = fixes.get("up_m", np.zeros(len(fixes["epoch_ns"])))
    points = np.stack([fixes["east_m"], fixes["north_m"], up_m], axis=1)
    points = points[np.isfinite(points).all(axis=1)].astype(np.float32)
    recording.log(GNSS, rr.Points3D(points, colors=[_rgba(SEA)], radii=[0.04]), static=True)


def _log_map(recording: rr.RecordingStream, streams: Streams, setup: Setup) -> None:
    """The drive on a map: small angles about the set-up's origin, on a sphere."""
    assert setup.origin is not None
    fixes = _every(streams["gnss"], 1.0)
    metres_per_degree = np.pi / 180.0 * 6_371_000.0
    latitude_deg = setup.origin[0] + fixes["north_m"] / metres_per_degree
    shrink = np.cos(np.radians(setup.origin[0]))
    longitude_deg = setup.origin[1] + fixes["east_m"] / (metres_per_degree * shrink)
    line = np.stack([latitude_deg, longitude_deg], axis=1)
    line = line[np.isfinite(line).all(axis=1)]
    strip = rr.GeoLineStrings(lat_lon=[line], colors=[_rgba(SEA)], radii=[rr.Radius.ui_points(2.0)])
    recording.log(MAP, strip, static=True)


def _plot_all(
    recording: rr.RecordingStream, estimates: Mapping[str, Table], truth: Mapping[str, Array]
) -> None:
    palette = colours(estimates)
    for name, table in estimates.items():
        rows = moving(_every(table, PLOT_RATE_HZ))
        _plot(recording, f"{SLIP}/{name}", rows, "slip", name, palette[name])
        _plot_band(recording, f"{SLIP}/{name}", rows, name, palette[name])
        _plot(recording, f"{SPEED}/{name}", rows, "speed_mps", name, palette[name])
        _plot(recording, f"{SIDESLIP}/{name}", rows, "sideslip_m", name, palette[name])
    if len(truth.get("epoch_ns", ())):
        rows = _every(dict(truth), PLOT_RATE_HZ)
        _plot(recording, f"{SLIP}/truth", rows, "slip", "truth", TRUTH_COLOUR, 2.5)
        _plot(recording, f"{SPEED}/truth", rows, "speed_mps", "truth", TRUTH_COLOUR, 2.5)
        _plot(recording, f"{SPEED}/wheels", rows, "wheel_speed_mps", "wheels (w R)", SEA)
        _plot(recording, f"{SIDESLIP}/truth", rows, "sideslip_m", "truth", TRUTH_COLOUR, 2.5)
        _plot(recording, f"{DRAFT}/truth", rows, "draft_n", "draft [kN]", TRUTH_COLOUR, scale=1e-3)
        _plot(recording, f"{DEPTH}/truth", rows, "depth_m", "depth [m]", TRUTH_COLOUR)


def _plot(
    recording: rr.RecordingStream,
    entity: str,
    table: Table,
    column: str,
    name: str,
    colour: str,
    width: float = 1.5,
    scale: float = 1.0,
) -> None:
    """One column as a line; nothing where the table has no such column."""
    if column not in table:
        return
    _plot_values(recording, entity, table, scale * table[column], name, colour, width)


def _plot_band(
    recording: rr.RecordingStream, entity: str, table: Table, name: str, colour: str
) -> None:
    if "slip" not in table or "slip_sd" not in table:
        return
    for sign, edge in ((2.0, "upper"), (-2.0, "lower")):
        values = table["slip"] + sign * table["slip_sd"]
        label = f"{name} {sign:+.0f} sd"
        _plot_values(recording, f"{entity}/{edge}", table, values, label, colour + "66", 0.75)


def _plot_values(
    recording: rr.RecordingStream,
    entity: str,
    table: Table,
    values: Array,
    name: str,
    colour: str,
    width: float,
) -> None:
    known = np.isfinite(values)
    style = rr.SeriesLines(colors=[_rgba(colour)], names=[name], widths=[width])
    recording.log(entity, style, static=True)
    times = _times({"epoch_ns": table["epoch_ns"][known]})
    recording.send_columns(entity, times, rr.Scalars.columns(scalars=values[known]))


# --- blueprint ------------------------------------------------------------------------------


def _simulated(truth: Table) -> rrb.Blueprint:
    """3D view left, riding with the tractor; plots right."""
    eye = rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=(5.0, 8.0, 4.0),
        look_target=(-0.7, 0.0, 0.0),
        eye_up=(0.0, 0.0, 1.0),
    )
    past = rrb.VisibleTimeRanges(
        timeline=SIM_TIME,
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    scene = rrb.Spatial3DView(
        origin=FOLLOW,
        contents=f"{WORLD}/**",
        name="Field",
        eye_controls=eye,
        background=SKY,
        line_grid=False,
        overrides={PATH: past, FURROW: past},
    )
    return _blueprint(scene, _plots(truth, draft="draft_n" in truth))


def _logged(span: Table, geodetic: bool) -> rrb.Blueprint:
    """Map (or plan) left, plots right."""
    place: rrb.View = (
        rrb.MapView(origin="map", name="Map")
        if geodetic
        else rrb.Spatial3DView(origin=WORLD, name="Path", background=SKY)
    )
    return _blueprint(place, _plots(span, draft=False))


def _blueprint(left: rrb.View, right: rrb.Vertical) -> rrb.Blueprint:
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[3, 2]),
        rrb.TimePanel(timeline=SIM_TIME, state="collapsed", play_state="playing"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )


def _plots(span: Table, *, draft: bool) -> rrb.Vertical:
    """Time series over the whole span of a table's epochs."""
    panels = [
        (SLIP, "Slip of the driven axle, with ±2 sd", 3),
        (SPEED, "Speed [m/s]", 2),
        (SIDESLIP, "Sideslip at the centre of gravity [m]", 2),
    ]
    if draft:
        panels += [(DRAFT, "Draft [kN]", 2), (DEPTH, "Depth of ploughing [m]", 2)]
    first_s, last_s = (float(span["epoch_ns"][i]) * 1e-9 for i in (0, -1))
    axis = rrb.TimeAxis(
        view_range=rr.TimeRange(
            start=rr.TimeRangeBoundary.absolute(seconds=first_s),
            end=rr.TimeRangeBoundary.absolute(seconds=last_s),
        )
    )
    background = rrb.archetypes.PlotBackground(color=DARK)
    views = [
        rrb.TimeSeriesView(
            origin=entity,
            name=name,
            axis_x=axis,
            background=background,
            plot_legend=rrb.PlotLegend(visible=entity not in (DRAFT, DEPTH)),
        )
        for entity, name, _ in panels
    ]
    return rrb.Vertical(*views, row_shares=[share for _, _, share in panels])


# --- small things ---------------------------------------------------------------------------


class _Recording:
    """A recording into a file, complete when the block ends."""

    def __init__(self, path: Path, blueprint: rrb.Blueprint) -> None:
        self._stream = rr.RecordingStream(APPLICATION, recording_id=None)
        self._stream.save(path, default_blueprint=blueprint)

    def __enter__(self) -> rr.RecordingStream:
        return self._stream

    def __exit__(self, *_: object) -> None:
        self._stream.flush()
        self._stream.disconnect()


def _times(table: Mapping[str, Array]) -> list[rr.TimeColumn]:
    time_s = np.asarray(table["epoch_ns"], np.float64) * 1e-9
    steps = np.round(time_s / STEP_S).astype(np.int64)
    return [rr.TimeColumn(SIM_TIME, duration=time_s), rr.TimeColumn(STEP, sequence=steps)]


def _every(table: Table, rate_hz: float) -> Table:
    """At most `rate_hz` rows a second, the last one included."""
    epoch_ns = table["epoch_ns"]
    n = len(epoch_ns)
    span_s = float(epoch_ns[-1] - epoch_ns[0]) * 1e-9 if n > 1 else 0.0
    stride = max(1, round((n - 1) / (span_s * rate_hz))) if span_s > 0.0 else 1
    rows = np.arange(0, n, stride)
    rows = rows if n == 0 or rows[-1] == n - 1 else np.append(rows, n - 1)
    return {name: column[rows] for name, column in table.items()}


def _position_w(truth: Table) -> Array:
    return np.stack([truth["east_m"], truth["north_m"], truth["up_m"]], axis=1)  # (n, 3)


def _axes_w(truth: Table) -> tuple[Array, Array, Array]:
    """Body axes forward, left, up in the world. Shape (n, 3) each."""
    w, x, y, z = (truth[c] for c in ("qw", "qx", "qy", "qz"))
    forward = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
    left = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], 1)
    return forward, left, np.cross(forward, left)


def _rgba(colour: str) -> list[int]:
    return list(bytes.fromhex(colour.removeprefix("#")))
