"""A machine driven by hand with MuJoCo's own functions: controls by name, slots by wheel."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.machine.build import Machine
from twin.machine.start import RAISED_RAD
from twin.physics.block import MACHINE_SLOTS, WheelSlot
from twin.rig.tyre import machine_tyre
from twin.scenario import Scenario, Soil
from twin.simulation.simulation import Simulation
from twin.validate.brixius_forms import mobility

Array = NDArray[np.float64]


def rolling(machine: Machine) -> mujoco.MjData:
    """As a run begins: settled on the tyres, at the unloaded speed."""
    simulation, state = Simulation(machine), mujoco.MjData(machine.model)
    state.qpos[:], state.qvel[:] = simulation.qpos[0], simulation.qvel[0]
    state.act[:] = machine.start_act
    return state


def parked(machine: Machine) -> mujoco.MjData:
    """Settled with the brakes on, its forces up to date."""
    state = mujoco.MjData(machine.model)
    state.qpos[:], state.act[:] = machine.start_qpos, machine.start_act
    hold(machine, state, brake=1.0, clutch_pedal=1.0)
    mujoco.mj_forward(machine.model, state)
    return state


def hold(machine: Machine, state: mujoco.MjData, **controls: float) -> None:
    """Set controls by name; the hitch is raised unless it is named."""
    raised = {} if machine.hitch is None else {"lift": RAISED_RAD}
    for name, value in (raised | controls).items():
        state.ctrl[machine.model.actuator(name).id] = value


def wheels(state: mujoco.MjData) -> Array:
    """The slots of the four wheels. Shape (4, WheelSlot.SIZE)."""
    return np.array(state.userdata[:MACHINE_SLOTS]).reshape(4, int(WheelSlot.SIZE))


def mobility_of(axle: str, load_n: float, soil: Soil) -> float:
    """Brixius' mobility number of the tractor's tyre of an axle."""
    sizes = machine_tyre(Scenario.machine, axle)
    return mobility(sizes, load_n, soil.resolved.cone_index_kpa)
