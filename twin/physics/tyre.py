"""One wheel on the ground: vertical spring, relaxing deflections, and the soil law's forces."""

from __future__ import annotations

import math

from twin.compiled import law
from twin.physics import rigid
from twin.physics.block import Field, PowerSlot, Soil, Wheel, WheelSlot
from twin.physics.ground import beside_pass, field_axis, furrow, on_ground, soil_at, surface
from twin.physics.laws import soil_forces
from twin.physics.shapes import Array, Vector

SIGN_SPEED_MPS = 0.03
"""Speed over which motion resistance changes sign [m/s].

1 % slip at ploughing speed is about half.
"""
RADIUS_PER_DEFLECTION = 1.0 / 3.0
"""Loss of rolling radius per deflection; a bias tyre's circumference shortens by a third of it."""
LIFTED_S = 0.05
"""Time in which the deflections of a lifted wheel vanish [s]."""

SLICE_M = 0.15
"""How deep a tyre can press into the turned slice before it rides up on it [m]; assumed."""
LEAST_UPRIGHT_SQUARED = 1e-4
"""Of a wheel that lies on its side, whose tread has no place on the ground."""


@law
def smooth_sign(speed: float, width: float) -> float:
    """speed / sqrt(speed**2 + width**2)"""
    return speed / math.sqrt(speed * speed + width * width)


@law
def relaxed_shear(
    soil: Array,
    wheel: Array,
    load_n: float,
    spin_mps: float,
    roll_mps: float,
    side_mps: float,
    u_x: float,
    u_y: float,
    dt_s: float,
) -> tuple[float, float, float, float, float, float, float]:
    """Forces of a tyre whose contact patch lags by its deflections u, and the deflections' rates.

        du/dt = v_slip - V u / L        V = max(|w R|, |v_x|, |v_y|)
        slip of the patch = u / L       F = law(u / L) + (tau N / L) du/dt

    In steady state u / L is the slip of the law's own definition; at rest u is a spring, so a
    parked wheel sticks. The force is taken at the end of the step (u + dt du/dt), which keeps the
    pair velocity-deflection from gaining energy. The damper takes |F| no further than N mu, or than
    the law's own force where that is more. The law is asked for a wheel that rolls forwards; one
    that rolls backwards has its forces turned round.

    Returns:
        shear_x_n, shear_y_n, resistance_n, rolling_moment_n, sinkage_m, rate_x, rate_y [m/s].
    """
    long_m, lat_m = wheel[Wheel.RELAXATION_LONG_M], wheel[Wheel.RELAXATION_LAT_M]
    travel = max(abs(spin_mps), abs(roll_mps), abs(side_mps))
    rate_x = (spin_mps - roll_mps) - travel * u_x / long_m
    rate_y = -side_mps - travel * u_y / lat_m
    slip, side_slip = (u_x + dt_s * rate_x) / long_m, (u_y + dt_s * rate_y) / lat_m
    way = 1.0 if spin_mps + roll_mps >= 0.0 else -1.0
    x, y, resistance, rolling, sinkage = soil_forces(soil, wheel, load_n, way * slip, side_slip)
    x *= way
    ceiling = max(load_n * soil[Soil.FRICTION], math.sqrt(x * x + y * y))
    damping = load_n * wheel[Wheel.SHEAR_DAMPING_S]
    x += damping / long_m * rate_x
    y += damping * wheel[Wheel.LATERAL_RATIO] / lat_m * rate_y
    size = math.sqrt(x * x + y * y)
    if size > ceiling:
        x, y = x * ceiling / size, y * ceiling / size
    return x, y, resistance, rolling, sinkage, rate_x, rate_y


@law
def wall_force(field: Array, wheel: Array, s_m: float, t_m: float, side_mps: float) -> float:
    """Force to the left of the furrow's wall, and of the turned slice beyond, on a tyre's flanks.

    F = k penetration - c v_y, on the flank that touches, never a pull. The slice is loose: pressed
    deeper than SLICE_M it gives way, and at twice that the tyre is on it and nothing pushes back.

    Args:
        field, wheel: parts of the block.
        s_m, t_m: place of the wheel's centre on the ground.
        side_mps: its speed to the left.
    """
    depth = -furrow(field, s_m, t_m)[0]
    if depth <= 0.0:
        return 0.0
    side, half = field[Field.FURROW_SIDE], 0.5 * wheel[Wheel.WIDTH_M]
    stiffness = field[Field.WALL_STIFFNESS_NPM] * depth
    damping = field[Field.WALL_DAMPING_NSPM] * depth
    place, edge = side * beside_pass(field, t_m), field[Field.FURROW_EDGE_M]
    outward = side * side_mps
    at_wall = edge - (place - half)
    at_slice = place + half - (edge + field[Field.FURROW_WIDTH_M])
    if at_wall > 0.0:
        return side * max(0.0, stiffness * at_wall - damping * outward)
    pressed = min(at_slice, 2.0 * SLICE_M - at_slice)
    if pressed > 0.0:
        return -side * max(0.0, stiffness * pressed + damping * outward)
    return 0.0


@law
def contact_shift_m(wheel: Array, camber_tangent: float, deflection_m: float) -> float:
    """How far the load's centre moves along the axle of a leaning tyre, positive to the left.

        e = -tan(gamma) b**2 / (12 delta)     within a quarter of the width

    The centre of a pressure that grows linearly across the tread, towards the lower end of the
    axle; tan(gamma) is positive with its left end raised.
    """
    width = wheel[Wheel.WIDTH_M]
    shift = -camber_tangent * width * width / (12.0 * deflection_m)
    return min(max(shift, -0.25 * width), 0.25 * width)


@law
def tread_point(wheel: Array, hub: Vector, axle: Vector, normal: Vector) -> Vector:
    """The lowest point of the middle of the tread: where a leaning wheel meets the ground.

    p = hub - r u        u = the normal's part across the axle, made a unit
    """
    up = rigid.minus(normal, rigid.scaled(rigid.dot(axle, normal), axle))
    square = max(rigid.dot(up, up), LEAST_UPRIGHT_SQUARED)
    return rigid.minus(hub, rigid.scaled(0.5 * wheel[Wheel.DIAMETER_M] / math.sqrt(square), up))


@law
def roll_wheel(
    field: Array,
    soil: Array,
    wheel: Array,
    xpos: Array,
    xmat: Array,
    cvel: Array,
    com: Array,
    root: int,
    act: Array,
    dt_s: float,
    slots: Array,
    rates: Array,
    powers: Array,
    here: Array,
    nodes: Array,
) -> tuple[Vector, Vector]:
    """Force and torque of the ground on one wheel, at its hub; fills its slots, rates and powers.

    Returns:
        force, torque: world axes, tuples; zero for a lifted wheel.
    """
    body, tyre = int(wheel[Wheel.BODY]), int(wheel[Wheel.TYRE])
    hub, axle = rigid.row3(xpos, body), rigid.axis(xmat, body, 1)
    normal = field_axis(field, Field.NORMAL)
    above = rigid.dot(hub, normal)
    s, t, _ = on_ground(field, tread_point(wheel, hub, axle, normal))
    height, slope_s, slope_t = surface(field, nodes, s, t)
    steepness = 1.0
    if slope_s != 0.0 or slope_t != 0.0:
        downhill = rigid.plus(
            rigid.scaled(slope_s, field_axis(field, Field.AHEAD)),
            rigid.scaled(slope_t, field_axis(field, Field.LEFT)),
        )
        normal = rigid.unit(rigid.minus(normal, downhill))
        steepness = 1.0 / math.sqrt(1.0 + slope_s * slope_s + slope_t * slope_t)
    ahead = rigid.unit(rigid.cross(axle, normal))
    left = rigid.cross(normal, ahead)
    velocity = rigid.point_velocity(cvel, com, body, root, hub)
    roll, side = rigid.dot(velocity, ahead), rigid.dot(velocity, left)
    rising = rigid.dot(velocity, normal)
    rate = rigid.dot(rigid.angular_velocity(cvel, body), axle)
    camber = rigid.dot(axle, normal)  # sine: the left end of the axle raised
    upright = math.sqrt(max(1.0 - camber * camber, LEAST_UPRIGHT_SQUARED))
    over = max(above - height, 0.0)  # a hub in the ground presses its whole radius, not more
    deflection = 0.5 * wheel[Wheel.DIAMETER_M] - over * steepness / upright
    load = wheel[Wheel.STIFFNESS_NPM] * deflection - wheel[Wheel.DAMPING_NSPM] * rising
    u_x, u_y = act[tyre], act[tyre + 1]
    slots[:] = 0.0
    slots[WheelSlot.RATE_RADPS] = rate
    slots[WheelSlot.SPEED_X_MPS], slots[WheelSlot.SPEED_Y_MPS] = roll, side
    radius = wheel[Wheel.FREE_ROLLING_RADIUS_M] - RADIUS_PER_DEFLECTION * max(deflection, 0.0)
    slots[WheelSlot.ROLLING_RADIUS_M] = radius
    spin = rate * radius
    slots[WheelSlot.SLIP] = (spin - roll) / max(abs(spin), abs(roll), 0.05)
    slots[WheelSlot.SLIP_ANGLE_RAD] = math.atan2(-side, abs(roll))
    if deflection <= 0.0 or load <= 1.0:
        rates[tyre], rates[tyre + 1] = -u_x / LIFTED_S, -u_y / LIFTED_S
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    soil_at(field, soil, nodes, s, t, here)
    x, y, resistance, rolling, sinkage, rates[tyre], rates[tyre + 1] = relaxed_shear(
        here, wheel, load, spin, roll, side, u_x, u_y, dt_s
    )
    resistance *= smooth_sign(roll, SIGN_SPEED_MPS)
    moment = rolling * radius * smooth_sign(spin, SIGN_SPEED_MPS)
    wall = wall_force(field, wheel, s, t, side)
    slots[WheelSlot.LOAD_N], slots[WheelSlot.DEFLECTION_M] = load, deflection
    slots[WheelSlot.SHEAR_X_N], slots[WheelSlot.SHEAR_Y_N] = x, y
    slots[WheelSlot.RESISTANCE_N], slots[WheelSlot.ROLLING_MOMENT_NM] = resistance, moment
    slots[WheelSlot.SINKAGE_M], slots[WheelSlot.WALL_N] = sinkage, wall
    powers[PowerSlot.SLIP_LONG] += x * (spin - roll)
    powers[PowerSlot.SLIP_LAT] -= y * side
    powers[PowerSlot.ROLLING] += resistance * roll + moment * rate
    powers[PowerSlot.TYRE] -= load * rising
    powers[PowerSlot.WALL] -= wall * side
    force = rigid.plus(
        rigid.scaled(x - resistance, ahead),
        rigid.plus(rigid.scaled(y + wall, left), rigid.scaled(load, normal)),
    )
    # about the rolling direction the forces act at the contact, the wall's half way up its height;
    # about the axle the shear's arm is the rolling radius
    loaded = 0.5 * wheel[Wheel.DIAMETER_M] - deflection
    overturning = (
        loaded * (upright * y + camber * load)
        + contact_shift_m(wheel, camber / upright, deflection) * (upright * load - camber * y)
        + (loaded * upright + 0.5 * min(height, 0.0)) * wall
    )
    torque = rigid.plus(rigid.scaled(-x * radius - moment, axle), rigid.scaled(overturning, ahead))
    return force, torque
