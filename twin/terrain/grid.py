"""A map: values on a square grid over the ground, quadratic B-splines over its nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class GridMap:
    """Values on a square grid over a part of the ground; s points along, t to the left."""

    nodes: Array
    """Rows across the ground from the right, columns along it. Shape (rows, columns)."""
    cell_m: float
    """Distance between nodes [m]."""
    start_m: float
    """s of the first column [m]."""
    right_m: float
    """t of the first row [m]."""
    repeats: bool
    """Whether the map repeats; if not, its border values continue."""

    def at(self, s_m: Array, t_m: Array) -> Array:
        """Values at the points (s_m, t_m) [m], as in `ground.on_map`; arrays of one shape."""
        row = (np.asarray(t_m) - self.right_m) / self.cell_m
        column = (np.asarray(s_m) - self.start_m) / self.cell_m
        if self.repeats:
            return _between_nodes(self.nodes, row, column)
        from scipy.ndimage import map_coordinates  # slow to load, and most ground repeats

        place = np.stack([row, column])
        return map_coordinates(self.nodes, place, order=2, prefilter=False, mode="nearest")

    def turned(self, length_m: float) -> GridMap:
        """Same ground for the drive back from s = length [m]: s' = length - s, t' = -t."""
        rows, columns = self.nodes.shape
        start_m = length_m - self.start_m - (columns - 1) * self.cell_m
        right_m = -self.right_m - (rows - 1) * self.cell_m
        return replace(self, nodes=self.nodes[::-1, ::-1], start_m=start_m, right_m=right_m)


def _between_nodes(nodes: Array, row: Array, column: Array) -> Array:
    """Value of a map that repeats: the same bits as scipy's `map_coordinates`."""
    rows, along_row = _nearest(row, nodes.shape[0])
    columns, along_column = _nearest(column, nodes.shape[1])
    total = np.zeros(row.shape)
    for i, weight in zip(rows, along_row, strict=True):
        for j, other in zip(columns, along_column, strict=True):
            total += nodes[i, j] * weight * other
    return total


def _nearest(x: Array, count: int) -> tuple[tuple[Indices, ...], tuple[Array, ...]]:
    """The three nearest of `count` nodes that repeat, and their weights in a B-spline."""
    below, above = x < 0.0, x > count - 1
    x = np.where(below, x + count * (np.trunc(-x / count) + 1.0), x)
    x = np.where(above, x - count * np.trunc(x / count), x)
    nearest = np.floor(x + 0.5)
    a, i = x - nearest, nearest.astype(np.int64)
    before, at = 0.5 * (0.5 - a) * (0.5 - a), 0.75 - a * a
    return ((i - 1) % count, i % count, (i + 1) % count), (before, at, 1.0 - before - at)
