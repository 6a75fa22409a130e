"""How far a camera that looks down looks aside, from how the ground's picture is stretched.

Where it drives straight on, what is nearer seems faster. That tilt puts the point it looks at ahead
of or beside the point under it, 2.6 mm for 0.3 degree at 0.5 m; a vehicle that turns by 8 degrees
moves the one by 0.4 mm against the other. A body that leans in a furrow tilts it by 9 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from estimators.odometry.lens import Array, centre_px

MEMORY_S = 0.5
"""A chassis may roll on its tyres, slowly."""


@dataclass(frozen=True)
class Tilt:
    """The ground's normal in camera axes over its component along the optical axis."""

    normal: tuple[float, float] = (0.0, 0.0)
    weight: float = 0.0
    """Squares of the displacements over the focal length that it is the mean of."""


def seen(
    tilt: Tilt, warp: Array, shape: tuple[int, ...], focal_px: float, interval_s: float
) -> Tilt:
    """The mean with another map from current to previous.

    Over a plane of normal (m, n, 1) a displacement (x, y) in focal lengths stretches the picture by

        (W_11 - W_22) / 2 = (x m - y n) / 2,   (W_12 + W_21) / 2 = (x n + y m) / 2

    whatever it turns or the height changes; each counts as the square of its displacement.

    Args:
        tilt: the mean before.
        warp: the map, of measured stretching, shape (2, 3).
        shape: of the pictures.
        focal_px: at their size.
        interval_s: between them.
    """
    centre = centre_px(shape)
    x, y = (warp @ np.append(centre, 1.0) - centre) / focal_px
    stretch, shear = warp[0, 0] - warp[1, 1], warp[0, 1] + warp[1, 0]
    weight = math.exp(-interval_s / MEMORY_S) * tilt.weight + x * x + y * y
    if weight <= 0.0:
        return tilt
    m, n = tilt.normal
    m += (x * stretch + y * shear - (x * x + y * y) * m) / weight
    n += (x * shear - y * stretch - (x * x + y * y) * n) / weight
    return Tilt((float(m), float(n)), float(weight))


def leans(tilt: Tilt) -> tuple[float, float]:
    """How far the ground's normal leans forward and left; the picture's axes are right and down."""
    right, down = tilt.normal
    return math.atan(down), math.atan(right)


def bent(tilt: Tilt, warp: Array, shape: tuple[int, ...], focal_px: float, edge_px: float) -> Array:
    """What an affine map is off at the principal point, where a tilted plane is neared [px].

    Over a plane of normal (m, n, 1) a displacement (x, y, z) in heights moves the point at (a, b),
    in focal lengths, by

        (x - z a, y - z b) (1 + m a + n b)

    whose squares a least-squares affine map takes for a displacement of -z (m <a^2>, n <b^2>). z is
    what the picture grows by. A body that leans by 9 degrees in a furrow, its nose up by 0.7, would
    seem to slide by 0.4 mm/s.

    Args:
        tilt, warp, shape, focal_px: as in `seen`.
        edge_px: along the edges, that no point was taken of.
    """
    centre = centre_px(shape)
    moved = warp @ np.append(centre, 1.0) - centre
    normal = np.array(tilt.normal)
    z = 0.5 * (moved @ normal / focal_px - (warp[0, 0] + warp[1, 1] - 2.0))
    half = np.maximum(centre - edge_px - 0.5 * np.abs(moved), 0.0) / focal_px
    off: Array = -focal_px * z * normal * half**2 / 3.0
    return off
