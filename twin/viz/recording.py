"""Recordings of a simulated run and of a log, each with its blueprint."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from twin.runfolder import RunLike
from twin.streams import Setup, Streams, Table
from twin.viz import scene
from twin.viz.blueprint import logged, simulated
from twin.viz.paths import APPLICATION, WORLD
from twin.viz.plots import plot_all
from twin.viz.tools import every

POSE_RATE_HZ = 15.0
NOTHING: Table = {"epoch_ns": np.zeros(1, np.int64)}


def record(run: RunLike, path: Path, *, model: Any | None = None) -> None:
    """Write a simulated run as a recording.

    Args:
        run: with truth (pose and joint columns).
        path: the .rrd file.
        model: compiled mujoco.MjModel whose visual geoms are drawn; None draws the path alone.
    """
    truth = run.truth
    assert truth is not None, "a simulated run has its truth"
    with _Recording(path, simulated(truth)) as recording:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        moments = every(truth, POSE_RATE_HZ)
        scene.log_ground(recording, truth, run.setup)
        scene.log_furrow(recording, truth, run.setup)
        scene.log_path(recording, truth, run.setup)
        scene.log_gnss(recording, run.streams)
        if model is not None:
            scene.log_machine(recording, moments, model)
        else:
            scene.log_frame(recording, moments)
        plot_all(recording, run.estimates, truth)


def log(
    path: Path,
    *,
    streams: Streams,
    setup: Setup,
    estimates: Mapping[str, Table],
    reference: Table | None = None,
) -> None:
    """Write the estimates of a recorded drive, on a map where its set-up has an origin."""
    placed = "gnss" in streams and "east_m" in streams["gnss"]
    geodetic = setup.origin is not None and placed
    spans = [t for t in (*estimates.values(), *streams.tables.values()) if len(t["epoch_ns"])]
    with _Recording(path, logged(spans[0] if spans else NOTHING, geodetic)) as recording:
        recording.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        scene.log_gnss(recording, streams)
        if geodetic:
            scene.log_map(recording, streams, setup)
        plot_all(recording, estimates, reference or {})


def view(path: Path) -> None:
    """Open a recording in the viewer and return."""
    import subprocess
    import sys

    command = [sys.executable, "-m", "rerun", str(path)]
    quiet = subprocess.DEVNULL
    subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True)


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
