"""One wheel on the ground: its springs, its tread's deflections, and the soil law's forces.

One module, because slip, shear and load of a tyre are one set of equations.
"""

from __future__ import annotations

import math

from twin.compute.compiled import inlined_law, law
from twin.physics import rigid
from twin.physics.block import Field, PowerSlot, Soil, Wheel, WheelSlot
from twin.physics.contact import RING, ring, upward
from twin.physics.furrow_wall import wall_force
from twin.physics.ground import field_axis, furrow, on_ground, soil_at
from twin.physics.laws import soil_forces
from twin.physics.shapes import Array, Vector, Vector4

SIGN_SPEED_MPS = 0.03
"""Speed over which motion resistance changes sign [m/s]: 1 % slip at ploughing speed is half of it.

A moment that would turn a light wheel back within a step changes its sign over more."""
RADIUS_PER_DEFLECTION = 1.0 / 3.0
"""Loss of rolling radius over deflection [-]; published for bias tyres."""
LIFTED_S = 0.05
"""Time in which the deflections of a lifted wheel vanish [s]."""
SLOWEST_MPS = 0.05
"""Slowest travel by which slip is reported [m/s]."""
LEAST_SLIP = 1e-7
"""Slip at which the law's secant is taken where there is none [-]."""
LEAST_SINE = 1e-6
"""Least sine of the angle between axle and ground normal: below it a wheel has no rolling
direction."""


@inlined_law
def smooth_sign(speed: float, width: float) -> float:
    """speed / sqrt(speed**2 + width**2)"""
    return speed / math.sqrt(speed * speed + width * width)


@inlined_law
def relaxed_shear(
    soil: Array,
    wheel: Array,
    load_n: float,
    spin_mps: float,
    roll_mps: float,
    side_mps: float,
    tread: Vector4,
    dt_s: float,
) -> tuple[float, float, float, float, float, Vector4, float]:
    """Forces of a tyre whose tread is sprung on its carcass, and the rates of its activations.

        F = K u + N d du/dt                du/dt = v - V K u / C        C = law(s) / s
        v = (w R - v_x, -v_y)              ds/dt = (v - V s) / L        V = max(|w R|, |v_x|, |v_y|)

    u is the deflection of the tread. s is the slip of the contact, which lags over the relaxation
    length L; the soil law is evaluated at s. The springs K are constant (`twin.machine.tread`); C
    is the law's secant along and across. In steady state s = v / V and K u = law(s); after a small
    change of slip u follows over the distance C / K, which falls as slip grows. At rest u is a
    spring, so a parked wheel sticks. Both steps are implicit. |K u| never exceeds N mu, or the
    law's force where that is more. The power lost is K u . V K u / C, never negative, so springs
    and contact never add energy. The law is evaluated for a wheel that rolls forwards; for one
    that rolls backwards its forces change sign. Pacejka 2012, Tire and Vehicle Dynamics, section
    7.2.1, with the law's secant for his cornering stiffness.

    Args:
        soil, wheel: parts of the parameter block (`Soil`, `Wheel`).
        load_n: N.
        spin_mps, roll_mps, side_mps: w R, v_x, v_y.
        tread: u along and across [m], s along and across [-].
        dt_s: time step.

    Returns:
        shear_x_n, shear_y_n, resistance_n, rolling_moment_n, sinkage_m, rates of `tread`,
        energy_j held by the springs.
    """
    k_x, k_y = wheel[Wheel.SHEAR_LONG_NPM], wheel[Wheel.SHEAR_LAT_NPM]
    long_m, lat_m = wheel[Wheel.RELAXATION_LONG_M], wheel[Wheel.RELAXATION_LAT_M]
    v_x, v_y = spin_mps - roll_mps, -side_mps
    way_m = dt_s * max(abs(spin_mps), abs(roll_mps), abs(side_mps))
    s_x = (tread[2] * long_m + dt_s * v_x) / (long_m + way_m)
    s_y = (tread[3] * lat_m + dt_s * v_y) / (lat_m + way_m)
    way = 1.0 if spin_mps + roll_mps >= 0.0 else -1.0
    slip, side_slip = not_zero(way * s_x), not_zero(s_y)
    x, y, resistance, rolling, sinkage = soil_forces(soil, wheel, load_n, slip, side_slip)
    most = load_n * soil[Soil.FRICTION]
    most = max(most * most, x * x + y * y)
    secant_x, secant_y = max(x / slip, 1e-3 * load_n), max(y / side_slip, 1e-3 * load_n)
    u_x = (tread[0] + dt_s * v_x) * (secant_x / (secant_x + way_m * k_x))
    u_y = (tread[1] + dt_s * v_y) * (secant_y / (secant_y + way_m * k_y))
    held = k_x * u_x * k_x * u_x + k_y * u_y * k_y * u_y
    if held > most:
        within = math.sqrt(most / held)
        u_x, u_y = u_x * within, u_y * within
    per_step = 1.0 / dt_s
    rate_x, rate_y = (u_x - tread[0]) * per_step, (u_y - tread[1]) * per_step
    x = k_x * u_x + load_n * wheel[Wheel.SHEAR_DAMPING_LONG_SPM] * rate_x
    y = k_y * u_y + load_n * wheel[Wheel.SHEAR_DAMPING_LAT_SPM] * rate_y
    size = x * x + y * y
    if size > most:
        within = math.sqrt(most / size)
        x, y = x * within, y * within
    energy = 0.5 * (k_x * tread[0] * tread[0] + k_y * tread[1] * tread[1])
    rates = (rate_x, rate_y, (s_x - tread[2]) * per_step, (s_y - tread[3]) * per_step)
    return x, y, resistance, rolling, sinkage, rates, energy


@inlined_law
def not_zero(slip: float) -> float:
    """slip + LEAST_SLIP or slip - LEAST_SLIP, by its sign: force / slip then exists at zero too."""
    return slip + LEAST_SLIP if slip >= 0.0 else slip - LEAST_SLIP  # also of a negative zero


@inlined_law
def way_ahead(axle: Vector, normal: Vector) -> Vector:
    """Unit vector in the ground's plane along which a wheel rolls: (c x n) / |c x n|.

    c is the axle, n the ground's normal. 0 where they are parallel.
    """
    across = rigid.cross(axle, normal)
    return rigid.scaled(1.0 / max(math.sqrt(rigid.dot(across, across)), LEAST_SINE), across)


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

        N = |F_1 + F_2| + d_1 + d_2        d_i = -c/2 n . v_i, no ring pulls

    F_i are the springs of the two rings (`twin.physics.contact`), n the direction of their sum,
    v_i the velocity of each ring's lowest point, c the wheel's damping. Shear acts where the tread
    meets the ground; its lateral slip is the velocity of the tread there, not of the hub. Its lever
    arm about the axle is the rolling radius. Motion resistance acts at the hub, against the hub's
    velocity.

    Args:
        field, soil, wheel: parts of the parameter block.
        xpos, xmat, cvel, com, root: as in `twin.physics.rigid`.
        act: mjData's activations.
        dt_s: time step.
        slots, rates, powers: written: `WheelSlot` numbers, rates of `act`, `PowerSlot` numbers.
        here: room for the soil at the wheel's place, overwritten.
        nodes: the model's hfield_data.

    Returns:
        force [N], torque [N m]: world axes; zero for a lifted wheel.
    """
    body, tyre = int(wheel[Wheel.BODY]), int(wheel[Wheel.TYRE])
    hub, axle = rigid.row3(xpos, body), rigid.axis(xmat, body, 1)
    velocity = rigid.point_velocity(cvel, com, body, root, hub)
    spinning = rigid.angular_velocity(cvel, body)
    rate = rigid.dot(spinning, axle)
    turning = rigid.minus(spinning, rigid.scaled(rate, axle))
    plane = field_axis(field, Field.NORMAL)
    up, upright = upward(axle, plane)
    outer_m, width_m = 0.5 * wheel[Wheel.DIAMETER_M], wheel[Wheel.WIDTH_M]
    tread = rigid.scaled(-outer_m, up)
    s, t, _ = on_ground(field, rigid.plus(hub, tread))
    bottom, slope_s, slope_t = furrow(field, s, t)
    half_c, aside_m = 0.5 * wheel[Wheel.DAMPING_NSPM], RING * width_m
    force_l, moment_l, overlap_l, energy_l, push_l = ring(
        field, nodes, wheel, hub, bottom, axle, up, aside_m
    )
    force_r, moment_r, overlap_r, energy_r, push_r = ring(
        field, nodes, wheel, hub, bottom, axle, up, -aside_m
    )
    force, torque = rigid.plus(force_l, force_r), rigid.plus(moment_l, moment_r)
    lift = rigid.dot(force, plane)
    if slope_s != 0.0 or slope_t != 0.0:  # the furrow's bottom is that under the tread's middle
        downhill = rigid.plus(
            rigid.scaled(-lift * slope_s, field_axis(field, Field.AHEAD)),
            rigid.scaled(-lift * slope_t, field_axis(field, Field.LEFT)),
        )
        force = rigid.plus(force, downhill)
        torque = rigid.plus(torque, rigid.cross(tread, downhill))
    elastic = math.sqrt(rigid.dot(force, force))
    for i in range(len(slots)):
        slots[i] = 0.0
    slots[WheelSlot.SPRING_X_N], slots[WheelSlot.SPRING_Y_N] = force[0], force[1]
    slots[WheelSlot.SPRING_Z_N] = force[2]
    normal = rigid.scaled(1.0 / elastic, force) if elastic > 0.0 else plane
    ahead = way_ahead(axle, normal)
    left = rigid.cross(normal, ahead)
    roll, side = rigid.dot(velocity, ahead), rigid.dot(velocity, left)
    overlap = 0.5 * (overlap_l + overlap_r)
    deflection = min(overlap / upright, outer_m)
    radius = wheel[Wheel.FREE_ROLLING_RADIUS_M] - RADIUS_PER_DEFLECTION * deflection
    spin = rate * radius
    tread_now = (act[tyre], act[tyre + 1], act[tyre + 2], act[tyre + 3])
    slots[WheelSlot.RATE_RADPS], slots[WheelSlot.ROLLING_RADIUS_M] = rate, radius
    slots[WheelSlot.SPEED_X_MPS], slots[WheelSlot.SPEED_Y_MPS] = roll, side
    slots[WheelSlot.SLIP] = (spin - roll) / max(abs(spin), abs(roll), SLOWEST_MPS)
    powers[PowerSlot.TYRE] -= rigid.dot(force, velocity) + rigid.dot(torque, turning)
    load_l, damped_l, taken_l = damped(push_l, half_c, tread, aside_m, axle, normal,
                                       velocity, turning)  # fmt: skip
    load_r, damped_r, taken_r = damped(push_r, half_c, tread, -aside_m, axle, normal,
                                       velocity, turning)  # fmt: skip
    powers[PowerSlot.TYRE] += taken_l + taken_r
    load = elastic + load_l + load_r
    force = rigid.plus(force, rigid.scaled(load_l + load_r, normal))
    torque = rigid.plus(torque, rigid.plus(damped_l, damped_r))
    wall, wall_moment, wall_j, deeper, taken = wall_force(
        field, wheel, hub, axle, velocity, turning, -bottom
    )
    slots[WheelSlot.ELASTIC_J] = energy_l + energy_r + wall_j
    if wall_j > 0.0:
        shallower = rigid.plus(  # the wall is lower where the furrow is
            rigid.scaled(deeper * slope_s, field_axis(field, Field.AHEAD)),
            rigid.scaled(deeper * slope_t, field_axis(field, Field.LEFT)),
        )
        turned = rigid.cross(tread, shallower)
        taken -= rigid.dot(shallower, velocity) + rigid.dot(turned, turning)
        force = rigid.plus(force, rigid.plus(wall, shallower))
        torque = rigid.plus(torque, rigid.plus(wall_moment, turned))
        powers[PowerSlot.WALL] += taken
        slots[WheelSlot.WALL_N] = rigid.dot(wall, left)
    if load <= 1.0:
        slots[WheelSlot.TREAD_SPEED_Y_MPS] = side
        for i in range(4):
            rates[tyre + i] = -act[tyre + i] / LIFTED_S
        return force, without(torque, axle)
    shift = aside_m * (
        rigid.dot(force_l, normal) + load_l - rigid.dot(force_r, normal) - load_r
    ) / load  # fmt: skip
    meeting = rigid.plus(rigid.scaled(deflection - outer_m, up), rigid.scaled(shift, axle))
    slip_side = side + rigid.dot(rigid.cross(turning, meeting), left)
    slots[WheelSlot.TREAD_SPEED_Y_MPS] = slip_side
    soil_at(field, soil, nodes, s, t, here)
    x, y, resistance, rolling, sinkage, changes, sheared_j = relaxed_shear(
        here, wheel, load, spin, roll, slip_side, tread_now, dt_s
    )
    for i in range(4):
        rates[tyre + i] = changes[i]
    slots[WheelSlot.ELASTIC_J] += sheared_j
    resistance *= smooth_sign(roll, SIGN_SPEED_MPS)
    width = 2.0 * dt_s * abs(rolling) * radius * radius / wheel[Wheel.INERTIA_KGM2]
    moment = rolling * radius * smooth_sign(spin, max(SIGN_SPEED_MPS, width))
    resistance, moment = without_gain(resistance, roll, moment, rate)
    slots[WheelSlot.LOAD_N], slots[WheelSlot.DEFLECTION_M] = load, deflection
    slots[WheelSlot.SHEAR_X_N], slots[WheelSlot.SHEAR_Y_N] = x, y
    slots[WheelSlot.RESISTANCE_N], slots[WheelSlot.ROLLING_MOMENT_NM] = resistance, moment
    slots[WheelSlot.SINKAGE_M] = sinkage
    powers[PowerSlot.SLIP_LONG] += x * (spin - roll)
    powers[PowerSlot.SLIP_LAT] -= y * slip_side
    powers[PowerSlot.ROLLING] += resistance * roll + moment * rate
    across = rigid.scaled(y, left)
    force = rigid.plus(force, rigid.plus(rigid.scaled(x - resistance, ahead), across))
    torque = without(rigid.plus(torque, rigid.cross(meeting, across)), axle)
    return force, rigid.plus(torque, rigid.scaled(-x * radius - moment, axle))


@inlined_law
def without_gain(
    resistance: float, roll_mps: float, moment: float, rate_radps: float
) -> tuple[float, float]:
    """Motion resistance [N] and moment [N m], limited so that they never give power to the machine.

    power = resistance * roll_mps + moment * rate_radps >= 0

    On soft soil the law's resistance can be negative: it pushes the hub. Its power then comes from
    the wheel's rotation, so it is limited to what the moment takes there. Without the limit the
    pair could add energy while the contact's slip lags the wheel's. If both powers are negative,
    both results are 0.
    """
    at_hub, on_wheel = resistance * roll_mps, moment * rate_radps
    if at_hub + on_wheel >= 0.0:
        return resistance, moment
    if at_hub < 0.0 and on_wheel < 0.0:
        return 0.0, 0.0
    if at_hub < 0.0:
        return resistance * on_wheel / -at_hub, moment
    return resistance, moment * at_hub / -on_wheel


@inlined_law
def damped(
    pushed_n: float,
    damping_nspm: float,
    tread: Vector,
    aside_m: float,
    axle: Vector,
    normal: Vector,
    velocity: Vector,
    turning: Vector,
) -> tuple[float, Vector, float]:
    """Damper force of one ring along the normal; with the spring's force it never pulls.

    Args:
        pushed_n: size of the ring's spring force.
        damping_nspm: damping of this ring.
        tread, aside_m: the ring's lowest point from the hub: its part across the axle, and its
            distance along the axle.
        axle, normal: unit vectors of the wheel's axle, and of the force on the ground.
        velocity: velocity of the hub [m/s].
        turning: angular velocity of the wheel without its spin about the axle [rad/s].

    Returns:
        force_n along the normal (negative while the ring springs back), moment about the hub [N m],
        power_w taken from the machine.
    """
    if pushed_n <= 0.0:
        return 0.0, (0.0, 0.0, 0.0), 0.0
    arm = rigid.plus(tread, rigid.scaled(aside_m, axle))
    rising = rigid.dot(normal, rigid.plus(velocity, rigid.cross(turning, arm)))
    force = max(-damping_nspm * rising, -pushed_n)
    return force, rigid.scaled(force, rigid.cross(arm, normal)), -force * rising


@inlined_law
def without(vector: Vector, axle: Vector) -> Vector:
    """The part of a vector v across the axle c: v - (v . c) c."""
    return rigid.minus(vector, rigid.scaled(rigid.dot(vector, axle), axle))
