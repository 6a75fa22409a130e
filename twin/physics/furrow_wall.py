"""The furrow's wall and the turned slice beyond it, as they push a tyre's flanks."""

from __future__ import annotations

import math

from twin.compute.compiled import inlined_law
from twin.physics import rigid
from twin.physics.block import Field, Wheel
from twin.physics.ground import field_axis, smooth_step
from twin.physics.shapes import Array, Vector

SLICE_M = 0.15
"""How deep a tyre can press into the turned slice before it rides up on it [m]; assumed."""
NOTHING = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)


@inlined_law
def wall_force(
    field: Array,
    wheel: Array,
    hub: Vector,
    axle: Vector,
    velocity: Vector,
    turning: Vector,
    depth_m: float,
) -> tuple[Vector, Vector, float, float, float]:
    """Force of the furrow's wall, and of the turned slice opposite, on a tyre's flanks.

    Args:
        field, wheel: parts of the parameter block (`Field`, `Wheel`).
        hub, axle: position of the hub and direction of the axle, world axes.
        velocity: velocity of the hub [m/s].
        turning: angular velocity of the wheel without its spin about the axle [rad/s].
        depth_m: D, the depth of the furrow under the tread.

    Returns:
        what `flank_force` returns, summed over wall and slice.
    """
    if depth_m <= 0.0:
        return NOTHING
    edge_m = field[Field.FURROW_EDGE_M]
    wall, wall_moment, wall_j, wall_growth, wall_w = flank_force(
        field, wheel, hub, axle, velocity, turning, depth_m, edge_m, 1.0
    )
    slice_, slice_moment, slice_j, slice_growth, slice_w = flank_force(
        field, wheel, hub, axle, velocity, turning, depth_m,
        edge_m + field[Field.FURROW_WIDTH_M], -1.0,
    )  # fmt: skip
    return (
        rigid.plus(wall, slice_), rigid.plus(wall_moment, slice_moment), wall_j + slice_j,
        wall_growth + slice_growth, wall_w + slice_w,
    )  # fmt: skip


@inlined_law
def flank_force(
    field: Array,
    wheel: Array,
    hub: Vector,
    axle: Vector,
    velocity: Vector,
    turning: Vector,
    depth_m: float,
    place_m: float,
    outward: float,
) -> tuple[Vector, Vector, float, float, float]:
    """Force of one side of the furrow on the flank of the tyre that faces it.

        e = unit vector of the axle c without its part along s, away from the side of the furrow
        p = b / 2 - e . (hub - W)        F = w (k D p - c D dp/dt) e at W, never a pull
        U = w k D p**2 / 2               w = q(2 (c . t)**2 - 1/2)

    k and c are stiffness and damping per metre of depth, b the tyre's width, q `smooth_step`. W is
    the nearest point of the furrow's side, half way up its depth D; the unit vector s points along
    the furrow, t across it. w falls from 1 to 0 as the wheel turns across the furrow, where its
    flank no longer faces the side. The slice is loose: beyond p = SLICE_M its force falls, and is
    0 from 2 SLICE_M, where the tyre is on top of it. The spring's part of F is the gradient of U.

    Args:
        field, wheel, hub, axle, velocity, turning, depth_m: as for `wall_force`.
        place_m: distance of the side from the pass's line, positive to where the furrow is.
        outward: 1 for the wall, which pushes away from the line; -1 for the slice.

    Returns:
        force [N], moment about the hub [N m], energy_j (U), dU/dD [J/m], power_w taken from the
        machine.
    """
    left, along = field_axis(field, Field.LEFT), field_axis(field, Field.AHEAD)
    to_side = field[Field.FURROW_SIDE] * field[Field.PASS_WAY]
    across = rigid.dot(axle, left)
    share, share_growth = smooth_step(2.0 * across * across - 0.5)
    if share <= 0.0:
        return NOTHING
    flat = rigid.minus(axle, rigid.scaled(rigid.dot(axle, along), along))
    per_size = 1.0 / math.sqrt(rigid.dot(flat, flat))
    way = to_side * outward if across >= 0.0 else -to_side * outward
    facing = rigid.scaled(way * per_size, flat)
    normal = field_axis(field, Field.NORMAL)
    point = rigid.plus(
        rigid.scaled(rigid.dot(hub, along), along),
        rigid.plus(
            rigid.scaled(field[Field.PASS_T_M] + to_side * place_m, left),
            rigid.scaled(-0.5 * depth_m, normal),
        ),
    )
    arm = rigid.minus(point, hub)
    pressed = 0.5 * wheel[Wheel.WIDTH_M] + rigid.dot(facing, arm)
    if pressed <= 0.0:
        return NOTHING
    spring, work = pressed, 0.5 * pressed * pressed
    if outward < 0.0 and pressed > SLICE_M:
        spring = max(2.0 * SLICE_M - pressed, 0.0)
        work = SLICE_M * SLICE_M - 0.5 * spring * spring
    # as the wheel turns p changes by how e does, and w too
    turned = rigid.minus(arm, rigid.scaled(rigid.dot(facing, arm), facing))
    moment = rigid.scaled(way * per_size, rigid.cross(turned, axle))
    leaving = rigid.dot(facing, velocity) + rigid.dot(moment, turning)
    stiffness = share * field[Field.WALL_STIFFNESS_NPM]
    damping = share * field[Field.WALL_DAMPING_NSPM] * depth_m if spring > 0.0 else 0.0
    push = max(0.0, stiffness * depth_m * spring - damping * leaving)
    fading = share_growth * 4.0 * across * field[Field.WALL_STIFFNESS_NPM] * depth_m * work
    about = rigid.scaled(fading, rigid.cross(left, axle))
    growth = stiffness * (work - 0.5 * depth_m * spring * rigid.dot(facing, normal))
    return (
        rigid.scaled(push, facing),
        rigid.plus(rigid.scaled(push, moment), about),
        stiffness * depth_m * work,
        growth,
        -push * leaving - rigid.dot(about, turning),
    )
