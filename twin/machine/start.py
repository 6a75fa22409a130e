"""The start of a run: at rest at the start of the course, the plough lifted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine.hitch import Hitch
from twin.physics import block
from twin.scenario import Scenario
from twin.terrain.grid import GridMap

Array = NDArray[np.float64]

RAISED_RAD = 0.6
"""Angle of the lower links without a plough [rad]."""


def raised_rad(scenario: Scenario) -> float:
    """Lower-link angle at which the plough of a scenario is lifted [rad]."""
    return RAISED_RAD if scenario.plough is None else scenario.plough.upper_limit_rad


def unloaded_speed_mps(scenario: Scenario, numbers: dict[str, float]) -> float:
    """Speed without slip at which the engine's governor only balances its parasitic torque."""
    gear = scenario.gear
    droop = numbers["engine.droop_rpm_per_nm"] * numbers["engine.no_load_rpm"] / gear.set_rpm
    rpm = gear.set_rpm - 2.5 * droop * numbers["engine.parasitic_nm"]
    radius_m = numbers["tyre_rear.free_rolling_radius_m"]
    return rpm * math.pi / 30.0 / gear.ratio * radius_m


@dataclass(frozen=True)
class Settled:
    """State of a machine at rest on its tyres."""

    qpos: Array
    """Shape (nq,)."""
    act: Array
    """Activations with all couplings released. Shape (na,)."""
    load_n: Array
    """Load of each wheel. Shape (4,)."""


def unsettled(model: mujoco.MjModel, qpos: Array) -> Settled:
    """The state `qpos` with all activations 0 and unknown wheel loads (NaN)."""
    return Settled(qpos, np.zeros(model.na), np.full(len(block.WHEELS), np.nan))


def standing(
    model: mujoco.MjModel,
    scenario: Scenario,
    rotation: Array,
    hitch: Hitch | None,
    work_rad: float,
    heights: GridMap | None,
) -> Array:
    """qpos of a machine at the start of the course, with the plough lifted. Shape (nq,).

    Args:
        model: the compiled model.
        scenario: its course and plough.
        rotation: ground axes to world axes, (3, 3).
        hitch: the linkage; None without one.
        work_rad: lower-link angle in work.
        heights: heights of the ground; None on a plane.
    """
    qpos = model.qpos0.copy()
    start_m, left_m = 0.0 - scenario.course.road_m, scenario.course.start_left_m
    upright, raised_m = rotation, 0.0
    if heights is not None:
        lean, raised_m = _lean(model, heights, start_m, left_m)
        upright = rotation @ lean
    axle_m = float(model.body("tractor").pos[2])
    qpos[:3] = rotation @ np.array([start_m, left_m, raised_m]) + axle_m * upright[:, 2]
    qpos[3:7] = quaternion.from_matrix(upright)
    if hitch is None:
        return np.asarray(qpos, dtype=np.float64)
    qpos[model.joint("lift").qposadr[0]] = raised_rad(scenario)
    if scenario.plough is not None:
        top_m = hitch.top_length_m(work_rad, -work_rad)
        pitch = hitch.pitch_rad_at(raised_rad(scenario), top_m)
        qpos[model.joint("plough.pitch").qposadr[0]] = pitch
    return np.asarray(qpos, dtype=np.float64)


def _lean(
    model: mujoco.MjModel, heights: GridMap, start_m: float, left_m: float
) -> tuple[Array, float]:
    """Rotation that lays the machine on the plane through its wheels' places, and its height.

    Raised until none of them is below the ground.
    """
    front_m, half_m = float(model.body("front_axle").pos[0]), float(model.body("rl_wheel").pos[1])
    s, t = (a.ravel() for a in np.meshgrid([0.0, front_m], [half_m, -half_m]))
    ground_m = heights.at(start_m + s, left_m + t)
    plane = np.stack([np.ones(4), s, t], axis=1)
    found, *_ = np.linalg.lstsq(plane, ground_m)
    raised_m = float(found[0] + np.max(ground_m - plane @ found))
    normal = np.array([-found[1], -found[2], 1.0]) / math.sqrt(1.0 + found[1] ** 2 + found[2] ** 2)
    ahead = np.array([1.0, 0.0, found[1]]) / math.sqrt(1.0 + found[1] ** 2)
    return np.stack([ahead, np.cross(normal, ahead), normal], axis=1), raised_m
