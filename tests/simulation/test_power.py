"""Where the engine's power goes: the sum closes, and every term is its own closed form."""

import mujoco
import numpy as np
import pytest

from scenarios.plough import CM_25
from scenarios.road import GRAVEL_10
from scenarios.slope import TAISHAN_8
from tests.simulation.rigs import (
    BARE,
    EVEN,
    EVEN_PLOUGHING,
    bare_rig,
    driven,
    field,
    plough_rig,
    replace,
    set_controls,
    start,
)  # fmt: skip
from twin.physics import block
from twin.physics.block import MachineSlot, PowerSlot
from twin.reproduce.passes import LOSSES, power_closure
from twin.scenario import Course, Field
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.truth import truth

LATE = slice(-4000, None)
SHORT = Course(approach_m=3.0, length_m=30.0)
RUNS = {
    "plough": replace(CM_25, course=SHORT),
    "plough, rough ground": replace(CM_25, course=SHORT, field=Field(roughness_class="D")),
    "cross-slope": replace(TAISHAN_8, course=SHORT),
    "road": replace(GRAVEL_10, course=SHORT),
    "uphill": replace(field(BARE, grade_deg=5.0), course=SHORT),
    "four-wheel drive": replace(
        CM_25, course=SHORT, drive=replace(CM_25.drive, all_wheel_drive=True)
    ),
}


@pytest.mark.parametrize("name", RUNS)
def test_all_losses_and_stores_make_up_the_engines_work(name):
    """None is the remainder of the others: they close within 0.3 %, where 1 % would do."""
    chunks = simulate(build(RUNS[name]))
    table = truth.concatenate([truth.sample(chunk, ("rl", "rr")) for chunk in chunks])
    assert abs(power_closure(table)) < 0.003


def test_no_power_is_left_out_of_the_balance():
    columns = {n for n in driven(EVEN_PLOUGHING) if n.startswith("power_")}
    assert columns == {"power_engine_w", *(f"power_{name}_w" for name in LOSSES)}


@pytest.fixture(scope="module")
def ploughing():
    """Means of the powers in steady ploughing, and the columns they come from."""
    c = {n: v[LATE] for n, v in driven(EVEN_PLOUGHING).items()}
    return {n: v.mean() for n, v in c.items() if n.startswith("power_")}, c


def mean(values):
    return float(np.mean(values))


def test_engine_parasites_and_transmission(ploughing):
    power, c = ploughing
    torque, rate = c["engine_torque_nm"], c["engine_radps"]
    assert power["power_engine_w"] == pytest.approx(mean(torque * rate))
    assert power["power_parasitic_w"] == pytest.approx(25.0 * mean(rate))
    lost = (1.0 - 0.87) * mean((torque - 25.0) * rate)
    assert power["power_transmission_w"] == pytest.approx(lost)
    assert power["power_engine_w"] > 40e3


def test_sliding_rolling_and_bearings(ploughing):
    power, c = ploughing
    omega, v = c["spin_radps"], c["wheel_speed_x_mps"]
    sliding = c["shear_x_n"] * (omega * c["rolling_radius_m"] - v)
    assert power["power_slip_long_w"] == pytest.approx(mean(sliding.sum(axis=1)))
    aside = -(c["shear_y_n"] * c["tread_speed_y_mps"]).sum(axis=1)
    assert power["power_slip_lat_w"] == pytest.approx(mean(aside))
    moments = 0.04 * c["load_n"] * c["rolling_radius_m"] * omega
    rolling = (c["resistance_n"] * v + moments).sum(axis=1)
    assert power["power_rolling_w"] == pytest.approx(mean(rolling), rel=1e-3)
    bearings = 2.0 * (c["wheel_rate_radps"] ** 2).sum(axis=1)
    assert power["power_joint_w"] == pytest.approx(mean(bearings), rel=0.05)


def test_the_drawbar_takes_draft_times_speed(ploughing):
    power, c = ploughing
    assert power["power_drawbar_w"] == pytest.approx(
        mean(c["draft_n"] * c["velocity_w"][:, 0]), rel=0.01
    )
    assert power["power_drawbar_w"] > 0.5 * power["power_engine_w"]


def test_in_a_steady_state_springs_brakes_and_lift_take_next_to_nothing(ploughing):
    power, _ = ploughing
    engine = power["power_engine_w"]
    for name in ("brake", "tyre", "wall", "depth_wheel", "lift", "steer", "driveline"):
        assert abs(power[f"power_{name}_w"]) < 0.005 * engine, name
    assert power["power_brake_w"] == 0.0


def test_the_kinetic_store_has_the_reflected_inertia():
    """1/2 m v**2, the wheels, and 2 kg m2 of the engine at the engine's speed."""
    c = {n: v[-1] for n, v in driven(EVEN).items()}
    model = bare_rig().model
    mass = float(model.body("tractor").subtreemass[0])
    wheels = [model.body(f"{w}_wheel").inertia.max() for w in block.WHEELS]
    expected = 0.5 * mass * np.sum(c["cg_velocity_w"] ** 2)
    expected += 0.5 * np.dot(wheels, c["wheel_rate_radps"] ** 2)
    expected += 0.5 * 2.0 * c["engine_radps"] ** 2
    assert c["kinetic_j"] == pytest.approx(expected, rel=2e-3)
    assert 0.5 * 2.0 * c["engine_radps"] ** 2 > 0.5 * c["kinetic_j"]  # most of it


@pytest.mark.parametrize("grade_deg", [6.0, -4.0])
def test_climbing_stores_weight_times_height(grade_deg):
    c = driven(replace(field(EVEN, grade_deg=grade_deg), course=SHORT))
    weight_n = 9.81 * float(bare_rig().model.body("tractor").subtreemass[0])
    late = slice(2000, None)
    potential, along = c["potential_j"][late], c["position_w"][late]
    risen = along[-1, 2] - along[0, 2]
    gone = np.linalg.norm(along[-1] - along[0])
    assert risen == pytest.approx(gone * np.sin(np.radians(grade_deg)), abs=0.02)
    assert potential[-1] - potential[0] == pytest.approx(weight_n * risen, rel=0.003)


def slots_of(data):
    machine = data.userdata[block.MACHINE_SLOTS : block.POWER_SLOTS]
    return machine.copy(), data.userdata[block.POWER_SLOTS : block.SCRATCH_SLOTS].copy()


def test_brakes_take_their_torque_times_the_wheels_rate_and_stop_the_tractor():
    """All brake work, sliding, rolling and bearings together are the kinetic energy there was."""
    machine = build(EVEN)
    data, model = start(machine), machine.model
    set_controls(machine, data, clutch_pedal=1.0)
    mujoco.mj_step(model, data, 500)
    set_controls(machine, data, clutch_pedal=1.0, brake=0.3)
    work, kinetic_j = 0.0, None
    for _ in range(1500):
        mujoco.mj_step(model, data)
        if kinetic_j is None:
            shaft = model.joint("drive").dofadr[0]
            engine = 0.5 * model.dof_armature[shaft] * data.qvel[shaft] ** 2
            kinetic_j = float(data.sensor("kinetic_j").data[0]) - engine
        slots, powers = slots_of(data)
        rates = [data.sensor(f"{w}_rate_radps").data[0] for w in ("rl", "rr")]
        expected = slots[MachineSlot.BRAKE_TORQUE_NM] * np.mean(rates)
        assert powers[PowerSlot.BRAKE] == pytest.approx(expected, rel=1e-2, abs=2.0)
        wheels = (PowerSlot.BRAKE, PowerSlot.SLIP_LONG, PowerSlot.ROLLING, PowerSlot.JOINT,
                  PowerSlot.TYRE)  # fmt: skip
        work += 0.002 * powers[list(wheels)].sum()
    assert abs(data.qvel[0]) < 0.01
    assert work == pytest.approx(kinetic_j, rel=0.03)


def test_lifting_the_plough_takes_its_weight_times_its_rise():
    """From the ground to carried, tractor standing: lift work is what the potential gains."""
    machine = plough_rig()
    data, model = start(machine, rolling=False), machine.model
    set_controls(machine, data, brake=1.0, clutch_pedal=1.0, lift=0.35)
    mujoco.mj_step(model, data, 3000)
    before = float(data.sensor("potential_j").data[0])
    work = 0.0
    for k in range(4000):
        set_controls(machine, data, brake=1.0, clutch_pedal=1.0, lift=min(0.6, 0.35 + k * 1e-4))
        mujoco.mj_step(model, data)
        work += 0.002 * float(data.sensor("lift_nm").data[0] * data.sensor("lift_radps").data[0])
    gained = float(data.sensor("potential_j").data[0]) - before
    assert gained > 2e3
    assert work == pytest.approx(gained, rel=0.1)  # tyres and linkage are squeezed, joints damp


def test_a_stalled_engine_stays_dead_in_the_machine():
    """Below its stall and freed by the clutch it runs down at full throttle; above, it runs up."""
    machine = build(EVEN)
    data, model = start(machine), machine.model
    shaft = int(model.joint("drive").dofadr[0])
    for rpm, lives in ((250.0, False), (900.0, True)):
        data.qvel[shaft] = rpm * np.pi / 30.0 / machine.scenario.gear.ratio
        set_controls(machine, data, throttle=1.0, clutch_pedal=1.0)
        mujoco.mj_step(model, data, 2500)
        turning = machine.scenario.gear.ratio * data.qvel[shaft] * 30.0 / np.pi
        assert (turning > 2000.0) if lives else (abs(turning) < 5.0)
