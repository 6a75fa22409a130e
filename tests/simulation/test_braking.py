"""The brake pedal: what holds a machine downhill, and when it is left alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.simulation.rigs import BARE, PLOUGHING, bare_rig, driven, field, soiled
from twin.physics import block
from twin.physics.block import Coupling
from twin.reproduce.passes import power_closure
from twin.scenario import Course, Drive, Plough, Scenario, Soil
from twin.simulation.braking import BrakePedal, Drivetrain, governed_radps, press
from twin.simulation.build import build
from twin.simulation.course_task import asked_mps, drivetrain
from twin.simulation.ends import OVERSPEED
from twin.simulation.simulate import simulate
from twin.trajectory.end import Outcome
from twin.truth import truth

DT_S = 0.02
DOWN = replace(BARE, course=Course(approach_m=1.0, length_m=40.0))
ELECTRIC = Scenario(
    name="electric", machine="electric_tractor", soil=Soil(preset="dry"),
    drive=Drive(gear_ratio=50.0, engine_set_rpm=2400.0),
    course=Course(approach_m=1.0, length_m=8.0),
)  # fmt: skip
DRIVES = {
    **{
        f"{machine}, gear {ratio:g}": replace(
            scenario, drive=replace(scenario.drive, gear_ratio=ratio, engine_set_rpm=set_rpm)
        )
        for machine, scenario in {
            "bare": DOWN,
            "plough carried": replace(DOWN, plough=Plough(furrow="none"),
                                      course=Course(approach_m=25.0, length_m=1.0)),
            "asphalt": soiled(DOWN, preset="asphalt"),
        }.items()
        for ratio, set_rpm in ((66.0, 1665.0), (45.0, 1665.0), (30.0, 1665.0), (20.0, 2400.0))
    },
    "electric": ELECTRIC,
    "electric, no gear to speak of": replace(
        soiled(ELECTRIC, preset="asphalt"), drive=Drive(gear_ratio=15.0, engine_set_rpm=3000.0)
    ),
}  # fmt: skip


@pytest.mark.parametrize("grade_deg", [-6.0, -15.0])
@pytest.mark.parametrize("what", DRIVES)
def test_downhill_the_engine_stays_below_its_limit(what, grade_deg):
    scenario = field(DRIVES[what], grade_deg=grade_deg)
    rpm = driven(scenario)["engine_radps"] * 30.0 / np.pi
    assert rpm.max() < OVERSPEED * build(scenario).numbers["engine.no_load_rpm"]


def whole(scenario):
    chunks = list(simulate(build(scenario)))
    return truth.concatenate([truth.sample(c, ("rl", "rr")) for c in chunks]), chunks[-1].end


def test_what_the_engine_does_not_take_the_brakes_do_and_the_powers_close():
    """Down 15 degrees in a high gear: m g sin v = engine + brakes + rolling, sliding, gears."""
    steep = replace(
        field(DOWN, grade_deg=-15.0), drive=Drive(gear_ratio=30.0),
        course=Course(approach_m=1.0, length_m=100.0),
    )  # fmt: skip
    table, end = whole(steep)
    assert end.outcome is Outcome.DRIVEN
    engine_j = truth.PERIOD_NS * 1e-9 * table["power_engine_w"].sum()
    fallen_j = table["potential_j"][0] - table["potential_j"][-1]  # the source here
    assert abs(power_closure(table) * engine_j) < 0.003 * fallen_j
    late = slice(len(table["epoch_ns"]) // 2, None)
    weight_n = 9.81 * float(bare_rig().model.body("tractor").subtreemass[0])
    down_w = weight_n * np.sin(np.radians(15.0)) * table["speed_mps"][late].mean()
    brake_w, engine_w = (table[f"power_{n}_w"][late].mean() for n in ("brake", "engine"))
    assert brake_w > 0.25 * down_w
    assert -engine_w > 0.15 * down_w
    assert 0.05 < (down_w - brake_w + engine_w) / down_w < 0.7  # tyres and gears


def test_the_speed_settles_just_above_what_the_governor_asks():
    steep = replace(field(DOWN, grade_deg=-15.0), drive=Drive(gear_ratio=30.0))
    rpm = driven(replace(steep, course=Course(approach_m=1.0, length_m=120.0)))["engine_radps"]
    assert rpm[-2000:].mean() * 30.0 / np.pi == pytest.approx(1.05 * 1665.0, rel=0.01)


def test_an_exhaust_brake_spares_the_others():
    steep = field(DOWN, grade_deg=-15.0)
    gear = Drive(gear_ratio=45.0)
    without, closed = (
        driven(replace(steep, drive=replace(gear, exhaust_brake=x)))["power_brake_w"][3000:].mean()
        for x in (False, True)
    )
    assert 0.0 < closed < 0.5 * without


def test_an_electric_motor_takes_back_no_more_than_its_battery_does():
    """Without brakes at first: 3000 rpm and 15 degrees ask for more than 500 W."""
    steep = field(DRIVES["electric, no gear to speak of"], grade_deg=-15.0)
    power = driven(replace(steep, course=Course(approach_m=1.0, length_m=40.0)))
    assert power["power_engine_w"].min() == pytest.approx(-500.0, rel=1e-6)
    assert power["power_brake_w"][-1000:].mean() > 100.0


def test_brakes_too_weak_for_the_slope_let_it_run_away_and_the_drive_says_so():
    weak = soiled(
        replace(field(DOWN, grade_deg=-15.0), drive=Drive(gear_ratio=20.0, engine_set_rpm=2400.0),
                course=Course(approach_m=1.0, length_m=300.0)), preset="asphalt",
    )  # fmt: skip
    machine = build(weak)
    machine.numbers["brake.capacity_nm"] = 1000.0
    for which in (3, 4):
        at = block.COUPLING + which * int(Coupling.SIZE) + int(Coupling.CAPACITY_NM)
        machine.model.numeric_data[-block.SIZE + at] = 1000.0
    *_, last = simulate(machine)
    assert last.end.outcome is Outcome.RAN_AWAY
    assert last.end.measured > 1.15 * 2400.0
    assert "its brakes do not hold it" in str(last.end)


@pytest.mark.parametrize("scenario", [BARE, PLOUGHING, field(BARE, grade_deg=8.0)])
def test_on_the_level_and_uphill_the_pedal_is_not_touched(scenario):
    assert np.all(driven(scenario)["power_brake_w"] == 0.0)


KNOWN = Drivetrain(
    gear_ratio=66.0, idle_rpm=800.0, no_load_rpm=2400.0, mps_per_radps=0.01, pedal_per_mps2=0.15
)


def after(seconds, engine_radps, asked_radps, pedal=None):
    pedal = pedal or BrakePedal(asked_radps=asked_radps)
    for _ in range(round(seconds / DT_S)):
        pedal = press(KNOWN, pedal, engine_radps, asked_radps, DT_S)
    return pedal


def test_five_per_cent_are_left_to_the_engine():
    assert after(10.0, 1.049 * 170.0, 170.0).pedal == 0.0
    assert after(1.0, 1.10 * 170.0, 170.0).pedal > 0.0


def test_the_pedal_lags_behind_and_is_pressed_the_harder_the_longer():
    fast = 1.5 * 170.0
    pedals = [after(t, fast, 170.0).pedal for t in (0.02, 0.2, 0.5, 2.0, 60.0)]
    assert np.all(np.diff(pedals) >= 0.0)
    assert pedals[0] < 0.2 * pedals[1] + 0.1
    assert pedals[-1] == 1.0
    assert after(5.0, 160.0, 170.0, after(60.0, fast, 170.0)).pedal < 1.0
    assert after(30.0, 160.0, 170.0, after(60.0, fast, 170.0)).pedal == 0.0


def test_a_throttle_that_is_closed_gives_the_engine_time():
    """The speed asked for falls by 0.5 m/s2: 50 rad/s2 in this gear."""
    pedal = after(0.5, 170.0, 100.0, BrakePedal(asked_radps=170.0))
    assert pedal.asked_radps == pytest.approx(145.0)
    assert after(2.0, 100.0, 100.0, BrakePedal(asked_radps=170.0)).pedal == 0.0
    assert after(0.02, 100.0, 170.0, BrakePedal(asked_radps=100.0)).asked_radps == 170.0


def test_a_driver_knows_his_gear_and_his_brakes():
    machine = bare_rig()
    known = drivetrain(machine)
    mass_kg = float(machine.model.body("tractor").subtreemass[0])
    assert known.pedal_per_mps2 == pytest.approx(mass_kg * 0.8489 / 30e3, rel=1e-6)
    assert known.mps_per_radps == pytest.approx(0.8489 / 66.0)
    asked = [governed_radps(known, throttle) for throttle in (0.0, 1.0, 7.0)]
    assert np.array(asked) * 30.0 / np.pi == pytest.approx([800.0, 2400.0, 2400.0])
    assert asked_mps(machine) == pytest.approx(1665.0 * np.pi / 30.0 * 0.8489 / 66.0)
