"""The whole tractor on a rig: its weight and lengths, and runs of it with its driver."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.machine.build import Machine
from twin.machine.plough_setting import GRAVITY_MPS2
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.scenario import Course, Drive, Field, Scenario, Soil
from twin.simulation.build import build
from twin.simulation.simulation import DECISION_S, Simulation
from twin.vehicle import Machine as Vehicle
from twin.vehicle import files

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Statics:
    """What the closed forms need of a tractor, standing level."""

    weight_n: float
    cg_ahead_m: float
    """Centre of gravity of the whole, ahead of the rear axle."""
    cg_height_m: float
    wheelbase_m: float
    front_track_m: float
    rear_track_m: float
    front_hub_m: float
    """Height of the front hubs, which is that of the axle's pivot."""
    rear_hub_m: float


def tractor(
    name: str,
    soil: Soil,
    shape: Field | None = None,
    gear: Drive | None = None,
    machine: str | Vehicle = files.USUAL,
) -> Machine:
    """A machine without an implement, on soil that is the same everywhere.

    Args:
        name: of the scenario.
        soil, shape: the ground.
        gear: how it is driven; None for its usual gear, two driven wheels.
        machine: a name, a file, or what a file holds.

    Raises:
        UnknownName: there is no such machine.
        OutOfRange, BadInput: the machine cannot drive so.
    """
    homogeneous = dataclasses.replace(soil, strength_cv=0.0)
    course = Course(approach_m=1.0, length_m=5000.0)
    return build(
        Scenario(
            name=name, soil=homogeneous, field=shape or Field(), course=course,
            drive=gear or Drive(), machine=machine if isinstance(machine, str) else machine.name,
            machine_numbers=None if isinstance(machine, str) else machine,
        )
    )  # fmt: skip


def statics(soil: Soil, machine: str = files.USUAL) -> Statics:
    """Weight and lengths of a tractor settled on level ground."""
    return statics_of(tractor("rig-level", soil, machine=machine))


def statics_of(machine: Machine) -> Statics:
    """Weight and lengths of a machine settled on level ground."""
    model, state = machine.model, mujoco.MjData(machine.model)
    state.qpos[:] = machine.start_qpos
    mujoco.mj_forward(model, state)
    fl, fr, rl, rr = (state.body(f"{w}_wheel").xpos for w in block.WHEELS)
    root = model.body("tractor").id
    cg = state.subtree_com[root]
    return Statics(
        weight_n=GRAVITY_MPS2 * float(model.body_subtreemass[root]),
        cg_ahead_m=float(cg[0] - 0.5 * (rl[0] + rr[0])),
        cg_height_m=float(cg[2]),
        wheelbase_m=float(0.5 * (fl[0] + fr[0] - rl[0] - rr[0])),
        front_track_m=float(fl[1] - fr[1]),
        rear_track_m=float(rl[1] - rr[1]),
        front_hub_m=float(0.5 * (fl[2] + fr[2])),
        rear_hub_m=float(0.5 * (rl[2] + rr[2])),
    )


@dataclass(frozen=True)
class Slots:
    """What the callback reported, averaged over one decision of the driver."""

    wheels: Array
    """Shape (4, WheelSlot.SIZE)."""
    machine: Array
    """Shape (MachineSlot.SIZE,)."""
    steer_rad: float


def drive(simulation: Simulation, seconds: float) -> list[Slots]:
    """Drive on for a time; one entry per decision of the driver.

    Raises:
        Diverged: a state is not finite, or MuJoCo warned.
    """
    reported = []
    for _ in range(round(seconds / DECISION_S)):
        slots = simulation.advance()["userdata"][0].mean(axis=0)
        wheels = slots[: block.MACHINE_SLOTS].reshape(4, int(WheelSlot.SIZE))
        machine = slots[block.MACHINE_SLOTS : block.POWER_SLOTS]
        reported.append(Slots(wheels, machine, float(simulation.drivers["steer_rad"][0])))
    return reported


def mean(reported: list[Slots]) -> Slots:
    """The average of entries."""
    return Slots(
        np.mean([s.wheels for s in reported], axis=0),
        np.mean([s.machine for s in reported], axis=0),
        float(np.mean([s.steer_rad for s in reported])),
    )
