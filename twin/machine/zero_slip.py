"""Rolling radii by the four zero-slip conditions of ASABE S296, relative to that of the soil law.

In the soil law slip is zero where v = w R, with the rolling radius R. A calibration in the field
finds another radius R': that of a wheel without torque, or of a tractor without pull, on a hard
surface or on the field. Slip by the radius R' is

    s' = (w R' - v) / max(|w R'|, |v|, 0.05 m/s)

and R' / R follows from the slip s_0 by the soil law in that state, under the nominal wheel loads:
v = w R', so R' / R = 1 - s_0 for s_0 >= 0 and 1 / (1 + s_0) for s_0 < 0.
Source: ASABE S296, zero conditions, from memory.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from twin.machine.parameters import soil_part
from twin.physics import block
from twin.physics.block import Wheel
from twin.physics.laws import soil_forces
from twin.scenario import Scenario
from twin.scenario import Soil as Ground

Array = NDArray[np.float64]
HARD = "asphalt"
"""Soil preset of the hard surface."""
REACH = 0.2
"""The slip s_0 is searched between -REACH and REACH [-]."""


def radius_factors(scenario: Scenario, parameters: Array) -> Array:
    """R' / R of each wheel, in the order of block.WHEELS; 1 where R is kept. Shape (4,).

    Args:
        scenario: gives `zero_slip` (the condition) and the driven axles.
        parameters: the parameter block of its machine.
    """
    where, _, state = scenario.zero_slip.partition("-")
    if not state:
        return np.ones(len(block.WHEELS))
    soil = parameters[block.SOIL : block.WHEEL].copy()
    if where == "hard":
        for slot, value in soil_part(Ground(preset=HARD)).items():
            soil[slot] = value
    wheels = parameters[block.WHEEL : block.ENGINE].reshape(len(block.WHEELS), int(Wheel.SIZE))
    towed = [_root(soil, wheel, _torque_n) for wheel in wheels]
    slips = np.array(towed)
    if state == "pull":
        driven = range(4) if scenario.drive.all_wheel_drive else (2, 3)
        resisted = sum(_pull_n(soil, wheels[i], towed[i]) for i in range(4) if i not in driven)
        each_n = -resisted / len(driven)
        for i in driven:
            slips[i] = _root(soil, wheels[i], lambda *state: _pull_n(*state) - each_n)
    return np.where(slips >= 0.0, 1.0 - slips, 1.0 / (1.0 + slips))


def _forces(soil: Array, wheel: Array, slip: float) -> tuple[float, float, float, float, float]:
    load_n = float(wheel[Wheel.NOMINAL_LOAD_N])
    found: tuple[float, float, float, float, float] = soil_forces(soil, wheel, load_n, slip, 0.0)
    return found


def _torque_n(soil: Array, wheel: Array, slip: float) -> float:
    """Axle torque over the rolling radius."""
    shear, _, _, rolling, _ = _forces(soil, wheel, slip)
    return shear + rolling


def _pull_n(soil: Array, wheel: Array, slip: float) -> float:
    shear, _, resistance, _, _ = _forces(soil, wheel, slip)
    return shear - resistance


def _root(soil: Array, wheel: Array, of: Callable[[Array, Array, float], float]) -> float:
    """Slip at which a force that grows with slip is zero (bisection)."""
    low, high = -REACH, REACH
    for _ in range(50):
        middle = 0.5 * (low + high)
        if of(soil, wheel, middle) > 0.0:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
