"""Soil forces on a mould-board plough and its depth wheel."""

from __future__ import annotations

import math

from twin.compiled import law
from twin.physics import rigid
from twin.physics.block import Field, Plough, Soil
from twin.physics.ground import RIPPLE, ROCKS, node_value, random_field
from twin.physics.shapes import Array, Vector

STARTING_MPS = 0.05
"""Speed below which the draft of a standing plough fades, and turns viscous [m/s]."""
LANDSIDE_ANGLE = 0.03
"""Drift towards the land at which the landside force has doubled [rad]; assumed."""
DRIFT_MPS = 0.3
"""Slowest speed at which the drift is measured [m/s]: a standing landside must not be stiff."""
RIPPLE_PER_DEPTH = 0.75
"""Wave length of shear failure over the depth: 0.5 to 1 in the literature."""
ROCK_CELL_M, ROCK_LENGTH_M = 10.0, 0.25
"""A share's path is divided into cells that hold a rock or none; how long it takes to pass one."""


@law
def draft_n(plough: Array, draft_scale: float, depth_m: float, speed_mps: float) -> float:
    """Draft of one plough body.

        D = F (A + C S**2) w T        S in km/h, w in m, T in cm; F is draft_scale

    ASABE D497, mould-board plough (A 652, B 0, C 5.1).
    """
    speed_kmh = 3.6 * speed_mps
    specific = plough[Plough.DRAFT_A] + plough[Plough.DRAFT_C] * speed_kmh * speed_kmh
    return draft_scale * specific * plough[Plough.BODY_WIDTH_M] * 100.0 * depth_m


@law
def draft_factor(field: Array, soil: Array, s_m: float, t_m: float, depth_m: float) -> float:
    """Draft at a place over the mean draft: soil that differs, and shear failure that ripples.

    1 + cv f(s, t) + cv_ripple sqrt(2) sin(2 pi (s / lambda + phase(s, t)))
    """
    seed = field[Field.SEED]
    s, t = s_m + field[Field.ORIGIN_S_M], t_m + field[Field.ORIGIN_T_M]
    factor = 1.0 + soil[Soil.DRAFT_CV] * random_field(seed, s, t, soil[Soil.DRAFT_LENGTH_M])
    ripple = soil[Soil.RIPPLE_CV]
    if ripple > 0.0:
        wave_m = RIPPLE_PER_DEPTH * max(depth_m, 0.05)
        phase = 0.5 * random_field(seed + RIPPLE, s, t, 4.0 * wave_m)
        factor += ripple * math.sqrt(2.0) * math.sin(2.0 * math.pi * (s / wave_m + phase))
    return max(0.1, factor)


@law
def rock_n(field: Array, soil: Array, s_m: float, t_m: float, share: int) -> float:
    """Extra draft of a rock in a share's way: F sin(pi x / l)**2 while it passes.

    Rocks lie in cells of the share's lane, in each with the probability of its area.
    """
    density = soil[Soil.ROCKS_PER_M2]
    if density <= 0.0:
        return 0.0
    s = s_m + field[Field.ORIGIN_S_M]
    cell = math.floor(s / ROCK_CELL_M)
    lane = 10 * math.floor(field[Field.ORIGIN_T_M] + field[Field.PASS_T_M]) + share
    seed = field[Field.SEED] + ROCKS
    chance = 0.5 + node_value(seed, int(cell), lane) / math.sqrt(12.0)
    if chance >= density * ROCK_CELL_M * 0.35:
        return 0.0
    where = 0.5 + node_value(seed + 1, int(cell), lane) / math.sqrt(12.0)
    start = (cell + 0.9 * where) * ROCK_CELL_M
    x = (s - start) / ROCK_LENGTH_M
    if x <= 0.0 or x >= 1.0:
        return 0.0
    return soil[Soil.ROCK_N] * math.sin(math.pi * x) ** 2


@law
def share_force(
    plough: Array,
    draft: float,
    velocity: Vector,
    normal: Vector,
    land: Vector,
) -> tuple[Vector, float]:
    """Soil force on one share.

    Draft against the motion in the ground plane (the landside's friction is a part of it), a part
    V = r_v D downwards, and sideways the mould-board's S = r_s D towards the land, against it the
    landside

        N = S (1 + drift / angle)   between 0 and 3 S

    Args:
        plough: its part of the block.
        draft: D of this body here and now [N].
        velocity: of its tip, world axes.
        normal: of the ground.
        land: unit vector in the ground plane towards the unploughed land.

    Returns:
        force (world axes, tuple), landside_n.
    """
    sliding = rigid.minus(velocity, rigid.scaled(rigid.dot(velocity, normal), normal))
    speed = math.sqrt(rigid.dot(sliding, sliding))
    moving = math.sqrt(speed * speed + STARTING_MPS * STARTING_MPS)
    fading = speed / moving
    side = plough[Plough.SIDE_RATIO] * draft * fading
    drift = rigid.dot(sliding, land) / max(speed, DRIFT_MPS)
    landside = side * min(3.0, max(0.0, 1.0 + drift / LANDSIDE_ANGLE))
    force = rigid.plus(
        rigid.scaled(-draft / moving, sliding),
        rigid.plus(
            rigid.scaled(-plough[Plough.VERTICAL_RATIO] * draft * fading, normal),
            rigid.scaled(side - landside, land),
        ),
    )
    return force, landside


@law
def depth_wheel_force(
    plough: Array, above_m: float, velocity: Vector, normal: Vector
) -> tuple[Vector, Vector, float]:
    """Ground force on the depth wheel: a damped spring, and rolling resistance against its motion.

    Args:
        plough: its part of the block.
        above_m: height of the wheel's hub above the ground.
        velocity, normal: of the hub, and of the ground; world axes.

    Returns:
        spring force, drag (world axes, tuples), load_n.
    """
    deflection = plough[Plough.WHEEL_RADIUS_M] - above_m
    rising = rigid.dot(velocity, normal)
    load = (
        plough[Plough.WHEEL_STIFFNESS_NPM] * deflection - plough[Plough.WHEEL_DAMPING_NSPM] * rising
    )
    if deflection <= 0.0 or load <= 0.0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    sliding = rigid.minus(velocity, rigid.scaled(rising, normal))
    speed = math.sqrt(rigid.dot(sliding, sliding) + STARTING_MPS * STARTING_MPS)
    drag = -plough[Plough.WHEEL_RESISTANCE_RATIO] * load / speed
    return rigid.scaled(load, normal), rigid.scaled(drag, sliding), load
