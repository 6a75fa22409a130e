"""The furrow's wall and the turned slice beyond it, as they push a tyre's flanks."""

from __future__ import annotations

from twin.physics import rigid
from twin.physics.block import Field, Wheel
from twin.physics.compiled import law
from twin.physics.ground import field_axis
from twin.physics.shapes import Array, Vector

SLICE_M = 0.15
"""How deep a tyre can press into the turned slice before it rides up on it [m]; assumed."""
NOTHING = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)


@law
def wall_force(
    field: Array,
    wheel: Array,
    hub: Vector,
    axle: Vector,
    velocity: Vector,
    turning: Vector,
    depth_m: float,
) -> tuple[Vector, Vector, float, float, float]:
    """Push of the furrow's wall, and of the slice beyond it, on the flanks they touch.

    Args:
        field, wheel: parts of the block.
        hub, axle: of the wheel, world axes.
        velocity, turning: of the hub, and the wheel's rate of turning without its spin.
        depth_m: D, the depth of the furrow under the tread.

    Returns:
        as `flank_force`, of both together.
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


@law
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
    """Push of one side of the furrow on the flank that faces it.

        p = b / 2 - e . (hub - W)              e the axle, turned away from what pushes
        F = (k D p - c D dp/dt) (e - (e . s) s)        at W, never a pull

    W is the nearest point of the side's edge, half way up its depth D, and s the way it runs. The
    slice is loose: pressed deeper than SLICE_M it gives way, and at twice that the tyre is on it
    and nothing pushes back. The spring's part is the gradient of k D p**2 / 2.

    Args:
        field, wheel, hub, axle, velocity, turning, depth_m: as for `wall_force`.
        place_m: where the side is, to the furrow's side of the pass's line.
        outward: 1 for the wall, which pushes away from the line; -1 for the slice.

    Returns:
        force, moment about the hub, the spring's energy_j and what it grows by with D [J/m],
        power_w taken.
    """
    left, along = field_axis(field, Field.LEFT), field_axis(field, Field.AHEAD)
    to_side = field[Field.FURROW_SIDE] * field[Field.PASS_WAY]
    out = to_side * outward
    facing = rigid.scaled(out if rigid.dot(axle, left) >= 0.0 else -out, axle)
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
    if pressed <= 0.0 or (outward < 0.0 and pressed >= 2.0 * SLICE_M):
        return NOTHING
    spring, work = pressed, 0.5 * pressed * pressed
    if outward < 0.0 and pressed > SLICE_M:
        spring = 2.0 * SLICE_M - pressed
        work = SLICE_M * SLICE_M - 0.5 * spring * spring
    direction = rigid.minus(facing, rigid.scaled(rigid.dot(facing, along), along))
    moment = rigid.cross(arm, facing)
    leaving = rigid.dot(direction, velocity) + rigid.dot(moment, turning)
    stiffness = field[Field.WALL_STIFFNESS_NPM] * depth_m
    push = max(0.0, stiffness * spring - field[Field.WALL_DAMPING_NSPM] * depth_m * leaving)
    growth = field[Field.WALL_STIFFNESS_NPM] * work - 0.5 * stiffness * spring * rigid.dot(
        facing, normal
    )
    return (
        rigid.scaled(push, direction), rigid.scaled(push, moment), stiffness * work, growth,
        -push * leaving,
    )  # fmt: skip
