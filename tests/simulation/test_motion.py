"""The machine in motion and at rest against what the laws alone say it must do."""

import math

import mujoco
import numpy as np
import pytest
from scipy.optimize import brentq

from tests.simulation.rigs import (
    BARE,
    EVEN,
    PLOUGHING,
    bare_rig,
    driven,
    field,
    replace,
    set_controls,
    soiled,
    start,
    wheels,
)  # fmt: skip
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.scenario import Course
from twin.simulation.build import build
from twin.simulation.simulate import simulate

HINGE_DAMPING_NMSPRAD = 2.0
FIRM = replace(EVEN, course=Course(approach_m=3.0, length_m=25.0))


def tyre(model, wheel):
    """Width, diameter and deflection ratio, c0, m of a wheel from its model's published numbers."""
    axle = "front" if wheel < 2 else "rear"
    number = {model.numeric(i).name: model.numeric(i).data[0] for i in range(model.nnumeric)}
    return (number[f"tyre_{axle}.{name}"] for name in ("width_m", "diameter_m", "deflection_ratio"))


def mobility(model, wheel, load_n, cone_index_kpa):
    b, d, ratio = tyre(model, wheel)
    return cone_index_kpa * 1e3 * b * d / load_n * (1.0 + 5.0 * ratio) / (1.0 + 3.0 * b / d)


def free_wheel(bn, bearing=0.0):
    """Skid and towing force over load of an undriven wheel: no torque but its bearing's.

    0.88 (1 - exp(-0.1 Bn)) (1 - exp(-7.5 |s|)) sgn(s) + 0.04 + bearing = 0
    """
    top = 0.88 * (1.0 - math.exp(-0.1 * bn))

    def gross(s):
        return math.copysign(top * (1.0 - math.exp(-7.5 * abs(s))), s) + 0.04 + bearing

    skid = brentq(gross, -0.2, 0.0)
    return skid, 0.04 + bearing + 1.0 / bn + 0.5 * abs(skid) / math.sqrt(bn)


@pytest.mark.parametrize("cone_index_kpa", [450.0, 1200.0])
def test_the_undriven_front_wheels_skid_and_drag_as_the_source_law_says(cone_index_kpa):
    scenario = soiled(FIRM, cone_index_kpa=cone_index_kpa)
    c, model = driven(scenario), bare_rig().model
    late = slice(-2000, None)
    for wheel in (0, 1):
        load = c["load_n"][late, wheel].mean()
        radius, rate = (
            c["rolling_radius_m"][late, wheel].mean(),
            c["spin_radps"][late, wheel].mean(),
        )
        bearing = HINGE_DAMPING_NMSPRAD * rate / radius / load
        skid, towing = free_wheel(mobility(model, wheel, load, cone_index_kpa), bearing)
        drag = (c["resistance_n"] - c["shear_x_n"])[late, wheel].mean()
        assert c["slip"][late, wheel].mean() == pytest.approx(skid, rel=0.02)
        assert drag / load == pytest.approx(towing, rel=0.02)


def test_a_towed_wheel_of_mobility_42_as_published():
    skid, towing = free_wheel(42.0)
    assert (skid, towing) == pytest.approx((-0.006, 0.064), abs=0.0005)


def coast(machine, seconds, speed_mps=2.0):
    """Speeds and loads of a tractor rolling free, clutch out, from a speed; every step."""
    data, model = start(machine), machine.model
    data.qvel[:] *= speed_mps / data.qvel[0]
    set_controls(machine, data, clutch_pedal=1.0)
    speeds, slots = [], []
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        speeds.append(data.qvel[0])
        slots.append(wheels(data))
    return np.array(speeds), np.array(slots), data


@pytest.mark.parametrize("cone_index_kpa", [600.0, 1200.0])
def test_coasting_slows_at_the_rate_of_the_resistance_law(cone_index_kpa):
    """a = -sum W (c0 + m/Bn + ...) / (m + sum I / R**2)"""
    machine = build(soiled(EVEN, cone_index_kpa=cone_index_kpa))
    speeds, slots, _ = coast(machine, 3.1)
    window = slice(500, 1500)
    slots = slots[window].mean(axis=0)
    drag = rolling_mass = 0.0
    for i, wheel in enumerate(block.WHEELS):
        load, radius = slots[i, WheelSlot.LOAD_N], slots[i, WheelSlot.ROLLING_RADIUS_M]
        bn = mobility(machine.model, i, load, cone_index_kpa)
        bearing = HINGE_DAMPING_NMSPRAD * slots[i, WheelSlot.RATE_RADPS] / radius / load
        drag += load * free_wheel(bn, bearing)[1]
        rolling_mass += machine.model.body(f"{wheel}_wheel").inertia.max() / radius**2
    mass = machine.model.body("tractor").subtreemass[0] + rolling_mass
    deceleration = (speeds[500] - speeds[1500]) / (1000 * machine.model.opt.timestep)
    assert deceleration == pytest.approx(drag / mass, rel=0.02)


def test_coasting_gains_no_energy_and_comes_to_rest():
    machine = bare_rig()
    data, model = start(machine), machine.model
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    shaft = int(model.joint("drive").dofadr[0])
    try:
        set_controls(machine, data, clutch_pedal=1.0)
        energies = []
        for _ in range(80):
            mujoco.mj_step(model, data, 50)
            engine = 0.5 * model.dof_armature[shaft] * data.qvel[shaft] ** 2
            deflection = wheels(data)[:, WheelSlot.DEFLECTION_M]
            tyres = 0.5 * np.array([354e3, 354e3, 383e3, 383e3]) @ deflection**2
            energies.append(data.energy.sum() - engine + tyres)
    finally:
        model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    lost = -np.diff(energies)
    assert np.all(lost[2:] > -5.0)  # J in 0.1 s; kinetic energy is 12 kJ, the shear's spring 10 J
    assert energies[0] - energies[-1] > 0.9 * 0.5 * 5260.0 * 2.1**2
    assert abs(data.qvel[0]) < 0.05


def parked_m(machine, *, seconds=60.0, settle_s=5.0, **controls):
    """How far the rear axle's centre moves in a minute, brakes on, after settling."""
    data, model = start(machine, rolling=False), machine.model
    set_controls(machine, data, brake=1.0, clutch_pedal=1.0, **controls)
    mujoco.mj_step(model, data, round(settle_s / model.opt.timestep))
    settled = data.qpos[:3].copy()
    farthest = 0.0
    for _ in range(60):
        mujoco.mj_step(model, data, round(seconds / 60 / model.opt.timestep))
        farthest = max(farthest, float(np.linalg.norm(data.qpos[:3] - settled)))
    assert data.warning.number.sum() == 0
    return farthest


@pytest.mark.parametrize("scenario", [BARE, PLOUGHING], ids=["bare", "plough raised"])
@pytest.mark.parametrize("shape", [{"cross_slope_deg": 18.0}, {"grade_deg": 15.0}])
def test_parked_with_brakes_on_a_slope_it_stays_for_a_minute(scenario, shape):
    assert parked_m(build(field(scenario, **shape))) < 1e-3


def test_parked_on_a_slope_too_slippery_it_slides():
    """tan(18 deg) = 0.325 is more than a friction of 0.25 holds."""
    machine = build(field(soiled(BARE, friction=0.25), cross_slope_deg=18.0))
    assert parked_m(machine, seconds=6.0) > 0.5


@pytest.mark.parametrize("steer", [0.15, -0.3])
def test_turning_the_points_of_the_tractor_move_as_one_body(steer):
    """v_y at the centre of gravity less v_y at the rear axle is b times the yaw rate."""
    machine = bare_rig()
    data, model = start(machine), machine.model
    set_controls(machine, data, throttle=machine.throttle, steer_left=steer, steer_right=steer)
    mujoco.mj_step(model, data, 3000)
    rotation = data.body("tractor").xmat.reshape(3, 3)
    rear = rotation.T @ data.sensor("velocity_w").data
    cg = rotation.T @ data.sensor("cg_velocity_w").data
    yaw_rate = data.sensor("gyro_b").data[2]
    assert cg[1] - rear[1] == pytest.approx(1.0710 * yaw_rate, rel=0.01)
    # and it turns about as Ackermann's bicycle does, sliding a little
    assert yaw_rate == pytest.approx(rear[0] * math.tan(steer) / 2.55, rel=0.15)


@pytest.mark.slow
def test_half_the_time_step_ploughs_with_the_same_slip():
    """Mean slip of the same 28 m of furrow, about 20 s, changes by less than a hundredth."""
    means = []
    for step_s in (0.002, 0.001):
        course = Course(approach_m=3.0, length_m=36.0)
        machine = build(replace(PLOUGHING, course=course, timestep_s=step_s))
        chunks = list(simulate(machine))
        along = np.concatenate([c["position_w"][:, 0] for c in chunks])
        slip = np.concatenate([c["slip"][:, 2:].mean(axis=1) for c in chunks])
        means.append(slip[(along > 12.0) & (along < 40.0)].mean())
    assert means[1] == pytest.approx(means[0], rel=0.01)


def test_all_wheel_drive_pulls_with_the_front_too():
    c = driven(replace(PLOUGHING, drive=replace(PLOUGHING.drive, all_wheel_drive=True)))
    alone = driven(PLOUGHING)
    late = slice(-2000, None)
    assert c["shear_x_n"][late, :2].mean() > 2e3 > alone["shear_x_n"][late, :2].mean()
    assert c["slip"][late, 2:].mean() < alone["slip"][late, 2:].mean()


def test_the_lock_turns_both_rear_wheels_as_one_and_open_they_differ():
    """Along a slope the open differential shares torque, the lock shares speed."""
    slope = field(FIRM, cross_slope_deg=15.0)
    locked = driven(slope)
    open_ = driven(replace(slope, drive=replace(slope.drive, differential_lock=False)))
    late = slice(-2000, None)
    rates = locked["wheel_rate_radps"][late, 2:]
    assert rates[:, 0] == pytest.approx(rates[:, 1], rel=2e-5)
    axle = open_["shear_x_n"] + 0.04 * open_["load_n"]  # shear and rolling moment, over radius
    torque = (axle * open_["rolling_radius_m"])[late, 2:].mean(axis=0)
    assert torque[0] == pytest.approx(torque[1], rel=0.005)
    assert not np.allclose(locked["shear_x_n"][late, 2], locked["shear_x_n"][late, 3], rtol=0.02)
