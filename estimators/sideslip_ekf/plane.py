"""The ground plane: from what a receiver says in the horizontal to directions in the plane.

Axes of the plane come from east, north, up by the shortest rotation that takes up to its normal, so
that on level ground they are east and north. A heading in the plane is counted in them; it changes
by the turning about the normal, exactly.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEWTON_STEPS = 6


def world_from_plane(up: Array) -> Array:
    """Rotation from a plane's axes to east, north, up. Shape (3, 3).

    With up = (a, b, c) in the plane's axes, the transpose of the shortest rotation that takes z
    to it:

        P^T = [[1 - a^2/(1+c), -ab/(1+c), a], [-ab/(1+c), 1 - b^2/(1+c), b], [-a, -b, c]]

    Args:
        up: unit vector of the vertical in the plane's axes, c > -1. Shape (3,).
    """
    a, b, c = (float(v) for v in up)
    d = 1.0 / (1.0 + c)
    plane_from_world = np.array(
        [[1.0 - a * a * d, -a * b * d, a], [-a * b * d, 1.0 - b * b * d, b], [-a, -b, c]]
    )
    return plane_from_world.T


def tilted(tilt: Array) -> Array:
    """Unit vector of the vertical from its two components in the plane, cut off at 60 degrees."""
    size = float(np.hypot(tilt[0], tilt[1]))
    share = min(1.0, 0.87 / size) if size > 0.0 else 1.0
    a, b = share * float(tilt[0]), share * float(tilt[1])
    return np.array([a, b, math.sqrt(1.0 - a * a - b * b)])


def azimuth(rotation: Array, heading_rad: float) -> tuple[float, float]:
    """Horizontal direction of a heading in the plane, and its derivative.

        d = P (cos h, sin h, 0),  A = atan2(d_n, d_e)
        dA/dh = (d_e d_n' - d_n d_e') / (d_e^2 + d_n^2)

    Args:
        rotation: `world_from_plane`.
        heading_rad: in the plane.
    """
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    east, north = (rotation[i, 0] * cos + rotation[i, 1] * sin for i in (0, 1))
    d_east, d_north = (rotation[i, 1] * cos - rotation[i, 0] * sin for i in (0, 1))
    flat = east * east + north * north
    return math.atan2(north, east), float((east * d_north - north * d_east) / flat)


def heading(rotation: Array, azimuth_rad: float) -> float:
    """Heading in the plane whose horizontal direction is given (Newton's method)."""
    found = azimuth_rad
    for _ in range(NEWTON_STEPS):
        seen, slope = azimuth(rotation, found)
        found += wrap(azimuth_rad - seen) / slope
    return found


def wrap(angle_rad: float) -> float:
    """The angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi
