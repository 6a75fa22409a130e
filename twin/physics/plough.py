"""Soil forces on the bodies or tools of an implement, and on its depth wheel."""

from __future__ import annotations

import math

from twin.compute.compiled import law
from twin.physics import rigid
from twin.physics.block import Field, Plough, Soil
from twin.physics.ground import RIPPLE, ROCKS, node_value, random_field
from twin.physics.shapes import Array, Vector, Vector2

STARTING_MPS = 0.05
"""Speed below which suction, and the drag of the depth wheel, fade [m/s]."""
LANDSIDE_ANGLE = 0.03
"""Drift towards the land at which the landside force has doubled [rad]; assumed."""
LIFTED_S = 0.05
"""Time in which the soil before a lifted share is let go [s]."""
RIPPLE_PER_DEPTH = 0.75
"""Wave length of shear failure over the depth: 0.5 to 1 in the literature."""
MEDIUM, COARSE = 0.70, 0.45
"""F of a mould-board plough on medium and coarse soil (ASABE D497)."""
ROCK_CELL_M, ROCK_LENGTH_M = 10.0, 0.25
"""A share's path is divided into cells that hold a rock or none; how long it takes to pass one."""


@law
def soil_factor(plough: Array, draft_scale: float) -> float:
    """F of ASABE D497 for a kind of implement, from the mould-board plough's on the same soil.

        F(1.00) = 1        F(0.70) = F_medium        F(0.45) = F_coarse

    Linear between the soils, and on above the first; in proportion below the last.
    """
    medium, coarse = plough[Plough.FACTOR_MEDIUM], plough[Plough.FACTOR_COARSE]
    if medium == MEDIUM and coarse == COARSE:
        return draft_scale
    if draft_scale >= MEDIUM:
        return medium + (1.0 - medium) * (draft_scale - MEDIUM) / (1.0 - MEDIUM)
    if draft_scale >= COARSE:
        return coarse + (medium - coarse) * (draft_scale - COARSE) / (MEDIUM - COARSE)
    return coarse * draft_scale / COARSE


@law
def draft_n(plough: Array, draft_scale: float, depth_m: float, speed_mps: float) -> float:
    """Draft of one body or tool.

        D = F (A + B S + C S**2) W T      S in km/h, T in cm; W its width in m, or 1 for a tool

    ASABE D497. F is that of the implement's kind on a soil whose F for a mould-board plough is
    draft_scale.
    """
    speed_kmh = 3.6 * speed_mps
    specific = plough[Plough.DRAFT_A] + plough[Plough.DRAFT_B] * speed_kmh
    specific += plough[Plough.DRAFT_C] * speed_kmh * speed_kmh
    scale = soil_factor(plough, draft_scale)
    return scale * specific * plough[Plough.DRAFT_WIDTH] * 100.0 * depth_m


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
def rock_n(field: Array, soil: Array, s_m: float, t_m: float, share: int, width_m: float) -> float:
    """Extra draft of a rock in a share's way: F sin(pi x / l)**2 while it passes.

    Rocks lie in cells of the share's lane, in each with the probability of its area: its length
    times the width of the body.
    """
    density = soil[Soil.ROCKS_PER_M2]
    if density <= 0.0:
        return 0.0
    s = s_m + field[Field.ORIGIN_S_M]
    cell = math.floor(s / ROCK_CELL_M)
    lane = 10 * math.floor(field[Field.ORIGIN_T_M] + field[Field.PASS_T_M]) + share
    seed = field[Field.SEED] + ROCKS
    chance = 0.5 + node_value(seed, int(cell), lane) / math.sqrt(12.0)
    if chance >= density * ROCK_CELL_M * width_m:
        return 0.0
    where = 0.5 + node_value(seed + 1, int(cell), lane) / math.sqrt(12.0)
    start = (cell + 0.9 * where) * ROCK_CELL_M
    x = (s - start) / ROCK_LENGTH_M
    if x <= 0.0 or x >= 1.0:
        return 0.0
    return soil[Soil.ROCK_N] * math.sin(math.pi * x) ** 2


@law
def soil_before(
    stiffness_npm: float, draft: float, pressed: Vector2, velocity: Vector2, dt_s: float
) -> Vector2:
    """How far a body has pressed the soil before it, at the end of a step; in the ground plane [m].

        dx/dt = v - |v| k x / D        so that k |x| = D while it moves, after a way of D / k

    Soil is a spring until it fails at the draft D: a standing plough sticks, and one that starts
    finds its draft over a centimetre or two. Taken at the end of the step (implicit), which is
    stable at any step.

    Args:
        stiffness_npm: k.
        draft: D of this body here and now [N].
        pressed: x at the start of the step, ahead and towards the land.
        velocity: v of the body, in the same directions.
        dt_s: the step.
    """
    speed = math.sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1])
    if draft <= 0.0:
        return (0.0, 0.0)
    left = 1.0 / (1.0 + dt_s * speed * stiffness_npm / draft)
    return (pressed[0] + dt_s * velocity[0]) * left, (pressed[1] + dt_s * velocity[1]) * left


@law
def share_force(
    plough: Array, draft: float, ratios: Vector2, pressed: Vector2, velocity: Vector
) -> tuple[Vector, float]:
    """Soil force on one body, from how far it has pressed the soil before it.

        F_ahead = -k x        F_land = -k y - S clip(drift / angle, -1, 2)
        S       = r_s k max(x, 0)
        F_up    = -r_v k max(x, 0) V / sqrt(V**2 + (r_v v_up)**2 + v_0**2)

    with drift = k y / D, which is v_land / v_ahead while it moves. Draft opposes the motion (the
    landside's friction is a part of it); the mould-board pushes towards the land with S, against it
    the landside with N = S (1 + drift / angle), between 0 and 3 S. The share draws itself down no
    faster than it goes ahead, so that it takes energy however it moves.

    Args:
        plough: its part of the block.
        draft: D of this body here and now [N].
        ratios: r_v and r_s, of the vertical and the side force over the draft.
        pressed: x and y, ahead and towards the land [m].
        velocity: of the point where the force acts: ahead, towards the land, up.

    Returns:
        force (ahead, towards the land, up), landside_n.
    """
    stiffness = plough[Plough.SOIL_STIFFNESS_NPM]
    if draft <= 0.0:
        return (0.0, 0.0, 0.0), 0.0
    cutting = stiffness * max(pressed[0], 0.0)
    ratio, side = ratios[0], ratios[1] * cutting
    drift = stiffness * pressed[1] / draft
    landside = side * min(3.0, max(0.0, 1.0 + drift / LANDSIDE_ANGLE))
    square = velocity[0] * velocity[0] + velocity[1] * velocity[1]
    rising = ratio * velocity[2]
    drawn = math.sqrt(square / (square + rising * rising + STARTING_MPS * STARTING_MPS))
    force = (
        -stiffness * pressed[0],
        -stiffness * pressed[1] + side - landside,
        -ratio * cutting * drawn,
    )
    return force, landside


@law
def depth_wheel_force(
    plough: Array, spring: Vector, velocity: Vector, normal: Vector
) -> tuple[Vector, Vector, float]:
    """Force on the depth wheel: its spring with a damper, and rolling resistance against its motion

    Args:
        plough: its part of the block.
        spring: force of its tyre's spring.
        velocity: of the hub; world axes.
        normal: unit vector along the spring's force.

    Returns:
        spring and damper, drag (world axes, tuples), load_n.
    """
    pushed = math.sqrt(rigid.dot(spring, spring))
    rising = rigid.dot(velocity, normal)
    load = pushed - plough[Plough.WHEEL_DAMPING_NSPM] * rising
    if pushed <= 0.0 or load <= 0.0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    sliding = rigid.minus(velocity, rigid.scaled(rising, normal))
    speed = math.sqrt(rigid.dot(sliding, sliding) + STARTING_MPS * STARTING_MPS)
    drag = -plough[Plough.WHEEL_RESISTANCE_RATIO] * load / speed
    return rigid.scaled(load, normal), rigid.scaled(drag, sliding), load
