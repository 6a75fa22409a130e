"""The ground as a rolling wheel feels it: heights enveloped by the wheel's arc."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.terrain.grid import GridMap

Array = NDArray[np.float64]

Axis = Literal["along", "across"]
"""Which way a wheel rolls over the ground."""
AXES: tuple[Axis, ...] = ("along", "across")
REACH = 0.75
"""How far the arc reaches to each side, over the radius: it meets a slope of 1 at 0.71."""


def envelope(heights: GridMap, radius_m: float, axis: Axis) -> Array:
    """Heights under a hub, of a wheel that rolls along or across the ground.

        g(x) = max over |y| <= 0.75 R of h(x + y) - (R - sqrt(R**2 - y**2))

    The nearest point of the arc touches: g + R is how high a rigid wheel's hub rolls. Geometric
    filtering by a circle, as in Captain, Boghani and Wormley 1979, Vehicle System Dynamics 8:1.

    Args:
        heights: the ground.
        radius_m: R.
        axis: which way the wheel rolls.

    Returns:
        nodes that lie as those of `heights`.
    """
    across = axis == "across"
    count = heights.nodes.shape[0 if across else 1]
    reach = int(REACH * radius_m / heights.cell_m)
    felt = heights.nodes.copy()
    for k in (k for k in range(-reach, reach + 1) if k):
        sag_m = radius_m - np.sqrt(radius_m**2 - (k * heights.cell_m) ** 2)
        at = np.arange(count) + k
        at = at % count if heights.repeats else np.clip(at, 0, count - 1)
        shifted = heights.nodes[at] if across else heights.nodes[:, at]
        np.maximum(felt, shifted - sag_m, out=felt)
    return felt
