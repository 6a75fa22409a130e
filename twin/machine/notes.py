"""What a reader of a run should know about it before its numbers."""

from __future__ import annotations

import numpy as np

from twin.machine.build import Machine
from twin.physics import block
from twin.physics.block import Wheel
from twin.physics.validity import outside_validity

AXLES = {"front": (0, 1), "rear": (2, 3)}
"""Wheels of each axle, in the order of block.WHEELS."""


def notes(machine: Machine) -> tuple[str, ...]:
    """Where the wheels, under the loads they have at rest, leave the range of the soil's law.

    One sentence for each axle and limit, at the mean load of its two wheels; empty within it.
    """
    parameters = machine.model.numeric_data[-block.SIZE :]
    soil = parameters[block.SOIL : block.WHEEL]
    how = "at rest" if machine.scenario.plough is None else "with the plough carried"
    found: list[str] = []
    for axle, wheels in AXLES.items():
        at = block.WHEEL + wheels[0] * int(Wheel.SIZE)
        tyre = parameters[at : at + int(Wheel.SIZE)]
        load_n = float(np.mean(machine.start_load_n[list(wheels)]))
        found += (f"{axle} wheels {how}: {text}" for text in outside_validity(soil, tyre, load_n))
    return tuple(found)
