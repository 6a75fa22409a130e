"""Forces of the ground as arrows: what carries, what drives, what the plough pulls."""

from __future__ import annotations

import numpy as np
import rerun as rr

from twin.streams import WHEELS, Setup, Table
from twin.viz.paths import FORCES
from twin.viz.tools import Array, axes_w, position_w, times

LONGEST_M = 1.5
"""Length of the largest wheel load, as a share of the tractor's wheelbase over 2.5 m."""
RADIUS_M = 0.045
SHARE_AT_M = (-2.6, 1.0)
"""Where the plough's draft is drawn: over the middle of its frame, clear of it."""
COLOURS = {"load": [86, 180, 233], "thrust": [0, 158, 115], "draft": [213, 94, 0]}


def log_forces(recording: rr.RecordingStream, truth: Table, setup: Setup) -> None:
    """Arrows at each moment of truth, all to one scale; nothing where truth has no forces."""
    if not {f"load_{w}_n" for w in WHEELS} <= truth.keys():
        return
    ahead, left, up = axes_w(truth)
    contact = np.stack([_contact_w(truth, setup, w) for w in WHEELS], axis=1)  # (n, 4, 3)
    load = np.stack([truth[f"load_{w}_n"] for w in WHEELS], axis=1)  # (n, 4)
    thrust = np.stack([truth[f"shear_{w}_n"] for w in WHEELS], axis=1)
    scale = setup.wheelbase_m / 2.55
    metres_per_n = LONGEST_M * scale / max(1.0, float(np.quantile(load, 0.99)))
    _send(recording, truth, "load", contact, metres_per_n * load[..., None] * up[:, None], scale)
    _send(
        recording,
        truth,
        "thrust",
        contact,
        metres_per_n * thrust[..., None] * ahead[:, None],
        scale,
    )
    if np.any(np.abs(truth["draft_n"]) > 1.0):
        behind_m, above_m = SHARE_AT_M
        share = position_w(truth) + behind_m * ahead + above_m * up
        side_n = truth.get("plough_side_n", np.zeros(len(share)))
        pull = -truth["draft_n"][:, None] * ahead + side_n[:, None] * left
        _send(recording, truth, "draft", share[:, None], metres_per_n * pull[:, None], scale)
        said = [f"draft {1e-3 * draft:.0f} kN" if draft > 1.0 else "" for draft in truth["draft_n"]]
        recording.send_columns(f"{FORCES}/draft", times(truth), rr.Arrows3D.columns(labels=said))


def _contact_w(truth: Table, setup: Setup, wheel: str) -> Array:
    """Where a wheel stands, its outer side, so that the arrows are not inside it. Shape (n, 3)."""
    ahead, left, up = axes_w(truth)
    front = wheel[0] == "f"
    track_m = setup.track_front_m if front else setup.track_rear_m
    side = 0.5 * track_m * (1.0 if wheel[1] == "l" else -1.0) * 1.45
    radius = setup.wheels.radius_m if setup.wheels else {}
    down_m = radius.get("rl", 0.8) - 0.05 * setup.wheelbase_m
    return (
        position_w(truth)
        + (setup.wheelbase_m if front else 0.0) * ahead
        + side * left
        - (down_m * up)
    )


def _send(
    recording: rr.RecordingStream,
    truth: Table,
    name: str,
    origin: Array,
    vector: Array,
    scale: float,
) -> None:
    n, count = vector.shape[:2]
    columns = rr.Arrows3D.columns(
        origins=origin.reshape(-1, 3).astype(np.float32),
        vectors=vector.reshape(-1, 3).astype(np.float32),
    ).partition([count] * n)
    recording.send_columns(f"{FORCES}/{name}", times(truth), columns)
    style = rr.Arrows3D.from_fields(colors=[COLOURS[name]], radii=[RADIUS_M * scale])
    recording.log(f"{FORCES}/{name}", style, static=True)
