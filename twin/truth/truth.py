"""The truth an estimate is scored against, from a noise-free trajectory.

Slip and the axes of the ground plane are those of `twin.truth.motion`. Sideslip is measured in
them:

    beta = atan2(v_y, v_x)        sideslip amount = integral of v_y dt

at the centre of gravity of the tractor without implement, and at the rear-axle centre (`_rear`).
Below 0.05 m/s angles are NaN.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.compute.quaternion import rotated
from twin.physics.tyre import SLOWEST_MPS
from twin.streams import WHEELS, Table
from twin.trajectory.trajectory import Trajectory
from twin.truth.motion import Wheels, driven_axle, ground_velocity, slip_ratio

Array = NDArray[np.float64]

PERIOD_NS = 20_000_000
JOINTS = (
    "fl_spin", "fr_spin", "rl_spin", "rr_spin",
    "fl_steer", "fr_steer", "front_swing", "lift", "plough_pitch",
)  # fmt: skip


def sample(trajectory: Trajectory, driven: Sequence[str]) -> Table:
    """Truth at 50 Hz from a chunk of trajectory; integrals are left to `integrate`."""
    kept = trajectory.epoch_ns % PERIOD_NS == 0
    column = {name: values[kept] for name, values in trajectory.columns.items()}
    normal, attitude = column["ground_normal_w"], column["world_from_body"]
    table: Table = {"epoch_ns": trajectory.epoch_ns[kept]}
    table |= dict(zip(("east_m", "north_m", "up_m"), column["position_w"].T, strict=True))
    table |= dict(zip(("qw", "qx", "qy", "qz"), attitude.T, strict=True))
    for suffix, velocity in (("", column["cg_velocity_w"]), ("_rear", column["velocity_w"])):
        v_x, v_y = ground_velocity(attitude, normal, velocity)
        moving = np.hypot(v_x, v_y) >= SLOWEST_MPS
        table[f"v_x{suffix}_mps"], table[f"v_y{suffix}_mps"] = v_x, v_y
        table[f"sideslip{suffix}_rad"] = np.where(moving, np.arctan2(v_y, v_x), np.nan)
    table["yaw_rate_radps"] = np.sum(normal * rotated(attitude, column["gyro_b"]), axis=1)
    table["speed_mps"] = table["v_x_rear_mps"]
    table |= _decided(column)
    return table | _wheels(column, driven) | _joints(column) | _powers(trajectory, kept)


def _decided(column: dict[str, Array]) -> Table:
    """What the driver of a course does; nothing of an environment, whose actions say it."""
    if "phase" not in column:
        return {}
    return {"phase": column["phase"].astype(np.int64), "gear_ratio": column["gear_ratio"]}


def _wheels(column: dict[str, Array], driven: Sequence[str]) -> Table:
    """Slip of each wheel and of the driven axle, loads, and the machine's forces."""
    places = np.array([WHEELS.index(w) for w in driven])
    wheels = Wheels(column["spin_radps"], column["rolling_radius_m"], column["wheel_speed_x_mps"])
    axle = driven_axle(wheels, places)
    slip = slip_ratio(axle.wheel_speed_mps, axle.hub_mps)
    table: Table = {"wheel_speed_mps": axle.wheel_speed_mps, "slip": slip}
    for i, wheel in enumerate(WHEELS):
        table[f"slip_{wheel}"] = column["slip"][:, i]
        table[f"load_{wheel}_n"] = column["load_n"][:, i]
        table[f"shear_{wheel}_n"] = column["shear_x_n"][:, i]
    names = (
        "draft_n",
        "depth_m",
        "depth_wheel_n",
        "plough_side_n",
        "engine_radps",
        "engine_torque_nm",
        "fuel_lph",
        "axle_torque_nm",
    )
    return table | {name: column[name] for name in names}


def _powers(trajectory: Trajectory, kept: NDArray[np.bool_]) -> Table:
    """Powers as means from each sample to the next, so that their sums are energies."""
    count = np.diff(np.append(np.flatnonzero(kept), len(trajectory)))
    names = [n for n in trajectory.columns if n.startswith("power_")]
    start = np.flatnonzero(kept)
    table: Table = {n: np.add.reduceat(trajectory[n], start) / count for n in names}
    return table | {n: trajectory[n][kept] for n in ("kinetic_j", "potential_j")}


def _joints(column: dict[str, Array]) -> Table:
    """Angles of all hinges, to show the machine as it stood."""
    angles = [*column["wheel_angle_rad"].T]
    names = ("fl_steer_rad", "fr_steer_rad", "front_swing_rad", "hitch_rad", "plough_pitch_rad")
    angles += [column[name] for name in names]
    return {f"joint_{j}_rad": a for j, a in zip(JOINTS, angles, strict=True)}


def integrate(table: Table, full_depth_m: float | None) -> Table:
    """A whole run's truth with its integrals: sideslip amounts, and whether it ploughs.

    Args:
        table: consecutive samples of a whole run.
        full_depth_m: depth from which the plough counts as at full depth, None without a plough.
    """
    dt_s = np.diff(table["epoch_ns"]) * 1e-9
    for suffix in ("", "_rear"):
        v_y = table[f"v_y{suffix}_mps"]
        path = np.cumsum(0.5 * (v_y[1:] + v_y[:-1]) * dt_s)
        table[f"sideslip{suffix}_m"] = np.concatenate([[0.0], path])
    table["ploughing"] = _ploughing(table["depth_m"], full_depth_m)
    return table


def _ploughing(depth_m: Array, full_depth_m: float | None) -> NDArray[np.bool_]:
    """From full depth on, until the plough is out of the ground."""
    if full_depth_m is None:
        return np.zeros(len(depth_m), dtype=bool)
    now = np.arange(len(depth_m))
    last_full = np.maximum.accumulate(np.where(depth_m >= full_depth_m, now, -1))
    last_out = np.maximum.accumulate(np.where(depth_m <= 0.0, now, -1))
    return np.asarray(last_full > last_out)


def concatenate(parts: Sequence[Table]) -> Table:
    """One table from consecutive ones."""
    return {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}
