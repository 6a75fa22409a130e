"""Slip at which the driven wheels transmit a force to the soil, in steady driving."""

from __future__ import annotations

import numpy as np

from twin.compute.compiled import compiled
from twin.physics.laws import soil_forces
from twin.physics.shapes import Array

LEAST_SLIP, MOST_SLIP = -0.2, 0.95
"""Range in which the slip is searched [-]."""
HALVINGS = 32


@compiled
def slips(
    soil: Array, wheels: Array, load_n: Array, lead: float, height: float, force_n: Array
) -> Array:
    """Slip of the rear wheels at which the driven wheels transmit a force (bisection). Shape (n,).

    Args:
        soil: part of the parameter block (`Soil`).
        wheels: parts of the parameter block in the order of `block.WHEELS`, (4, Wheel.SIZE).
        load_n: loads of one front and one rear wheel at rest [N], (2,).
        lead: front rim speed / rear rim speed - 1; NaN where the front axle is not driven.
        height: height of the pull divided by the wheelbase, which moves load to the rear.
        force_n: sum of axle torque / rolling radius over the driven wheels [N], (n,).
    """
    out = np.empty(len(force_n))
    for k in range(len(force_n)):
        moved_n = 0.5 * height * force_n[k]
        front_n, rear_n = max(load_n[0] - moved_n, 100.0), load_n[1] + min(moved_n, load_n[0])
        low, high = LEAST_SLIP, MOST_SLIP
        for _ in range(HALVINGS):
            slip = 0.5 * (low + high)
            shear, _, _, rolling, _ = soil_forces(soil, wheels[2], rear_n, slip, 0.0)
            handed_n = 2.0 * (shear + rolling)
            if lead == lead:
                front = 1.0 - (1.0 - slip) / (1.0 + lead)
                shear, _, _, rolling, _ = soil_forces(soil, wheels[0], front_n, front, 0.0)
                handed_n += 2.0 * (shear + rolling)
            if handed_n > force_n[k]:
                high = slip
            else:
                low = slip
        out[k] = 0.5 * (low + high)
    return out
