"""The group SE_2(3): an attitude R with a velocity v and a slip velocity u that turn with it.

    X = (R, v, u),   Exp(phi, nu, mu) X = (E R, E v + J nu, E u + J mu)
    E = exp(phi^),   J = sum_n (phi^)^n / (n + 1)!

phi^ is the matrix of phi x. Vectors are (3,), matrices (3, 3).

Source: Barrau and Bonnabel (2017), IEEE Trans. Autom. Control 62, 1797, eq. (8) and appendix A.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array
from twin.compute.compiled import compiled

SMALL_RAD = 1e-6
"""Below this angle the series replace the sine."""


@compiled
def skew(a: Array) -> Array:
    """The matrix of a x."""
    out = np.zeros((3, 3))  # a list of lists is slow where it is compiled
    out[2, 1], out[0, 2], out[1, 0] = a[0], a[1], a[2]
    out[1, 2], out[2, 0], out[0, 1] = -a[0], -a[1], -a[2]
    return out


@compiled
def times(a: Array, b: Array) -> Array:
    """The product of two matrices, (3, 3)."""
    out = np.zeros((3, 3))
    for i in range(3):
        for k in range(3):
            for j in range(3):
                out[i, j] += a[i, k] * b[k, j]
    return out


@compiled
def turn(a: Array, x: Array) -> Array:
    """A x."""
    out = np.zeros(3)
    for i in range(3):
        for k in range(3):
            out[i] += a[i, k] * x[k]
    return out


@compiled
def turn_back(a: Array, x: Array) -> Array:
    """A^T x."""
    out = np.zeros(3)
    for i in range(3):
        for k in range(3):
            out[i] += a[k, i] * x[k]
    return out


@compiled
def rotation(phi: Array) -> Array:
    """exp(phi^) by Rodrigues' formula."""
    return _series(phi, False)


@compiled
def left_jacobian(phi: Array) -> Array:
    """J = I + (1 - cos a) / a^2 phi^ + (a - sin a) / a^3 (phi^)^2,   a = |phi|."""
    return _series(phi, True)


@compiled
def _series(phi: Array, integrated: bool) -> Array:
    angle = math.sqrt(phi[0] ** 2 + phi[1] ** 2 + phi[2] ** 2)
    if angle < SMALL_RAD:
        first, second = (0.5, 1.0 / 6.0) if integrated else (1.0, 0.5)
    elif integrated:
        first = (1.0 - math.cos(angle)) / angle**2
        second = (angle - math.sin(angle)) / angle**3
    else:
        first, second = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle**2
    matrix = skew(phi)
    return np.eye(3) + first * matrix + second * times(matrix, matrix)


@compiled
def attitude(yaw_rad: float, up: Array) -> Array:
    """World from body: heading yaw, and the body sees up in this direction, a unit vector."""
    sin_pitch = -up[0]
    cos_pitch = math.sqrt(max(1.0 - sin_pitch**2, 1e-12))
    sin_roll, cos_roll = up[1] / cos_pitch, up[2] / cos_pitch
    pitch = np.array([[cos_pitch, 0.0, sin_pitch], [0.0, 1.0, 0.0], [-sin_pitch, 0.0, cos_pitch]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cos_roll, -sin_roll], [0.0, sin_roll, cos_roll]])
    return times(rotation(np.array([0.0, 0.0, yaw_rad])), times(pitch, roll))
