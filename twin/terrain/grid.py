"""A map: values on a square grid over the ground, quadratic B-splines over its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GridMap:
    """Values over a part of the ground."""

    nodes: Array
    """Rows across the ground from the right, columns along it. Shape (rows, columns)."""
    cell_m: float
    """Distance between nodes."""
    start_m: float
    """s of the first column."""
    right_m: float
    """t of the first row."""
    repeats: bool
    """Whether the map repeats; if not, its border values continue."""

    def at(self, s_m: Array, t_m: Array) -> Array:
        """Values at places on the ground, as `twin.physics.ground.on_map`; arrays of one shape."""
        from scipy.ndimage import map_coordinates  # late: slow to import, and a plane needs none

        row = (np.asarray(t_m) - self.right_m) / self.cell_m
        column = (np.asarray(s_m) - self.start_m) / self.cell_m
        mode: Literal["grid-wrap", "nearest"] = "grid-wrap" if self.repeats else "nearest"
        place = np.stack([row, column])
        return map_coordinates(self.nodes, place, order=2, prefilter=False, mode=mode)
