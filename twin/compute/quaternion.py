"""Rotations as unit quaternions wxyz, from the body to the world.

Functions of the components w, x, y, z take numbers or arrays of one shape, and numba can compile
them. Only numpy is imported, so that importing this module costs little.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)
Components = tuple[Number, Number, Number]


def x_axis(w: Number, x: Number, y: Number, z: Number) -> Components[Number]:
    """The body's x axis in the world: where it heads."""
    return 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)


def y_axis(w: Number, x: Number, y: Number, z: Number) -> Components[Number]:
    """The body's y axis in the world."""
    return 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)


def z_axis(w: Number, x: Number, y: Number, z: Number) -> Components[Number]:
    """The body's z axis in the world."""
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


def up_b(w: Number, x: Number, y: Number, z: Number) -> Components[Number]:
    """The world's z axis in the body."""
    return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


def heading_rad(w: Array, x: Array, y: Array, z: Array) -> Array:
    """Direction of the body's x axis in the world's x-y plane, from x towards y."""
    ahead, left, _ = x_axis(w, x, y, z)
    return np.asarray(np.arctan2(left, ahead))


def roll_rad(w: Array, x: Array, y: Array, z: Array) -> Array:
    """Roll about the body's x axis, the last of yaw, pitch and roll; positive lowers the right."""
    _, side, up = up_b(w, x, y, z)
    return np.asarray(np.arctan2(side, up))


def cross(a: Array, b: Array) -> Array:
    """Cross products a x b, row by row. (..., 3), (..., 3) -> (..., 3)"""
    return np.stack(
        [
            a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
            a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
            a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0],
        ],
        axis=-1,
    )


def rotated(quaternion: Array, vector: Array) -> Array:
    """Vectors of the body in the world: v + 2 w (q x v) + 2 q x (q x v)

    Args:
        quaternion: shape (n, 4).
        vector: shape (3,) or (n, 3).

    Returns:
        Shape (n, 3).
    """
    w, q = quaternion[:, :1], quaternion[:, 1:]
    twice = 2.0 * cross(q, vector)
    return np.asarray(vector + w * twice + cross(q, twice))


def multiplied(p: Array, q: Array) -> Array:
    """The product p q, the rotation q and then p. Shapes (4,), or (4, n) of many."""
    a, b, c, d = p
    w, x, y, z = q
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def matrix(quaternion: Array) -> Array:
    """Rotation matrix of a quaternion of any length. Shape (3, 3)."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.stack([x_axis(w, x, y, z), y_axis(w, x, y, z), z_axis(w, x, y, z)], axis=1)


def from_matrix(rotation: Array) -> Array:
    """Quaternion of a rotation matrix (Shepperd's branch for the largest component). Shape (4,)."""
    r = rotation
    squares = np.array(
        [
            1.0 + r[0, 0] + r[1, 1] + r[2, 2],
            1.0 + r[0, 0] - r[1, 1] - r[2, 2],
            1.0 - r[0, 0] + r[1, 1] - r[2, 2],
            1.0 - r[0, 0] - r[1, 1] + r[2, 2],
        ]
    )
    k = int(np.argmax(squares))
    largest = math.sqrt(squares[k])
    w, x, y = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    a, b, c = r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1]
    columns = np.array(
        [
            [squares[0], w, x, y],
            [w, squares[1], a, b],
            [x, a, squares[2], c],
            [y, b, c, squares[3]],
        ]
    )
    return np.asarray(0.5 * columns[k] / largest)
