"""A surface over a grid of points, as triangles with normals."""

from __future__ import annotations

import numpy as np

from twin.viz.tools import Array


def triangles(n: int, m: int) -> Array:
    """Corners of the triangles over n x m points, row by row. Shape (2 (n - 1) (m - 1), 3)."""
    corner = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    lower = np.stack([corner, corner + m, corner + 1], axis=1)
    upper = np.stack([corner + 1, corner + m, corner + m + 1], axis=1)
    return np.concatenate([lower, upper])


def normals(points: Array) -> Array:
    """Unit normals of a surface. Shapes (n, m, 3) -> (n, m, 3)."""
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))
