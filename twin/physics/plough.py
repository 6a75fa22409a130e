"""Soil forces on the bodies or tools of an implement, and on its depth wheel."""

from __future__ import annotations

import math

from twin.compute.compiled import law
from twin.physics import rigid
from twin.physics.block import Field, Plough, Soil
from twin.physics.ground import RIPPLE, ROCKS, node_value, random_field
from twin.physics.shapes import Array, Vector, Vector2

STARTING_MPS = 0.05
"""Speed below which the downward pull of the shares, and the depth wheel's drag, fade [m/s]."""
LANDSIDE_ANGLE = 0.03
"""Angle between motion and heading, towards the land, that doubles the landside force [rad];
assumed."""
LIFTED_S = 0.05
"""Time constant with which the soil springs back before a lifted share [s]."""
RIPPLE_PER_DEPTH = 0.75
"""Wave length of shear failure over the depth: 0.5 to 1 in the literature."""
MEDIUM, COARSE = 0.70, 0.45
"""F of a mould-board plough on medium and coarse soil (ASABE D497)."""
ROCK_CELL_M, ROCK_LENGTH_M = 10.0, 0.25
"""Length of the cells along a share's path, each with one rock or none; length of a rock."""


@law
def soil_factor(plough: Array, draft_scale: float) -> float:
    """Soil factor F of ASABE D497 for a kind of implement [-].

        F(1.00) = 1        F(0.70) = F_medium        F(0.45) = F_coarse

    The argument of F is `draft_scale`, the factor of a mould-board plough on the same soil. F is
    linear between these three, goes on linearly above 1.00, and is in proportion below 0.45.
    `plough` is the part of the parameter block (`Plough`).
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
    """Draft of one body or tool [N], ASABE D497.

        D = F (A + B S + C S**2) W T

    S is the speed in km/h, T the depth in cm, W the body's width in m, or 1 for a tool. F is
    `soil_factor` of `draft_scale`, the factor of a mould-board plough on this soil.
    """
    speed_kmh = 3.6 * speed_mps
    specific = plough[Plough.DRAFT_A] + plough[Plough.DRAFT_B] * speed_kmh
    specific += plough[Plough.DRAFT_C] * speed_kmh * speed_kmh
    scale = soil_factor(plough, draft_scale)
    return scale * specific * plough[Plough.DRAFT_WIDTH] * 100.0 * depth_m


@law
def draft_factor(field: Array, soil: Array, s_m: float, t_m: float, depth_m: float) -> float:
    """Ratio of the draft at a place to the mean draft: variable soil, periodic shear failure.

        max(0.1, 1 + cv f(s, t) + cv_ripple sqrt(2) sin(2 pi (s / lambda + phase(s, t))))

    f and phase are random fields; lambda is 0.75 of the depth.

    Args:
        field, soil: parts of the parameter block (`Field`, `Soil`).
        s_m, t_m: the place, ground axes.
        depth_m: depth of the share.
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
    """Extra draft while a share passes a rock [N]: F sin(pi x / l)**2, l the rock's length.

    A cell of the share's path has a rock with the probability of rocks per area x the cell's
    length x `width_m`.

    Args:
        field, soil: parts of the parameter block (`Field`, `Soil`).
        s_m, t_m: the share's place, ground axes.
        share: number of the share.
        width_m: width of one body.
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
    """Compression x of the soil before a body at the end of a step, in the ground plane [m].

        dx/dt = v - |v| k x / D        so that k |x| = D after a distance of some D / k

    Soil is a spring until it fails at the draft D: a standing plough sticks, and one that starts
    reaches its draft over a centimetre or two. The step is implicit, so it is stable for any dt.

    Args:
        stiffness_npm: k.
        draft: D, draft of this body at this place and time [N].
        pressed: x at the start of the step, ahead and towards the land.
        velocity: v of the body, in the same directions.
        dt_s: time step.

    Returns:
        x ahead and towards the land.
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
    """Soil force on one body, from the compression of the soil before it by `soil_before`.

        F_ahead = -k x        F_land = -k y - S clip(drift / angle, -1, 2)
        S       = r_s k max(x, 0)
        F_up    = -r_v k max(x, 0) V / sqrt(V**2 + (r_v v_up)**2 + v_0**2)

    with drift = k y / D, which is v_land / v_ahead in steady motion, V = sqrt(v_ahead**2 +
    v_land**2), k the soil's stiffness, angle = LANDSIDE_ANGLE and v_0 = STARTING_MPS. Draft opposes
    the motion; the landside's friction is a part of it. The mould-board pushes towards the land
    with S, the landside away from it with N = S (1 + drift / angle), between 0 and 3 S. The
    downward force takes no more power than the draft, so the body never gains energy.

    Args:
        plough: part of the parameter block (`Plough`).
        draft: D, draft of this body at this place and time [N].
        ratios: r_v and r_s, vertical force over draft and side force over draft.
        pressed: x and y, ahead and towards the land [m].
        velocity: v_ahead, v_land, v_up of the point where the force acts [m/s].

    Returns:
        force ahead, towards the land, up [N]; landside_n (N).
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
    """Force of the ground on the depth wheel: spring and damper, and rolling resistance.

        N = max(0, |spring| - c v . n)        F = N n
        drag = -rho N v_n / sqrt(|v_n|**2 + v_0**2)        v_n = v - (v . n) n

    with the damping c and the resistance ratio rho of `plough`; v_0 is STARTING_MPS. All is 0 off
    the ground.

    Args:
        plough: part of the parameter block (`Plough`).
        spring: force of the tyre's spring [N], world axes.
        velocity: v of the hub [m/s], world axes.
        normal: n, unit vector along `spring`.

    Returns:
        F and drag [N], world axes; load_n (N).
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
