"""What a reader of a run should know about it before its numbers."""

from __future__ import annotations

import numpy as np

from twin.machine.build import Machine
from twin.physics import block
from twin.physics.block import Wheel
from twin.physics.validity import outside_validity
from twin.streams import Table

AXLES = {"front": (0, 1), "rear": (2, 3)}
"""Wheels of each axle, in the order of block.WHEELS."""
TOO_FAST = 1.5
"""Engine speed over the governor's set speed from which a note is given [-]: braked wheels skid at
30 % by then, and hold nine tenths of all they can."""
TOO_FAST_S = 1.0
"""How long it must last [s]."""


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


def unheld(asked_mps: float, truth: Table) -> tuple[str, ...]:
    """When the machine runs far faster than the governor asks, as where braked wheels skid.

    v > 1.5 w_0 r / i for a second on end; the time of all such stretches is summed.

    Args:
        asked_mps: w_0 r / i, the speed of the driven rims at the governor's no-load speed.
        truth: with epoch_ns, evenly spaced, and speed_mps.
    """
    epoch_s, speed_mps = 1e-9 * truth["epoch_ns"], np.abs(truth["speed_mps"])
    edges = np.flatnonzero(np.diff(speed_mps > TOO_FAST * asked_mps, prepend=False, append=False))
    starts, stops = epoch_s[edges[::2]], epoch_s[edges[1::2] - 1]
    long = stops - starts >= TOO_FAST_S
    if not np.any(long):
        return ()
    return (
        f"above {TOO_FAST * asked_mps:.1f} m/s, {TOO_FAST:g} of what the governor asks, for "
        f"{np.sum((stops - starts)[long]):.1f} s from {starts[long][0]:.1f} s on, up to "
        f"{speed_mps.max():.1f} m/s: engine and brakes do not hold it",
    )
