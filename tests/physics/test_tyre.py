"""The relaxing tyre: its steady state is the law, at rest a spring; it leans, and meets a wall."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.physics.blocks import NO_NODES, furrowed, level, soil, wheel
from twin.physics.block import PowerSlot, Soil, WheelSlot
from twin.physics.brixius import brixius
from twin.physics.furrow_wall import SLICE_M, wall_force
from twin.physics.tyre import relaxed_shear, roll_wheel

W, DT_S = 21.7e3, 0.002


def settle(spin, roll, side, *, u=(0.0, 0.0), duration_s=20.0):
    """Forces over time of a tyre at constant speeds, what it remembers integrated as by MuJoCo."""
    forces, tread = [], (*u, 0.0, 0.0)
    for _ in range(round(duration_s / DT_S)):
        x, y, *_, rates, _ = relaxed_shear(soil(), wheel(), W, spin, roll, side, tread, DT_S)
        tread = tuple(a + DT_S * rate for a, rate in zip(tread, rates, strict=True))
        forces.append((x, y))
    return np.array(forces), tread[:2]


@pytest.mark.parametrize(
    ("spin", "roll", "side"),
    [(1.7, 1.5, 0.0), (1.5, 1.5, 0.1), (1.8, 1.5, -0.2), (1.2, 1.5, 0.0), (-1.0, -0.8, 0.05)],
)
def test_steady_rolling_is_the_law_at_the_defined_slip(spin, roll, side):
    largest = max(abs(spin), abs(roll))
    law = brixius(soil(), wheel(), W, (spin - roll) / largest, -side / largest)
    forces, _ = settle(spin, roll, side)
    assert forces[-1] == pytest.approx(law[:2], rel=1e-6)


def test_the_force_builds_up_over_the_relaxation_length():
    """63 % of the steady slip after the wheel has rolled one relaxation length, 0.2 m."""
    slip = 1e-4
    forces, _ = settle(1.0, 1.0 - slip, 0.0)
    at = round(0.2 / DT_S)
    # 1 - 1/e of the law's force, and of the damper, 0.2 s of load, what is still to come: 1/e
    stiffness = 7.5 * 0.88 * (1.0 - math.exp(-0.1 * 42.0))
    built = 1.0 - math.exp(-1.0) + 0.2 / stiffness / 0.2 * math.exp(-1.0)
    assert forces[at, 0] / forces[-1, 0] == pytest.approx(built, rel=0.02)


def test_the_way_to_a_new_force_is_shorter_where_the_tyre_slides():
    """A locked wheel has its whole force after N mu / K, 2 cm, not after the relaxation length."""
    forces, _ = settle(0.0, 1.0, 0.0)
    way = np.arange(len(forces)) * DT_S
    built = way[np.argmax(-forces[:, 0] > 0.95 * 0.88 * W * (1.0 - math.exp(-4.2)))]
    spring_npm = 6.5 * W / 0.2
    assert built < 3.0 * 0.88 * W / spring_npm < 0.1


def test_a_standing_wheel_is_a_spring():
    """It keeps its force for ever, as a pushed parked wheel does."""
    u = (0.003, -0.004)
    forces, after = settle(0.0, 0.0, 0.0, u=u, duration_s=60.0)
    assert after == u
    assert np.all(forces == forces[0])
    assert forces[0, 0] > 0.0 > forces[0, 1]


@given(*(st.floats(-3.0, 3.0),) * 3, st.floats(-0.2, 0.2), st.floats(-0.7, 0.7))
def test_no_motion_and_no_deflection_exceeds_the_friction(spin, roll, side, u_x, u_y):
    tread = (u_x, u_y, u_x, u_y)
    x, y, *_ = relaxed_shear(soil(), wheel(), W, spin, roll, side, tread, DT_S)
    assert math.hypot(x, y) <= 0.88 * W * (1.0 + 1e-12)


@given(st.floats(0.5, 3.0), st.floats(0.5, 3.0), st.floats(-0.5, 0.5))
def test_steady_shear_takes_energy_out_of_the_motion(spin, roll, side):
    forces, _ = settle(spin, roll, side, duration_s=3.0)
    sliding_x, sliding_y = roll - spin, side
    assert forces[-1] @ [sliding_x, sliding_y] <= 0.0


def test_pushing_a_standing_wheel_to_and_fro_creates_no_energy():
    """Work of the shear over closed cycles of displacement, small to sliding, is a loss."""
    for amplitude_m in (1e-4, 0.01, 0.3):
        tread, work = (0.0,) * 4, 0.0
        for k in range(4000):
            side = amplitude_m * math.pi * math.cos(math.pi * k * DT_S)  # of 2 s, twice and twice
            _, y, *_, rates, _ = relaxed_shear(soil(), wheel(), W, 0.0, 0.0, side, tread, DT_S)
            tread = tuple(a + DT_S * rate for a, rate in zip(tread, rates, strict=True))
            work += y * side * DT_S
        assert work < 0.0


@given(
    *(st.floats(-3.0, 3.0),) * 3, *(st.floats(-0.2, 0.2),) * 2, *(st.floats(-1.0, 1.0),) * 2,
    st.floats(1e3, 3e4),
)  # fmt: skip
def test_a_tyre_returns_no_more_than_it_was_given(spin, roll, side, u_x, u_y, s_x, s_y, load):
    """F . v >= d(K u**2 / 2)/dt, also where load and slip are not those that deflected it."""
    tread = (u_x, u_y, s_x, s_y)
    x, y, *_, rates, before = relaxed_shear(soil(), wheel(), load, spin, roll, side, tread, DT_S)
    rate_x, rate_y = rates[:2]
    u_x, u_y = u_x + DT_S * rate_x, u_y + DT_S * rate_y
    after = relaxed_shear(soil(), wheel(), load, 0.0, 0.0, 0.0, (u_x, u_y, 0.0, 0.0), DT_S)[-1]
    k_x = 6.5 * 21.7e3 / 0.2
    k_y = 6.5 * 21.7e3 * 0.85 / 0.7
    sprung = np.array([k_x * u_x, k_y * u_y])  # at the step's end, without the damper
    assert DT_S * sprung @ [spin - roll, -side] >= after - before - 1e-6
    damped = np.array([x, y]) - sprung
    if math.hypot(x, y) < 0.88 * load * 0.999:  # within the friction the damper takes too
        assert damped @ [rate_x, rate_y] >= -1e-9


FURROWED = furrowed(1.0)
TOUCHING_M = 0.65 + 0.5 * 0.467
"""|t| of a wheel whose flank just touches the wall."""
SLICE_TOUCHED_M = 0.65 + 0.5 - 0.5 * 0.467
STILL = (0.0, 0.0, 0.0)


def wall(field, place, *, speed=0.0, depth=0.25):
    """Sideways push on an upright wheel beside the line, which moves to the left."""
    hub = (20.0, place, 0.8)
    force, *_ = wall_force(field, wheel(), hub, (0.0, 1.0, 0.0), (0.0, speed, 0.0), STILL, depth)
    assert force[0] == force[2] == 0.0
    return force[1]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_wall_pushes_into_the_furrow_by_its_spring_and_damper(side):
    """k depth * penetration - c depth * speed away from it, at 0.25 m of wall; mirrored."""
    field = furrowed(side)
    pushed = wall(field, side * (TOUCHING_M - 0.01))
    assert pushed == pytest.approx(side * 400e3 * 0.25 * 0.01)
    hit = wall(field, side * (TOUCHING_M - 0.01), speed=-side * 0.05)
    assert hit - pushed == pytest.approx(side * 20e3 * 0.25 * 0.05)
    half = wall(field, side * (TOUCHING_M - 0.1), depth=0.125)
    assert half == pytest.approx(side * 400e3 * 0.125 * 0.1)
    back = wall(field, side * (SLICE_TOUCHED_M + 0.02))
    assert back == pytest.approx(-side * 400e3 * 0.25 * 0.02)


@pytest.mark.parametrize("side", [1.0, -1.0])
@given(st.floats(0.0, 2.0), st.floats(-1.0, 1.0))
def test_the_wall_never_pulls_and_acts_only_where_it_is_touched(side, place, speed):
    force = wall(furrowed(side), side * place, speed=speed)
    if TOUCHING_M <= place <= SLICE_TOUCHED_M:
        assert force == 0.0
    elif place < TOUCHING_M:
        assert side * force >= 0.0
    else:
        assert side * force <= 0.0
    assert wall(furrowed(side), side * place, speed=speed, depth=0.0) == 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_turned_slice_gives_way_and_is_behind_a_tyre_far_from_the_furrow(side):
    """Its push is greatest at SLICE_M, gone at twice that, and the crossing costs k SLICE_M**2."""
    field = furrowed(side)
    pressed = np.linspace(0.0, 3.0, 3001)
    push = np.array([-side * wall(field, side * (SLICE_TOUCHED_M + p)) for p in pressed])
    assert pressed[push.argmax()] == pytest.approx(SLICE_M)
    assert np.all(push[pressed > 2.0 * SLICE_M] == 0.0)
    assert np.trapezoid(push, pressed) == pytest.approx(400e3 * 0.25 * SLICE_M**2, rel=1e-3)


def test_the_walls_push_is_the_gradient_of_its_energy():
    """For a leaning, steered wheel, moved and turned along and about every axis; and with depth."""
    field, one = furrowed(1.0, pass_t_m=0.1), wheel()
    rng = np.random.default_rng(3)
    for _ in range(20):
        place = np.array([20.0, 0.1 + rng.uniform(0.7, 1.2), 0.55])
        turn = Rotation.from_rotvec(rng.normal(size=3) * (0.1, 0.0, 0.2))

        def energy(shift, about, depth, place=place, turn=turn):
            axle = (Rotation.from_rotvec(about) * turn).apply([0.0, 1.0, 0.0])
            hub = tuple(place + shift)
            return wall_force(field, one, hub, tuple(axle), STILL, STILL, depth)[2]

        axle = turn.apply([0.0, 1.0, 0.0])
        force, moment, _, growth, _ = wall_force(
            field, one, tuple(place), tuple(axle), STILL, STILL, 0.25
        )
        still, e = np.zeros(3), 1e-6
        by_shift = [(energy(-e * d, still, 0.25) - energy(e * d, still, 0.25)) for d in np.eye(3)]
        by_turn = [(energy(still, -e * d, 0.25) - energy(still, e * d, 0.25)) for d in np.eye(3)]
        assert force == pytest.approx(np.array(by_shift) / (2 * e), abs=0.5)
        assert moment == pytest.approx(np.array(by_turn) / (2 * e), abs=0.5)
        by_depth = energy(still, still, 0.25 + e) - energy(still, still, 0.25 - e)
        assert growth == pytest.approx(by_depth / (2 * e), abs=0.5)


def on_ground(field, *, hub=(20.0, 0.0, 0.8175), lean_rad=0.0, velocity=(0.0, 0.0, 0.0), rate=0.0):
    """Force and torque on one wheel at a place, without deflections; its slots and powers."""
    turned = Rotation.from_euler("x", lean_rad)
    one, moving = wheel(), np.zeros((1, 6))
    moving[0, :3], moving[0, 3:] = turned.apply([0.0, rate, 0.0]), velocity
    slots, powers = np.zeros(int(WheelSlot.SIZE)), np.zeros(int(PowerSlot.SIZE))
    force, torque = roll_wheel(
        field, soil(), one, np.array([hub]), turned.as_matrix().reshape(1, 9), moving,
        np.array([hub]), 0, np.zeros(5), DT_S, slots, np.zeros(5), powers, np.zeros(Soil.SIZE),
        NO_NODES,
    )  # fmt: skip
    return np.array(force), np.array(torque), slots, powers


@pytest.mark.parametrize("lean_rad", [0.5 * math.pi - 1e-9, 1.57, -1.57, 2.5])
@pytest.mark.parametrize("sunk", [False, True])
def test_a_wheel_thrown_over_gives_finite_forces(lean_rad, sunk):
    """However it lies, even with its hub in the ground, no more than its radius is pressed."""
    field = level()
    hub_m = -0.4 if sunk else 0.3
    force, torque, slots, _ = on_ground(field, lean_rad=lean_rad, hub=(0.0, 0.0, hub_m))
    assert np.all(np.isfinite([*force, *torque, *slots]))
    assert 0.0 <= slots[WheelSlot.LOAD_N] <= 383e3 * 0.5 * 1.755 * (1.0 + 1e-12)


def test_an_upright_standing_wheel_is_a_spring():
    force, torque, slots, _ = on_ground(level())
    assert slots[WheelSlot.DEFLECTION_M] == pytest.approx(0.06)
    assert force == pytest.approx([0.0, 0.0, 383e3 * 0.06])
    assert torque == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("lean_rad", [0.02, -0.14])
def test_the_roll_moment_of_a_leaning_wheel_by_hand(lean_rad):
    """Its load acts at the lowest point of the tread, shifted to the lower side."""
    height_m, radius_m = 0.8175, 0.5 * 1.755
    force, torque, slots, _ = on_ground(level(), lean_rad=lean_rad)
    overlap_m = radius_m * math.cos(lean_rad) - height_m
    load = 383e3 * overlap_m
    assert slots[WheelSlot.LOAD_N] == pytest.approx(load)
    assert force == pytest.approx([0.0, 0.0, load], abs=1e-6)
    # the centre of a pressure that grows in proportion to the tread's depth in the ground
    x = (np.arange(20_000) + 0.5) / 20_000 * 0.467 - 0.5 * 0.467
    pressure = overlap_m - x * math.sin(lean_rad)
    assert pressure.min() > 0.0
    shift_m = (x @ pressure) / pressure.sum()
    aside_m = radius_m * math.sin(lean_rad) + shift_m * math.cos(lean_rad)
    assert torque == pytest.approx([aside_m * load, 0.0, 0.0], abs=1e-3)


def test_the_lateral_slip_is_that_of_the_tread():
    """A hub at rest that rolls about the way ahead: du_y/dt = -rate x loaded radius."""
    one, moving, rates = wheel(), np.zeros((1, 6)), np.zeros(5)
    moving[0, :3] = [0.1, 1.5 / 0.829, 0.0]
    hub, none = np.array([[20.0, 0.0, 0.8175]]), np.zeros(5)
    roll_wheel(
        level(), soil(), one, hub, np.eye(3).reshape(1, 9), moving, hub, 0, none, DT_S,
        np.zeros(WheelSlot.SIZE), rates, np.zeros(PowerSlot.SIZE), np.zeros(Soil.SIZE), NO_NODES,
    )  # fmt: skip
    assert rates[1] == pytest.approx(-0.1 * 0.8175, rel=0.03)  # less what the step's end takes
    fine = np.zeros(5)
    roll_wheel(
        level(), soil(), one, hub, np.eye(3).reshape(1, 9), moving, hub, 0, none, 1e-6,
        np.zeros(WheelSlot.SIZE), fine, np.zeros(PowerSlot.SIZE), np.zeros(Soil.SIZE), NO_NODES,
    )  # fmt: skip
    assert fine[1] == pytest.approx(-0.1 * 0.8175, rel=1e-4)


def test_the_wall_turns_the_wheel_about_the_middle_of_its_height():
    """Hub 0.8175 m above the furrow's bottom, wall 0.25 m: its force 0.6925 m below the hub."""
    hub = (20.0, TOUCHING_M - 0.01, 0.8175 - 0.25)
    force, torque, slots, _ = on_ground(FURROWED, hub=hub)
    wall = 400e3 * 0.25 * 0.01
    assert slots[WheelSlot.WALL_N] == pytest.approx(wall)
    assert force == pytest.approx([0.0, wall, 383e3 * 0.06])
    assert torque == pytest.approx([(0.8175 - 0.125) * wall, 0.0, 0.0])


def test_on_the_furrows_ramp_the_load_is_normal_to_it():
    slope = math.atan(-0.25 * 1.5 / 3.0)
    force, torque, slots, _ = on_ground(FURROWED, hub=(11.5, 0.9, 0.8175 - 0.125))
    lift = 383e3 * (0.5 * 1.755 - 0.8175)
    assert slots[WheelSlot.LOAD_N] == pytest.approx(lift / math.cos(slope))
    assert force == pytest.approx([-lift * math.tan(slope), 0.0, lift], abs=1e-6)
    assert torque == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_the_powers_of_a_wheel_add_up_to_what_its_forces_take():
    """Sliding, rolling, tyre and wall, each of its own: -(force . v + torque . w)."""
    hub = (20.0, TOUCHING_M - 0.01, 0.8175 - 0.25)
    velocity, rate = np.array([1.5, -0.06, -0.02]), 2.1
    force, torque, slots, powers = on_ground(FURROWED, hub=hub, velocity=tuple(velocity), rate=rate)
    taken = -(force @ velocity + torque[1] * rate)
    parts = [
        powers[p]
        for p in (
            PowerSlot.SLIP_LONG,
            PowerSlot.SLIP_LAT,
            PowerSlot.ROLLING,
            PowerSlot.TYRE,
            PowerSlot.WALL,
        )
    ]
    assert sum(parts) == pytest.approx(taken, rel=1e-12)
    assert powers.sum() == pytest.approx(taken, rel=1e-12)
    spin = rate * slots[WheelSlot.ROLLING_RADIUS_M]
    assert parts[0] == pytest.approx(slots[WheelSlot.SHEAR_X_N] * (spin - 1.5))
    assert parts[1] == pytest.approx(slots[WheelSlot.SHEAR_Y_N] * 0.06)
    assert parts[4] == pytest.approx(slots[WheelSlot.WALL_N] * 0.06)
    assert min(parts[:3]) > 0.0


@pytest.mark.parametrize("lean_rad", [0.14, -0.14])
def test_a_leaning_wheel_stands_where_its_tread_does(lean_rad):
    """The hub is beside the place: with it outside the furrow the tread is in it, and the reverse.

    The middle of the tread lies r sin(lean) to the left of the hub, which turns about x.
    """
    place_m = 0.5 * 1.755 * math.sin(lean_rad)
    furrow = furrowed(1.0)  # its wall is at 0.65 m, its bottom from 0.75 m on
    hub_t = 0.9 - place_m
    height_m = 0.8175 * math.cos(lean_rad) - 0.25
    _, _, slots, _ = on_ground(furrow, lean_rad=lean_rad, hub=(20.0, hub_t, height_m))
    assert slots[WheelSlot.DEFLECTION_M] == pytest.approx(0.06)
    outside_t = 0.6 - place_m
    _, _, slots, _ = on_ground(furrow, lean_rad=lean_rad, hub=(20.0, outside_t, height_m + 0.25))
    assert slots[WheelSlot.DEFLECTION_M] == pytest.approx(0.06)
    assert slots[WheelSlot.WALL_N] == 0.0


def test_a_lifted_wheel_feels_nothing():
    force, torque, slots, powers = on_ground(level(), hub=(20.0, 0.0, 0.88), rate=2.0)
    assert not force.any()
    assert not torque.any()
    assert not powers.any()
    assert slots[WheelSlot.LOAD_N] == 0.0
    assert slots[WheelSlot.SLIP] == 1.0
