"""How a wheel presses on the ground: elastic force, moment and overlap, from one stored energy.

A tyre is two rings of springs, a width of b / sqrt(12) to each side of its middle, which give a
leaning tread the moment of a tread that is sprung all over its width. Every force here is the
gradient of the energy its springs hold, so that rolling over any ground neither makes nor loses
energy; dampers and friction come on top of it.

Directions: n the normal of the ground's plane, c the wheel's axle, u the direction in the wheel's
plane nearest to n, a = c x u. Vectors are in world axes.
"""

from __future__ import annotations

import math

from twin.physics import rigid
from twin.physics.block import Field, Grid
from twin.physics.compiled import law
from twin.physics.ground import field_axis, on_ground, on_map
from twin.physics.shapes import Array, Vector

RING = 1.0 / math.sqrt(12.0)
"""Distance of a ring from the tyre's middle over the tyre's width: Gauss' rule of two points."""
LEAST_UPRIGHT = 0.01
"""u . n of a wheel that lies on its side, whose tread has no place on the ground."""
ARC_POINTS = 12
"""Points of a ring's outline that look for uneven ground."""
ARC_REACH = 0.6
"""How far they reach to each side of the hub, over the radius."""
EVEN_ARC = 32.0 / 35.0 * math.sqrt(2.0)
"""Integral of the overlap's cube along the arc on even ground, over sqrt(R) delta**3.5."""


@law
def upward(axle: Vector, normal: Vector) -> tuple[Vector, float]:
    """u, the direction in the wheel's plane nearest to the normal, and u . n.

    u = (n - (n . c) c) / |n - (n . c) c|
    """
    camber = rigid.dot(axle, normal)
    upright = math.sqrt(max(1.0 - camber * camber, LEAST_UPRIGHT * LEAST_UPRIGHT))
    across = rigid.minus(normal, rigid.scaled(camber, axle))
    return rigid.scaled(1.0 / upright, across), upright


@law
def ring_on_plane(
    above_m: float, radius_m: float, stiffness_npm: float, offset: Vector, normal: Vector
) -> tuple[Vector, Vector, float, float]:
    """One ring on even ground.

        delta = R (u . n) + w (c . n) - h        F = k min(delta, R) n
        U = k delta**2 / 2, from delta = R on k R (delta - R / 2)

    Args:
        above_m: height of the hub above the ground, h.
        radius_m: R; deeper than that the force grows no further.
        stiffness_npm: k of this ring.
        offset: of its lowest point from the hub, -R u + w c.
        normal: n.

    Returns:
        force, moment about the hub, overlap_m (positive in contact), energy_j.
    """
    overlap = -(above_m + rigid.dot(offset, normal))
    if overlap <= 0.0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), overlap, 0.0
    pressed = min(overlap, radius_m)
    force = rigid.scaled(stiffness_npm * pressed, normal)
    energy = stiffness_npm * pressed * (overlap - 0.5 * pressed)
    return force, rigid.cross(offset, force), overlap, energy


@law
def ring_on_map(
    field: Array,
    nodes: Array,
    hub: Vector,
    raised_m: float,
    axle: Vector,
    up: Vector,
    radius_m: float,
    stiffness_npm: float,
    aside_m: float,
) -> tuple[Vector, Vector, float, float]:
    """One ring on the height map, along the arc of its outline: an enveloping contact.

        p_j   = hub + x_j a - (R - x_j**2 / (2 R)) u + w c        o_j = g(p_j) - p_j . n
        B     = sum over o_j > 0 of o_j**3 dx
        delta = (B / (32/35 sqrt(2 R)))**(2/7)                    U = k delta**2 / 2
        f_j   = 6/7 k delta**2 / B o_j**2 dx (n - dg/ds s - dg/dt t)

    delta is the overlap with the even ground that holds the same B, so that on even ground
    F = k delta (within 1 % from 2 % of the radius on). A contact of equal overlap is the idea of
    Sui and Hirshey 2001 (A new analytical tire model for vehicle dynamic analysis), who take its
    area. With the cube the deepest points count most, and a point of the outline begins to touch
    without a jump of the force.

    Args:
        field, nodes: the ground's part of the block, and the model's hfield_data.
        hub, axle, up: c and u of the wheel.
        raised_m: what the ground is raised by beside its map: the furrow's bottom.
        radius_m, stiffness_npm, aside_m: R, k and w of this ring.

    Returns:
        as `ring_on_plane`; the moment without its part about the axle, which a disc has not.
    """
    normal = field_axis(field, Field.NORMAL)
    s_axis, t_axis = field_axis(field, Field.AHEAD), field_axis(field, Field.LEFT)
    along = rigid.cross(axle, up)
    step = 2.0 * ARC_REACH * radius_m / ARC_POINTS
    cube = lift = push_s = push_t = 0.0
    moment = (0.0, 0.0, 0.0)
    for j in range(ARC_POINTS):
        x = (j + 0.5) * step - ARC_REACH * radius_m
        down = 0.5 * x * x / radius_m - radius_m
        arm = rigid.plus(
            rigid.scaled(x, along), rigid.plus(rigid.scaled(down, up), rigid.scaled(aside_m, axle))
        )
        s, t, above = on_ground(field, rigid.plus(hub, arm))
        height, slope_s, slope_t = on_map(field, Field.HEIGHTS, nodes, s, t)
        overlap = raised_m + height - above
        if overlap <= 0.0:
            continue
        square = overlap * overlap
        cube += overlap * square * step
        lift += square
        push_s -= square * slope_s
        push_t -= square * slope_t
        here = rigid.minus(
            normal, rigid.plus(rigid.scaled(slope_s, s_axis), rigid.scaled(slope_t, t_axis))
        )
        moment = rigid.plus(moment, rigid.cross(arm, rigid.scaled(square, here)))
    if cube <= 0.0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0
    overlap = (cube / (EVEN_ARC * math.sqrt(radius_m))) ** (2.0 / 7.0)
    pressed = min(overlap, radius_m)
    per_square = 6.0 / 7.0 * stiffness_npm * pressed * overlap / cube * step
    force = rigid.plus(
        rigid.scaled(per_square * lift, normal),
        rigid.plus(
            rigid.scaled(per_square * push_s, s_axis), rigid.scaled(per_square * push_t, t_axis)
        ),
    )
    turning = rigid.minus(moment, rigid.scaled(rigid.dot(moment, axle), axle))
    energy = stiffness_npm * pressed * (overlap - 0.5 * pressed)
    return force, rigid.scaled(per_square, turning), overlap, energy


@law
def ring(
    field: Array,
    nodes: Array,
    hub: Vector,
    raised_m: float,
    axle: Vector,
    up: Vector,
    radius_m: float,
    stiffness_npm: float,
    aside_m: float,
) -> tuple[Vector, Vector, float, float]:
    """One ring on the ground as it is: `ring_on_map` where heights vary, else `ring_on_plane`."""
    if field[Field.HEIGHTS + Grid.RANGE] != 0.0:
        return ring_on_map(field, nodes, hub, raised_m, axle, up, radius_m, stiffness_npm, aside_m)
    normal = field_axis(field, Field.NORMAL)
    offset = rigid.plus(rigid.scaled(-radius_m, up), rigid.scaled(aside_m, axle))
    above = rigid.dot(hub, normal) - raised_m - field[Field.HEIGHTS + Grid.LOW]
    return ring_on_plane(above, radius_m, stiffness_npm, offset, normal)
