"""The machine: its bodies where truth says they were, its sensors, and what the eye rides on."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.report.palette import SEA
from twin.streams import Setup, Table
from twin.viz.paths import FOLLOW, TRACTOR
from twin.viz.shapes import Shapes, body_poses, log_shapes
from twin.viz.tools import axes_w, position_w, rgba, times

Array = NDArray[Any]


def log_machine(recording: rr.RecordingStream, truth: Table, model: Any) -> None:
    """Every body of the model that can be seen, where truth says it was."""
    shapes = Shapes.of(model)
    positions_w, world_from_body = body_poses(model, truth)  # (n, nbody, 3), (n, nbody, 4)
    for body, name in shapes.bodies.items():
        log_shapes(recording, f"{TRACTOR}/{name}", shapes, body)
        _send_poses(
            recording, f"{TRACTOR}/{name}", truth, positions_w[:, body], world_from_body[:, body]
        )


def log_frame(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """The body frame with its sensors, and a level frame that turns with it for the eye."""
    forward, _, _ = axes_w(truth)
    half_heading_rad = 0.5 * np.arctan2(forward[:, 1], forward[:, 0])
    zero = np.zeros_like(half_heading_rad)
    level = np.stack([np.cos(half_heading_rad), zero, zero, np.sin(half_heading_rad)], axis=1)
    _send_poses(recording, FOLLOW, truth, position_w(truth), level)
    pose = np.stack([truth[c] for c in ("qw", "qx", "qy", "qz")], axis=1)  # (n, 4)
    _send_poses(recording, f"{TRACTOR}/frame", truth, position_w(truth), pose)
    size_m = 0.25 * setup.wheelbase_m
    recording.log(f"{TRACTOR}/frame", rr.TransformAxes3D(size_m), static=True)
    for name in ("gnss", "imu", "camera"):
        fitted = getattr(setup, name)
        if fitted is not None:
            point = rr.Points3D(
                [fitted.lever_arm_m], colors=[rgba(SEA)], radii=[0.12 * size_m], labels=[name],
                show_labels=False,
            )  # fmt: skip
            recording.log(f"{TRACTOR}/frame/{name}", point, static=True)


def _send_poses(
    recording: rr.RecordingStream, entity: str, truth: Table, position_w: Array, wxyz: Array
) -> None:
    xyzw = wxyz[:, [1, 2, 3, 0]].astype(np.float32)  # rerun keeps the scalar last
    recording.send_columns(
        entity,
        times(truth),
        rr.Transform3D.columns(translation=position_w.astype(np.float32), quaternion=xyzw),
    )
