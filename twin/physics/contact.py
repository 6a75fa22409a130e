"""How a wheel presses on the ground: elastic force, moment and overlap, from one stored energy.

A tyre is two rings of springs, a width of b / sqrt(12) to each side of its middle, which give a
leaning tread the moment of a tread that is sprung all over its width. Every force here is the
gradient of the energy its springs hold, so that rolling over any ground neither makes nor loses
energy; dampers and friction come on top of it.

On uneven ground a ring touches at the nearest point of its arc. Where that is does not depend on
the load, so the heights that a hub feels are made beforehand, one map for each radius
(`twin.terrain.envelope`), and looked up under the hub.

Directions: n the normal of the ground's plane, c the wheel's axle, u the direction in the wheel's
plane nearest to n, a = c x u; s and t run along the ground and to its left. Vectors are in world
axes.
"""

from __future__ import annotations

import math

from twin.compute.compiled import inlined_law
from twin.physics import rigid
from twin.physics.block import Field, Grid, Wheel
from twin.physics.ground import field_axis, on_nodes, smooth_step
from twin.physics.shapes import Array, Vector

RING = 1.0 / math.sqrt(12.0)
"""Distance of a ring from the tyre's middle over the tyre's width: Gauss' rule of two points."""
LEAST_UPRIGHT = 0.01
"""Least u . n that is used, for a wheel that lies on its side [-]."""
TURNED_FROM, TURNED_OVER = 0.1, 0.8
"""Sine of the wheel's heading at which the height begins to pass from the envelope along the ground
to the envelope across it, and the range of the sine over which it passes [-]."""


@inlined_law
def upward(axle: Vector, normal: Vector) -> tuple[Vector, float]:
    """u, the direction in the wheel's plane nearest to the normal, and u . n.

    u = (n - (n . c) c) / |n - (n . c) c|, with c the `axle` and n the `normal`.
    """
    camber = rigid.dot(axle, normal)
    upright = math.sqrt(max(1.0 - camber * camber, LEAST_UPRIGHT * LEAST_UPRIGHT))
    across = rigid.minus(normal, rigid.scaled(camber, axle))
    return rigid.scaled(1.0 / upright, across), upright


@inlined_law
def felt_height(
    field: Array, nodes: Array, envelope: int, place: Vector, along: Vector
) -> tuple[float, float, float, float]:
    """Height of the ground as a wheel of one radius feels it under its hub.

        g = (1 - q) g_along + q g_across        q from the wheel's heading psi on the ground

    Args:
        field: part of the parameter block (`Field`).
        nodes: the model's hfield_data.
        envelope: which kind of wheel (`twin.physics.block.Envelope`).
        place: any point on the ground's normal through the place, world axes.
        along: unit vector in which the wheel rolls, world axes.

    Returns:
        g [m] above the ground's plane, dg/ds, dg/dt, dg/dpsi.
    """
    if field[Field.HEIGHTS + Grid.RANGE] == 0.0:
        return field[Field.HEIGHTS + Grid.LOW], 0.0, 0.0, 0.0
    s_axis, t_axis = field_axis(field, Field.AHEAD), field_axis(field, Field.LEFT)
    s, t = rigid.dot(place, s_axis), rigid.dot(place, t_axis)
    count = int(field[Field.HEIGHTS + Grid.ROWS] * field[Field.HEIGHTS + Grid.COLUMNS])
    first = int(field[Field.ENVELOPES]) + 2 * envelope * count
    height, slope_s, slope_t = on_nodes(field, Field.HEIGHTS, first, nodes, s, t)
    sine = rigid.dot(along, t_axis)
    if abs(sine) <= TURNED_FROM:
        return height, slope_s, slope_t, 0.0
    share, growth = smooth_step((abs(sine) - TURNED_FROM) / TURNED_OVER)
    across, across_s, across_t = on_nodes(field, Field.HEIGHTS, first + count, nodes, s, t)
    cosine = math.copysign(1.0, sine) * rigid.dot(along, s_axis)
    return (
        height + share * (across - height),
        slope_s + share * (across_s - slope_s),
        slope_t + share * (across_t - slope_t),
        growth * cosine / TURNED_OVER * (across - height),
    )


@inlined_law
def ring(
    field: Array,
    nodes: Array,
    wheel: Array,
    hub: Vector,
    raised_m: float,
    axle: Vector,
    up: Vector,
    aside_m: float,
) -> tuple[Vector, Vector, float, float, float]:
    """Force of the ground on one of a tyre's two rings, and its energy.

        p = -R u + w c        delta = g(p) - (hub + p) . n        U = k/2 delta**2 / 2
        F = k/2 min(delta, R) (n - dg/ds s - dg/dt t)

    F acts at hub + p. In the wheel's plane p is under the hub, where the envelope gives the height;
    the caller drops the part of the moment about the axle, since a round wheel is pushed through
    its hub. Where delta > R, U grows in proportion to delta.

    Args:
        field: part of the parameter block (`Field`).
        nodes: the model's hfield_data.
        wheel: part of the parameter block (`Wheel`): R, k and the kind of envelope.
        hub: position of the hub.
        raised_m: height of the furrow's bottom, added to the map's; at most 0.
        axle, up: c and u.
        aside_m: w, distance of the ring from the tyre's middle along c.

    Returns:
        force [N], moment about the hub [N m], overlap_m (delta; 0 without contact), energy_j (U),
        and the force's size [N].
    """
    normal, radius_m = field_axis(field, Field.NORMAL), 0.5 * wheel[Wheel.DIAMETER_M]
    lowest = rigid.plus(rigid.scaled(-radius_m, up), rigid.scaled(aside_m, axle))
    place = rigid.plus(hub, lowest)
    height, slope_s, slope_t, turned = felt_height(
        field, nodes, int(wheel[Wheel.ENVELOPE]), place, rigid.cross(axle, up)
    )
    overlap = raised_m + height - rigid.dot(place, normal)
    if overlap <= 0.0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    pressed, stiffness = min(overlap, radius_m), 0.5 * wheel[Wheel.STIFFNESS_NPM]
    energy = stiffness * pressed * (overlap - 0.5 * pressed)
    push = stiffness * pressed
    force, about, size = rigid.scaled(push, normal), 0.0, push
    if slope_s != 0.0 or slope_t != 0.0:
        tilt = rigid.plus(
            rigid.scaled(-slope_s, field_axis(field, Field.AHEAD)),
            rigid.scaled(-slope_t, field_axis(field, Field.LEFT)),
        )
        force = rigid.plus(force, rigid.scaled(push, tilt))
        about = -push * turned
        size *= math.sqrt(1.0 + slope_s * slope_s + slope_t * slope_t)
    moment = rigid.plus(rigid.cross(lowest, force), rigid.scaled(about, normal))
    return force, moment, overlap, energy, size
