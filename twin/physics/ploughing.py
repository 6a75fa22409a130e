"""Soil forces on an implement's bodies and depth wheel, added to MuJoCo's passive forces.

Arguments: `parameters` is the parameter block, `root` the implement's root body, `xpos`, `xmat`,
`cvel`, `com` (subtree_com), `cdof`, `act`, `passive` (qfrc_passive) are fields of mjData, `nodes`
is the model's hfield_data, `slots` and `powers` are the numbers by `MachineSlot` and `PowerSlot`,
and `rates` the rates of `act`.
"""

from __future__ import annotations

import math

from twin.compute.compiled import law
from twin.physics import block, rigid
from twin.physics.block import Envelope, Field, Head, MachineSlot, Plough, PowerSlot, Soil
from twin.physics.contact import felt_height
from twin.physics.ground import draft_scale, field_axis, on_ground, on_map, soil_at
from twin.physics.implement_laws import D497, implement_forces
from twin.physics.plough import (
    LIFTED_S,
    depth_wheel_force,
    draft_factor,
    draft_n,
    rock_n,
    share_force,
    soil_before,
)
from twin.physics.shapes import Array, Integers, Vector

FIELD, SOIL, WHEEL, PLOUGH = block.FIELD, block.SOIL, block.WHEEL, block.PLOUGH


@law
def roll_depth_wheel(
    parameters: Array,
    root: int,
    xpos: Array,
    xmat: Array,
    cvel: Array,
    com: Array,
    slots: Array,
    powers: Array,
    nodes: Array,
) -> tuple[Vector, Vector, Vector]:
    """Force of the ground on the plough's depth wheel; adds its energy and powers.

    The wheel is taken as upright on the ground, however the plough leans.

    Returns:
        force with drag [N], its moment about subtree_com of `root` [N m], drag [N]; world axes.
    """
    field, plough = parameters[FIELD:SOIL], parameters[PLOUGH:]
    wheel, frame = int(parameters[Head.DEPTH_WHEEL_BODY]), int(parameters[Head.PLOUGH_BODY])
    hub, normal = rigid.row3(xpos, wheel), field_axis(field, Field.NORMAL)
    across = rigid.axis(xmat, frame, 1)
    axle = rigid.unit(rigid.minus(across, rigid.scaled(rigid.dot(across, normal), normal)))
    height, slope_s, slope_t, _ = felt_height(
        field, nodes, Envelope.DEPTH_WHEEL, hub, rigid.cross(axle, normal)
    )
    overlap = height + plough[Plough.WHEEL_RADIUS_M] - rigid.dot(hub, normal)
    spring, energy = (0.0, 0.0, 0.0), 0.0
    if overlap > 0.0:
        press = plough[Plough.WHEEL_STIFFNESS_NPM] * overlap
        energy = 0.5 * press * overlap
        spring = rigid.plus(
            rigid.scaled(press, normal),
            rigid.plus(
                rigid.scaled(-press * slope_s, field_axis(field, Field.AHEAD)),
                rigid.scaled(-press * slope_t, field_axis(field, Field.LEFT)),
            ),
        )
    pushed = math.sqrt(rigid.dot(spring, spring))
    if pushed > 0.0:
        normal = rigid.scaled(1.0 / pushed, spring)
    velocity = rigid.point_velocity(cvel, com, wheel, root, hub)
    pressing, drag, load = depth_wheel_force(plough, spring, velocity, normal)
    total = rigid.plus(pressing, drag)
    powers[PowerSlot.DEPTH_WHEEL] = -rigid.dot(pressing, velocity)
    powers[PowerSlot.DRAWBAR] -= rigid.dot(drag, velocity)
    slots[MachineSlot.DEPTH_WHEEL_N] = load
    slots[MachineSlot.ELASTIC_J] += energy
    return total, rigid.cross(rigid.minus(hub, rigid.row3(com, root)), total), drag


@law
def pull_plough(
    parameters: Array,
    root: int,
    dof: int,
    xpos: Array,
    xmat: Array,
    cvel: Array,
    com: Array,
    cdof: Array,
    parent: Integers,
    passive: Array,
    act: Array,
    dt_s: float,
    rates: Array,
    slots: Array,
    powers: Array,
    here: Array,
    nodes: Array,
) -> None:
    """Add the soil forces on the plough's bodies and its depth wheel to `passive`; write the slots.

    D497's draft includes the drag of the depth wheel, so that drag is subtracted from the draft of
    the bodies. `dof` is the last degree of freedom that moves the implement, `parent` the model's
    dof_parentid, and `here` room for the soil at one place, overwritten.
    """
    field, soil = parameters[FIELD:SOIL], parameters[SOIL:WHEEL]
    plough, frame = parameters[PLOUGH:], int(parameters[Head.PLOUGH_BODY])
    normal, centre = field_axis(field, Field.NORMAL), rigid.row3(com, root)
    left = rigid.axis(xmat, frame, 1)
    left = rigid.unit(rigid.minus(left, rigid.scaled(rigid.dot(left, normal), normal)))
    ahead = rigid.cross(left, normal)
    land = rigid.scaled(1.0 if field[Field.FURROW_SIDE] <= 0.0 else -1.0, left)
    bodies = int(plough[Plough.BODIES])
    own_ratios = plough[Plough.VERTICAL_RATIO], plough[Plough.SIDE_RATIO]
    total, moment, drag = roll_depth_wheel(
        parameters, root, xpos, xmat, cvel, com, slots, powers, nodes
    )
    relief = max(0.0, -rigid.dot(drag, ahead)) / bodies

    depth_sum = landside_sum = 0.0
    per_step = 1.0 / dt_s
    for i in range(bodies):
        at, pressed = Plough.SHARES + 3 * i, int(plough[Plough.SOIL]) + 2 * i
        tip = rigid.to_world(xpos, xmat, frame, (plough[at], plough[at + 1], plough[at + 2]))
        s, t, above = on_ground(field, tip)
        above -= on_map(field, Field.HEIGHTS, nodes, s, t)[0]
        if above >= 0.0:
            rates[pressed], rates[pressed + 1] = (
                -act[pressed] / LIFTED_S, -act[pressed + 1] / LIFTED_S
            )  # fmt: skip
            continue
        up = -above * (1.0 - plough[Plough.FORCE_DEPTH_RATIO])
        point = rigid.plus(tip, rigid.scaled(up, normal))
        velocity = rigid.point_velocity(cvel, com, frame, root, point)
        moving = (
            rigid.dot(velocity, ahead), rigid.dot(velocity, land), rigid.dot(velocity, normal)
        )  # fmt: skip
        scale = draft_scale(field, soil, nodes, s, t)
        speed, ratios = math.sqrt(rigid.dot(velocity, velocity)), own_ratios
        if plough[Plough.LAW] == D497:
            draft = draft_n(plough, scale, -above, speed)
        else:
            drift = math.atan2(moving[1], abs(moving[0]))
            soil_at(field, soil, nodes, s, t, here)
            here[Soil.DRAFT_SCALE] = scale
            own = implement_forces(plough, here, float(i), -above, speed, drift)
            draft, ratios = own[0], (own[1], own[2])
        draft *= draft_factor(field, soil, s, t, -above)
        draft -= relief
        if draft < 0.0:
            draft = 0.0
        draft += rock_n(field, soil, s, t, i, plough[Plough.BODY_WIDTH_M])
        before = soil_before(
            plough[Plough.SOIL_STIFFNESS_NPM], draft, (act[pressed], act[pressed + 1]),
            (moving[0], moving[1]), dt_s,
        )  # fmt: skip
        rates[pressed] = (before[0] - act[pressed]) * per_step
        rates[pressed + 1] = (before[1] - act[pressed + 1]) * per_step
        pull, landside = share_force(plough, draft, ratios, before, moving)
        force = rigid.plus(
            rigid.scaled(pull[0], ahead),
            rigid.plus(rigid.scaled(pull[1], land), rigid.scaled(pull[2], normal)),
        )
        total = rigid.plus(total, force)
        moment = rigid.plus(moment, rigid.cross(rigid.minus(point, centre), force))
        powers[PowerSlot.DRAWBAR] -= rigid.dot(force, velocity)
        landside_sum += landside
        square = before[0] * before[0] + before[1] * before[1]
        slots[MachineSlot.ELASTIC_J] += 0.5 * plough[Plough.SOIL_STIFFNESS_NPM] * square
        depth_sum -= above
    rigid.push(passive, cdof, parent, dof, com, root, centre, total, moment)
    slots[MachineSlot.DRAFT_X_N], slots[MachineSlot.DRAFT_Y_N], slots[MachineSlot.DRAFT_Z_N] = total
    slots[MachineSlot.DRAFT_N] = -rigid.dot(total, ahead)
    slots[MachineSlot.SIDE_N] = rigid.dot(total, left)
    slots[MachineSlot.LANDSIDE_N] = landside_sum
    slots[MachineSlot.DEPTH_M] = depth_sum / bodies
