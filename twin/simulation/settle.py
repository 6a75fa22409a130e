"""A machine comes to rest on its tyres before a run."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine.start import Settled, raised_rad
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.scenario import Scenario
from twin.simulation.finite import all_finite
from twin.simulation.guard import KEPT_S, STATE, StateRing, diverged
from twin.simulation.quiet import quiet

Array = NDArray[np.float64]

SETTLE_S, SLIDING_SETTLE_S = 8.0, 4.0
"""Time in which the machine settles on its tyres before a run; and where brakes do not hold it on
uneven ground, from where it is not put back to its place."""
SLIDING_MPS = 0.05
"""Speed of a machine that does not come to rest [m/s]."""
LOOK_S = 0.02
"""Time between two looks whether it is still finite."""


def settled(model: mujoco.MjModel, qpos: Array, rotation: Array, scenario: Scenario) -> Settled:
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


def _settle(model: mujoco.MjModel, state: mujoco.MjData, scenario: Scenario) -> None:
    """Let it come to rest, and refuse what diverges."""
    row = np.empty(mujoco.mj_stateSize(model, STATE))
    ring, steps = (
        StateRing((1, len(row)), round(KEPT_S / LOOK_S)),
        round(LOOK_S / model.opt.timestep),
    )
    for k in range(round(SETTLE_S / LOOK_S)):
        slides = model.nhfield > 0 and np.linalg.norm(state.qvel[:3]) > SLIDING_MPS
        if slides and k >= round(SLIDING_SETTLE_S / LOOK_S):
            return
        mujoco.mj_getState(model, state, row, STATE)
        ring.keep(row)
        with quiet():
            mujoco.mj_step(model, state, steps)
        finite = all(all_finite(a) for a in (state.qpos, state.qvel, state.act, state.userdata))
        if not finite or state.warning.number.any():
            raise diverged(scenario, model, ring.states(), steps, during="settling")


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
    out[3:7] = quaternion.from_matrix(rotation @ undo @ rotation.T @ body.reshape(3, 3))
    return out
