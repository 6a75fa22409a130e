"""Envelope of the ground heights: height of the hub of a rigid wheel that rolls over the ground."""

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
CACHED = 16384
"""Nodes that are worked on at a time: a processor's cache holds them."""


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
    reach = int(REACH * radius_m / heights.cell_m)
    sag_m = radius_m - np.sqrt(radius_m**2 - (np.arange(reach + 1) * heights.cell_m) ** 2)
    felt, none = heights.nodes.copy(), (0, 0)
    beyond = ((reach, reach), none) if across else (none, (reach, reach))
    wide = np.pad(heights.nodes, beyond, mode="wrap" if heights.repeats else "edge")
    rows = max(1, CACHED // felt.shape[1])
    for first in range(0, len(felt), rows):
        part = felt[first : first + rows]
        reached = wide[first : first + len(part) + (2 * reach if across else 0)]
        if across:
            _raise(part, reached, sag_m)
        else:
            _raise(part.T, reached.T, sag_m)
    return felt


def _raise(felt: Array, wide: Array, sag_m: Array) -> None:
    """Raise heights to where the arc touches k rows before or after: max(h_-k, h_k) - sag_k.

    Args:
        felt: read and written (n, m).
        wide: the heights, with the arc's reach before and after (reach + n + reach, m).
        sag_m: of the arc at 0 .. reach rows from its middle (reach + 1,).
    """
    n, middle, touched = len(felt), len(sag_m) - 1, np.empty_like(felt)
    for k in range(1, len(sag_m)):
        before, after = (wide[at : at + n] for at in (middle - k, middle + k))
        np.maximum(before, after, out=touched)
        touched -= sag_m[k]
        np.maximum(felt, touched, out=felt)
