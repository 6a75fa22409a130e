"""Machines for the tests: built once, and driven by hand with MuJoCo's own functions."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np

from twin.machine.start import RAISED_RAD
from twin.physics.block import MACHINE_SLOTS, WheelSlot
from twin.scenario import Course, Field, Plough, Scenario, Soil
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.simulation.simulation import Simulation

PLOUGHING = Scenario(
    name="test-plough",
    plough=Plough(depth_m=0.25),
    course=Course(approach_m=3.0, length_m=20.0),
    seed=4,
)
BARE = Scenario(name="test-bare", course=Course(approach_m=3.0, length_m=12.0))
EVEN_SOIL = Soil(draft_cv=0.0, ripple_cv=0.0, strength_cv=0.0)
EVEN = replace(BARE, soil=EVEN_SOIL)
"""The tractor alone on soil that is the same everywhere."""
EVEN_PLOUGHING = replace(PLOUGHING, soil=EVEN_SOIL, course=Course(approach_m=3.0, length_m=30.0))
"""Even soil, in the furrow."""
LEVEL_PLOUGHING = replace(EVEN_PLOUGHING, plough=Plough(depth_m=0.25, furrow="none"))
"""Even soil, all wheels on the land."""


def field(scenario, **shape):
    return replace(scenario, field=Field(**shape))


@cache
def plough_rig():
    return build(PLOUGHING)


@cache
def bare_rig():
    return build(BARE)


@cache
def driven(scenario):
    """Columns of a whole drive."""
    chunks = list(simulate(build(scenario)))
    return {n: np.concatenate([c[n] for c in chunks]) for n in chunks[0].columns}


def start(machine, *, rolling=True):
    """MjData as a run begins, from where a simulation starts."""
    data = mujoco.MjData(machine.model)
    simulation = Simulation(machine)
    data.qpos[:] = simulation.qpos[0]
    if rolling:
        data.qvel[:] = simulation.qvel[0]
    return data


def set_controls(machine, data, **values):
    """Controls by actuator name; the hitch raised unless told."""
    for name, value in ({"lift": RAISED_RAD} | values).items():
        data.ctrl[machine.model.actuator(name).id] = value


def wheels(data):
    """The slots of the four wheels. Shape (4, slots)."""
    return data.userdata[:MACHINE_SLOTS].reshape(4, int(WheelSlot.SIZE)).copy()


def soiled(scenario, **soil):
    return replace(scenario, soil=replace(scenario.soil, **soil))
