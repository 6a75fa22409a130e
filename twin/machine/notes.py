"""What a reader of a run should know about it before its numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twin.machine.build import Machine
from twin.physics import block
from twin.physics.block import Wheel
from twin.physics.validity import outside_validity
from twin.streams import Table

AXLES = {"front": (0, 1), "rear": (2, 3)}
"""Wheels of each axle, in the order of block.WHEELS."""
OVERSPEED = 1.15
"""Engine speed over the no-load speed that is told [-]; governors hold within about a tenth."""
OVERSPEED_S = 1.0
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


def overspeed(numbers: Mapping[str, float], truth: Table) -> tuple[str, ...]:
    """When the wheels drive the engine far above its no-load speed, as on a slope downhill.

    n > 1.15 n_no_load for a second on end; the time of all such stretches is summed.

    Args:
        numbers: the machine's own, of which `engine.no_load_rpm` is looked at.
        truth: with epoch_ns, evenly spaced, and engine_radps.
    """
    epoch_s = 1e-9 * truth["epoch_ns"]
    rpm = np.abs(truth["engine_radps"]) * 30.0 / np.pi
    limit_rpm = OVERSPEED * numbers["engine.no_load_rpm"]
    edges = np.flatnonzero(np.diff(rpm > limit_rpm, prepend=False, append=False))
    starts, stops = epoch_s[edges[::2]], epoch_s[edges[1::2] - 1]
    long = stops - starts >= OVERSPEED_S
    if not np.any(long):
        return ()
    return (
        f"engine above {limit_rpm:.0f} rpm, {OVERSPEED:g} of its no-load speed, for "
        f"{np.sum((stops - starts)[long]):.1f} s from {starts[long][0]:.1f} s on, up to "
        f"{rpm.max():.0f} rpm: the ground drives it",
    )
