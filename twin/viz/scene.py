"""The machine: its bodies at their true poses, its sensors, and the frame that the view follows."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
import rerun as rr

from twin.report.palette import SEA
from twin.streams import Setup, Table
from twin.viz.paths import FOLLOW, TRACTOR
from twin.viz.shapes import Shapes, body_poses, log_shapes, looks_alike
from twin.viz.tools import Array, axes_w, position_w, rgba, times


def log_machine(
    recording: rr.RecordingStream,
    truth: Table,
    model: mujoco.MjModel,
    turned: mujoco.MjModel | None = None,
    from_ns: Sequence[int] = (),
) -> None:
    """Every body of the model that can be seen, where truth says it was.

    Args:
        recording: what is written.
        truth: with pose and joint columns.
        model: of the machine.
        turned: the same machine with its plough turned over, for every other pass.
        from_ns: when each pass begins.
    """
    shapes, epoch_ns = Shapes.of(model), truth["epoch_ns"]
    positions_w, world_from_body = body_poses(model, truth)  # (n, nbody, 3), (n, nbody, 4)
    if turned is not None:
        back = np.searchsorted(np.array(from_ns), epoch_ns, side="right") % 2 == 0
        back &= epoch_ns >= from_ns[0]
        rows = {name: column[back] for name, column in truth.items()}
        positions_w[back], world_from_body[back] = body_poses(turned, rows)
    for body, name in shapes.bodies.items():
        entity = f"{TRACTOR}/{name}"
        if turned is None or looks_alike(model, turned, body):
            log_shapes(recording, entity, shapes, body)
        else:
            both = (shapes, Shapes.of(turned))
            for k, begin_ns in enumerate(from_ns):
                log_shapes(recording, entity, both[k % 2], body, begin_ns)
        _send_poses(recording, entity, truth, positions_w[:, body], world_from_body[:, body])


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
