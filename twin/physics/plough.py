"""Soil forces on a mould-board plough and its depth wheel."""

from __future__ import annotations

import math

from twin.physics import rigid
from twin.physics.block import Head, Plough, Soil
from twin.physics.compiled import law
from twin.physics.ground import random_field
from twin.physics.shapes import Array, Vector

STARTING_MPS = 0.05
"""Speed below which the draft of a standing plough fades, and turns viscous [m/s]."""
LANDSIDE_ANGLE = 0.05
"""Drift at which the landside bears fully [rad]; assumed."""


@law
def draft_n(plough: Array, soil: Array, depth_m: float, speed_mps: float) -> float:
    """Draft of one plough body.

        D = F (A + C S**2) w T        S in km/h, w in m, T in cm; F is soil.draft_scale

    ASABE D497, mould-board plough (A 652, B 0, C 5.1).
    """
    speed_kmh = 3.6 * speed_mps
    specific = plough[Plough.DRAFT_A] + plough[Plough.DRAFT_C] * speed_kmh * speed_kmh
    return soil[Soil.DRAFT_SCALE] * specific * plough[Plough.BODY_WIDTH_M] * 100.0 * depth_m


@law
def share_force(
    head: Array,
    soil: Array,
    plough: Array,
    tip: Vector,
    velocity: Vector,
    normal: Vector,
    side_axis: Vector,
) -> tuple[Vector, float]:
    """Soil force on one share, and its depth.

    Draft against its motion in the ground plane, varied by place; a downward part V = r D; a
    landside force against sideways drift, up to a share of D.

    Args:
        tip, velocity: of the share's tip, world axes.
        normal: of the ground; side_axis: the plough's left, world axes.

    Returns:
        force (world axes, tuple), depth_m.
    """
    depth = -rigid.dot(tip, normal)
    if depth <= 0.0:
        return (0.0, 0.0, 0.0), 0.0
    sliding = rigid.minus(velocity, rigid.scaled(rigid.dot(velocity, normal), normal))
    speed = math.sqrt(rigid.dot(sliding, sliding))
    draft = draft_n(plough, soil, depth, speed)
    x, y = tip[0] + head[Head.ORIGIN_X_M], tip[1] + head[Head.ORIGIN_Y_M]
    cv = soil[Soil.DRAFT_CV]
    if cv > 0.0:
        draft *= max(0.1, 1.0 + cv * random_field(head[Head.SEED], x, y, soil[Soil.DRAFT_LENGTH_M]))
    moving = math.sqrt(speed * speed + STARTING_MPS * STARTING_MPS)
    drift = rigid.dot(sliding, side_axis) / moving
    landside = plough[Plough.LANDSIDE_RATIO] * draft * math.tanh(drift / LANDSIDE_ANGLE)
    force = rigid.plus(
        rigid.scaled(-draft / moving, sliding),
        rigid.plus(
            rigid.scaled(-plough[Plough.VERTICAL_RATIO] * draft * speed / moving, normal),
            rigid.scaled(-landside, side_axis),
        ),
    )
    return force, depth


@law
def depth_wheel_force(
    plough: Array, hub: Vector, velocity: Vector, normal: Vector
) -> tuple[Vector, float]:
    """Ground force on the depth wheel: a damped spring, and rolling resistance against its motion.

    Returns:
        force (world axes, tuple), load_n.
    """
    deflection = plough[Plough.WHEEL_RADIUS_M] - rigid.dot(hub, normal)
    rising = rigid.dot(velocity, normal)
    load = (
        plough[Plough.WHEEL_STIFFNESS_NPM] * deflection - plough[Plough.WHEEL_DAMPING_NSPM] * rising
    )
    if deflection <= 0.0 or load <= 0.0:
        return (0.0, 0.0, 0.0), 0.0
    sliding = rigid.minus(velocity, rigid.scaled(rising, normal))
    speed = math.sqrt(rigid.dot(sliding, sliding) + STARTING_MPS * STARTING_MPS)
    drag = -plough[Plough.WHEEL_RESISTANCE_RATIO] * load / speed
    return rigid.plus(rigid.scaled(load, normal), rigid.scaled(drag, sliding)), load
