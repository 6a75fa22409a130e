"""Vectors as tuples; points, velocities and forces from fields of mjData.

`xpos`, `xmat`, `cvel` and `cdof` are fields of mjData, `com` is its subtree_com. `body` is a body's
number, `root` that of the root of its kinematic tree: MuJoCo gives `cvel` and `cdof` at com[root].
"""

from __future__ import annotations

import math

from twin.compute.compiled import inlined_law
from twin.physics.shapes import Array, Integers, Vector


@inlined_law
def dot(a: Vector, b: Vector) -> float:
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined_law
def cross(a: Vector, b: Vector) -> Vector:
    """a x b"""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@inlined_law
def scaled(k: float, a: Vector) -> Vector:
    """k a"""
    return (k * a[0], k * a[1], k * a[2])


@inlined_law
def plus(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined_law
def minus(a: Vector, b: Vector) -> Vector:
    """a - b"""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@inlined_law
def unit(a: Vector) -> Vector:
    """a / |a|"""
    return scaled(1.0 / math.sqrt(dot(a, a)), a)


@inlined_law
def row3(array: Array, i: int) -> Vector:
    """Row i of an (n, 3) array as a tuple."""
    return (array[i, 0], array[i, 1], array[i, 2])


@inlined_law
def axis(xmat: Array, body: int, k: int) -> Vector:
    """Axis k (0, 1, 2) of a body's frame as a unit vector in world axes."""
    return (xmat[body, k], xmat[body, 3 + k], xmat[body, 6 + k])


@inlined_law
def to_world(xpos: Array, xmat: Array, body: int, point_b: Vector) -> Vector:
    """World position of a point given in a body's frame."""
    return (
        xpos[body, 0]
        + xmat[body, 0] * point_b[0]
        + xmat[body, 1] * point_b[1]
        + xmat[body, 2] * point_b[2],
        xpos[body, 1]
        + xmat[body, 3] * point_b[0]
        + xmat[body, 4] * point_b[1]
        + xmat[body, 5] * point_b[2],
        xpos[body, 2]
        + xmat[body, 6] * point_b[0]
        + xmat[body, 7] * point_b[1]
        + xmat[body, 8] * point_b[2],
    )


@inlined_law
def angular_velocity(cvel: Array, body: int) -> Vector:
    """Angular velocity of a body, world axes."""
    return (cvel[body, 0], cvel[body, 1], cvel[body, 2])


@inlined_law
def point_velocity(cvel: Array, com: Array, body: int, root: int, point: Vector) -> Vector:
    """Velocity [m/s] of a point fixed to a body; `point` is its position in world coordinates."""
    linear = (cvel[body, 3], cvel[body, 4], cvel[body, 5])
    return plus(linear, cross(angular_velocity(cvel, body), minus(point, row3(com, root))))


@inlined_law
def push(
    force_out: Array,
    cdof: Array,
    parent: Integers,
    last_dof: int,
    com: Array,
    root: int,
    point: Vector,
    force: Vector,
    torque: Vector,
) -> None:
    """Add a force at a point and a torque on a body to generalised forces.

        q_j += w_j . (torque + (point - com) x force) + v_j . force

    for each degree of freedom j that moves the body, with its rotation w_j and translation v_j.

    Args:
        force_out: q, for instance qfrc_passive; added to.
        cdof: w_j and v_j, (nv, 6).
        parent: dof_parentid of the model.
        last_dof: the last degree of freedom that moves the body; -1 for a fixed body.
        com, root: see the module.
        point, force, torque: world axes [m, N, N m].
    """
    moment = plus(torque, cross(minus(point, row3(com, root)), force))
    j = last_dof
    while j >= 0:
        force_out[j] += (
            cdof[j, 0] * moment[0] + cdof[j, 1] * moment[1] + cdof[j, 2] * moment[2]
            + cdof[j, 3] * force[0] + cdof[j, 4] * force[1] + cdof[j, 5] * force[2]
        )  # fmt: skip
        j = parent[j]
