"""Recordings of a simulated run and of a log, each with its blueprint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from twin.io.atomic import write_bytes
from twin.io.run_folder import RunLike
from twin.streams import Setup, Streams, Table
from twin.viz import forces, plots, scene, tracks
from twin.viz.blueprint import logged, simulated
from twin.viz.bodies import bodies
from twin.viz.events import drive_events, events, log_events
from twin.viz.ground import Ground, log_ploughing, worked
from twin.viz.ground_mesh import log_ground
from twin.viz.paths import APPLICATION, WORLD
from twin.viz.pictures import log_frames
from twin.viz.tools import LARGE_M, every

POSE_RATE_HZ = 15.0
NOTHING: Table = {"epoch_ns": np.zeros(1, np.int64)}


def record(
    run: RunLike,
    path: Path,
    *,
    model: mujoco.MjModel | None = None,
    turned: mujoco.MjModel | None = None,
    ground: Ground | None = None,
    control: Table | None = None,
) -> None:
    """Write a simulated run as a recording.

    Args:
        run: with truth (pose and joint columns).
        path: the .rrd file.
        model: compiled mujoco.MjModel whose visual geoms are drawn; None draws the path alone.
        turned: the same with its plough turned over, as it works on every other pass.
        ground: what it drives on; None is a level plane. Its plough's bodies are the model's.
        control: a controller's actions, and the terms `reward_<term>` of what they earned.
    """
    truth, streams, scenario = run.truth, run.streams, run.scenario
    assert truth is not None, "a simulated run has its truth"
    ground = ground or Ground()
    if model is not None and ground.bodies is None:
        ground = replace(ground, bodies=bodies(model))
    frames = getattr(run, "frames", None)
    screen = simulated(
        truth, streams, run.setup, scenario, frames=bool(frames), control=bool(control)
    )
    lower_m = (run.setup.wheels.radius_m.get("rl", 0.8) if run.setup.wheels else 0.8) - 0.05
    scale = run.setup.wheelbase_m / LARGE_M
    with _Recording(path, screen) as recording:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        moments = every(truth, POSE_RATE_HZ)
        log_ground(recording, truth, scenario, ground)
        log_ploughing(recording, truth, scenario, ground)
        tracks.log_path(recording, truth, lower_m, scale)
        tracks.log_no_sideslip(recording, truth, lower_m, scale)
        tracks.log_estimated(recording, run.estimates, streams, truth, lower_m, scale)
        tracks.log_gnss(recording, streams, truth, scale)
        scene.log_frame(recording, moments, run.setup)
        forces.log_forces(recording, moments, run.setup)
        if model is not None:
            begins = [cut.from_ns for cut, _ in worked(every(truth, 1.0), scenario, ground)]
            scene.log_machine(recording, moments, model, turned if begins else None, begins)
        if frames:
            log_frames(recording, streams, frames)
        log_events(recording, events(truth, streams, scenario, getattr(run, "end", None)))
        _plot(recording, streams, run.setup, run.estimates, truth)
        plots.plot_control(recording, control or {})


def log(
    path: Path,
    *,
    streams: Streams,
    setup: Setup,
    estimates: Mapping[str, Table],
    reference: Table | None = None,
    notes: Sequence[str] = (),
) -> None:
    """Write the estimates of a recorded drive, on a map where its set-up has an origin.

    Args:
        path: the .rrd file.
        streams, setup, estimates: of the drive.
        reference: what is known of the truth.
        notes: found in reading it; shown among the events.
    """
    placed = "gnss" in streams and "east_m" in streams["gnss"]
    geodetic = setup.origin is not None and placed
    spans = [t for t in (*estimates.values(), *streams.tables.values()) if len(t["epoch_ns"])]
    screen = logged(spans[0] if spans else NOTHING, setup, geodetic)
    with _Recording(path, screen) as recording:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        tracks.log_gnss(recording, streams)
        if geodetic:
            tracks.log_map(recording, streams, setup)
        log_events(recording, drive_events(streams, notes))
        _plot(recording, streams, setup, estimates, reference or {})


def _plot(
    recording: rr.RecordingStream,
    streams: Streams,
    setup: Setup,
    estimates: Mapping[str, Table],
    truth: Table,
) -> None:
    plots.plot_estimates(recording, estimates)
    plots.plot_truth(recording, truth)
    start_ns = truth["epoch_ns"][0] if len(truth.get("epoch_ns", ())) else np.iinfo(np.int64).min
    shown = {
        name: {c: v[table["epoch_ns"] >= start_ns] for c, v in table.items()}
        for name, table in streams.tables.items()
    }
    plots.plot_sensors(recording, Streams(shown), setup)


def view(path: Path) -> None:
    """Open a recording in the viewer and return."""
    import subprocess
    import sys

    command = [sys.executable, "-m", "rerun", str(path)]
    quiet = subprocess.DEVNULL
    subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True)


class _Recording:
    """A recording into a file, complete when the block ends.

    It is held in memory until then: on a full disk rerun's own file writer may wait for ever.
    """

    def __init__(self, path: Path, blueprint: rrb.Blueprint) -> None:
        self._path = path
        self._stream = rr.RecordingStream(APPLICATION, recording_id=None)
        self._memory = self._stream.memory_recording()
        self._stream.send_blueprint(blueprint, make_active=False, make_default=True)

    def __enter__(self) -> rr.RecordingStream:
        return self._stream

    def __exit__(self, kind: object, *_: object) -> None:
        self._stream.flush()
        recorded = self._memory.drain_as_bytes()
        self._stream.disconnect()
        if kind is None:
            write_bytes(self._path, recorded)
