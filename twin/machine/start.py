"""The start of a run: settled on its tyres, then rolling."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.machine.ground_frame import quaternion
from twin.machine.guard import STATE, Tape, all_finite, diverged, warning_text
from twin.machine.guard import Diverged as Diverged
from twin.machine.hitch import Hitch
from twin.machine.quiet import quiet
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.scenario import Scenario
from twin.terrain.grid import GridMap

Array = NDArray[np.float64]

RAISED_RAD = 0.6
"""Lower-link angle without a plough, and with one that is carried unless its limit is another."""
SETTLE_S, SLIDING_SETTLE_S = 8.0, 4.0
"""Time in which the machine settles on its tyres before a run; and where brakes do not hold it on
uneven ground, from where it is not put back to its place."""
SLIDING_MPS = 0.05
"""Speed of a machine that does not come to rest [m/s]."""
LOOK_S = 0.02
"""Time between two looks whether it is still finite."""


def raised_rad(scenario: Scenario) -> float:
    """Lower-link angle at which the machine of a scenario carries its plough."""
    return RAISED_RAD if scenario.plough is None else scenario.plough.upper_limit_rad


def unloaded_speed_mps(scenario: Scenario, numbers: dict[str, float]) -> float:
    """Speed at which the governed engine just carries its own losses."""
    drive = scenario.drive
    droop = (
        numbers["engine.droop_rpm_per_nm"] * numbers["engine.no_load_rpm"] / drive.engine_set_rpm
    )
    rpm = drive.engine_set_rpm - 2.5 * droop * numbers["engine.parasitic_nm"]
    radius_m = numbers["tyre_rear.free_rolling_radius_m"]
    return rpm * math.pi / 30.0 / drive.gear_ratio * radius_m


@dataclass(frozen=True)
class Settled:
    """A machine at rest on its tyres."""

    qpos: Array
    """Shape (nq,)."""
    act: Array
    """Activations with all couplings released. Shape (na,)."""
    load_n: Array
    """Load of each wheel. Shape (4,)."""


def settled(model: Any, qpos: Array, rotation: Array, scenario: Scenario) -> Settled:
    """Where the machine comes to rest with the brakes on and the plough carried.

    Raises:
        Diverged: it does not come to rest as a finite number.
    """
    state = mujoco.MjData(model)
    state.qpos[:] = qpos
    for control, value in (("brake", 1.0), ("clutch_pedal", 1.0), ("lift", raised_rad(scenario))):
        actuator = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, control)
        if actuator >= 0:
            state.ctrl[actuator] = value
    _settle(model, state, scenario)
    act = np.array(state.act)
    act[4 * len(block.WHEELS) :] = 0.0
    slots = state.userdata[: block.MACHINE_SLOTS].reshape(len(block.WHEELS), -1)
    load_n = np.array(slots[:, WheelSlot.LOAD_N])
    rest = np.array(state.qpos)
    if model.nhfield == 0:  # elsewhere on uneven ground it would not be at rest
        rest = back_on_line(rest, qpos, rotation)
    return Settled(rest, act, load_n)


def unsettled(model: Any, qpos: Array) -> Settled:
    """The machine where it was put: no tyre is wound up, and no load is known."""
    return Settled(qpos, np.zeros(model.na), np.full(len(block.WHEELS), np.nan))


def _settle(model: Any, state: Any, scenario: Scenario) -> None:
    """Let it come to rest, and refuse what diverges."""
    row = np.empty(mujoco.mj_stateSize(model, STATE))
    tape, steps = Tape(len(row), LOOK_S), round(LOOK_S / model.opt.timestep)
    for k in range(round(SETTLE_S / LOOK_S)):
        slides = model.nhfield > 0 and np.linalg.norm(state.qvel[:3]) > SLIDING_MPS
        if slides and k >= round(SLIDING_SETTLE_S / LOOK_S):
            return
        mujoco.mj_getState(model, state, row, STATE)
        tape.keep(row)
        with quiet():
            mujoco.mj_step(model, state, steps)
        finite = all(all_finite(a) for a in (state.qpos, state.qvel, state.act, state.userdata))
        if not finite or any(w.number for w in state.warning):
            raise diverged(scenario, model, tape, steps, during="settling")


def back_on_line(settled_qpos: Array, start_qpos: Array, rotation: Array) -> Array:
    """A settled pose put back to its start's place and heading on the ground. Shape (nq,).

    Height, roll and pitch stay as they have settled; what it slid and turned meanwhile is undone.
    """
    place = rotation.T @ settled_qpos[:3]
    place[:2] = (rotation.T @ start_qpos[:3])[:2]
    body = np.zeros(9)
    mujoco.mju_quat2Mat(body, settled_qpos[3:7])
    ahead = rotation.T @ body.reshape(3, 3)[:, 0]
    turn = math.atan2(ahead[1], ahead[0])
    cosine, sine = math.cos(turn), math.sin(turn)
    undo = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    out = settled_qpos.copy()
    out[:3] = rotation @ place
    out[3:7] = quaternion(rotation @ undo @ rotation.T @ body.reshape(3, 3))
    return out


def refuse_warnings(counts: NDArray[Any], name: str, time_s: float) -> None:
    """Raise Diverged if MuJoCo has warned."""
    warned = np.flatnonzero(counts)
    if len(warned):
        raise Diverged(f"{warning_text(int(warned[0]))} after {time_s:.2f} s of '{name}'")


def standing(
    model: Any,
    scenario: Scenario,
    rotation: Array,
    hitch: Hitch | None,
    work_rad: float,
    heights: GridMap | None,
) -> Array:
    """Standing on the ground at the start of the course, the plough carried. Shape (nq,)."""
    qpos = model.qpos0.copy()
    left_m = scenario.course.start_left_m
    upright, raised_m = rotation, 0.0
    if heights is not None:
        lean, raised_m = _lean(model, heights, left_m)
        upright = rotation @ lean
    axle_m = float(model.body("tractor").pos[2])
    qpos[:3] = rotation @ np.array([0.0, left_m, raised_m]) + axle_m * upright[:, 2]
    qpos[3:7] = quaternion(upright)
    if hitch is None:
        return np.asarray(qpos, dtype=np.float64)
    qpos[model.joint("lift").qposadr[0]] = raised_rad(scenario)
    if scenario.plough is not None:
        top_m = hitch.top_length_m(work_rad, -work_rad)
        pitch = hitch.pitch_rad_at(raised_rad(scenario), top_m)
        qpos[model.joint("plough.pitch").qposadr[0]] = pitch
    return np.asarray(qpos, dtype=np.float64)


def _lean(model: Any, heights: GridMap, left_m: float) -> tuple[Array, float]:
    """Rotation that lays the machine on the plane through its wheels' places, and its height.

    Raised until none of them is below the ground.
    """
    front_m, half_m = float(model.body("front_axle").pos[0]), float(model.body("rl_wheel").pos[1])
    s, t = (a.ravel() for a in np.meshgrid([0.0, front_m], [half_m, -half_m]))
    ground_m = heights.at(s, left_m + t)
    plane = np.stack([np.ones(4), s, t], axis=1)
    found, *_ = np.linalg.lstsq(plane, ground_m)
    raised_m = float(found[0] + np.max(ground_m - plane @ found))
    normal = np.array([-found[1], -found[2], 1.0]) / math.sqrt(1.0 + found[1] ** 2 + found[2] ** 2)
    ahead = np.array([1.0, 0.0, found[1]]) / math.sqrt(1.0 + found[1] ** 2)
    return np.stack([ahead, np.cross(normal, ahead), normal], axis=1), raised_m
