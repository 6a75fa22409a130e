"""Depth, position, draft, mix and float: what each lets the hitch do, and where the weight goes."""

import math
from functools import cache

import numpy as np
import pytest

from tests.simulation.hitch_rows import NAMES, hitch_row
from tests.simulation.rigs import EVEN_PLOUGHING, PLOUGHING, driven, replace
from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.scenario import Course, Plough, Soil
from twin.simulation.build import build
from twin.simulation.course_task import CONTROL_OF
from twin.simulation.driver import DriverState, DriverTask, Observation, drive, full_depth_m
from twin.simulation.driver import valve_radps as valve
from twin.simulation.simulate import simulate
from twin.simulation.simulation import Simulation

DT_S = 0.02
WORKING = DriverState(lift_rad=0.1, felt_n=20e3, full_depth_at_m=6.0, working=True)
MIX, SENSITIVITY_RAD = {"draft": 1.0, "mix": 0.3}, 0.08


def task(mode, **set_to):
    usual = {
        "wheelbase_m": 2.55, "track_m": 1.8, "approach_m": 5.0, "depth_m": 0.25,
        "full_depth_m": full_depth_m(0.25, mode), "raised_rad": 0.6, "work_rad": 0.1,
        "throttle": 0.5, "hitch": CONTROL_OF[mode], "mix": MIX.get(mode, 0.0),
        "draft_n": 20e3, "sensitivity_rad": SENSITIVITY_RAD, "lowest_rad": -0.2,
    }  # fmt: skip
    return DriverTask(**(usual | set_to))


def valve_radps(task, hitch_rad, felt_n):
    return valve(task, task.mix, hitch_rad, felt_n)


def moved(mode, *, draft_n=20e3, depth_m=0.25, hitch_rad=0.1, seconds=0.2, **set_to):
    """How far the lift is moved while one draft, depth and angle of the links are seen."""
    driver = WORKING._replace(felt_n=draft_n)
    for _ in range(round(seconds / DT_S)):
        seen = Observation(20.0, 0.0, 0.0, depth_m, draft_n, hitch_rad)
        driver = drive(task(mode, **set_to), driver, seen, DT_S)
    return driver.lift_rad - WORKING.lift_rad


def test_draft_control_raises_when_the_draft_rises_and_lowers_when_it_falls():
    """4/s of 0.08 rad per relative error: a tenth too much for 0.2 s raises by 0.0064 rad."""
    assert moved("draft", draft_n=22e3) == pytest.approx(4.0 * 0.08 * 0.10 * 0.2)
    assert moved("draft", draft_n=18e3) == pytest.approx(-4.0 * 0.08 * 0.10 * 0.2)
    assert moved("draft", depth_m=0.20) == 0.0  # it does not look at the depth
    assert moved("draft", hitch_rad=0.12) == 0.0  # nor at the position


def test_position_control_looks_at_the_links_only():
    assert moved("position", hitch_rad=0.09) == pytest.approx(4.0 * 0.01 * 0.2)
    assert moved("position", draft_n=40e3, depth_m=0.1) == 0.0


@pytest.mark.parametrize("mix", [0.0, 0.2, 0.7, 1.0])
@pytest.mark.parametrize(("draft_n", "hitch_rad"), [(23e3, 0.09), (18e3, 0.11)])
def test_the_mix_weighs_position_and_draft(mix, draft_n, hitch_rad):
    alone = [valve_radps(task("mix", mix=end), hitch_rad, draft_n) for end in (0.0, 1.0)]
    mixed = valve_radps(task("mix", mix=mix), hitch_rad, draft_n)
    assert mixed == pytest.approx((1.0 - mix) * alone[0] + mix * alone[1])


def test_the_mix_rests_where_draft_and_position_are_even():
    """(1 - m) (angle - lever) = m S (D - D_0) / D_0"""
    angle = 0.1 + 0.3 / 0.7 * 0.08 * 0.15
    assert valve_radps(task("mix"), angle, 23e3) == 0.0
    assert valve_radps(task("mix"), angle - 0.003, 23e3) > 0.0
    assert valve_radps(task("mix"), angle + 0.003, 23e3) < 0.0


@pytest.mark.parametrize("mode", ["position", "draft", "mix"])
def test_inside_the_dead_band_the_valve_is_shut(mode):
    for error in (-0.4e-3, 0.4e-3):
        assert valve_radps(task(mode), 0.1 + error, 20e3 * (1.0 + error / 0.08)) == 0.0


@pytest.mark.parametrize("mode", ["position", "draft", "mix"])
def test_the_lift_stays_within_its_limits(mode):
    """However small the draft, it does not lower below the limit, and comes back from beyond it."""
    assert valve_radps(task(mode, work_rad=-0.4), -0.2, 0.0) == 0.0
    assert valve_radps(task(mode, work_rad=-0.4), -0.21, 0.0) == pytest.approx(4.0 * 0.01)
    assert valve_radps(task(mode, work_rad=0.8), 0.6, 60e3) == 0.0


def test_the_valve_is_no_faster_than_lift_and_drop_rate():
    assert moved("draft", draft_n=90e3) == pytest.approx(0.35 * 0.2)
    slow = {"work_rad": -0.1, "drop_rate_radps": 0.1}
    assert valve_radps(task("position", **slow), 0.1, 0.0) == -0.1
    assert moved("depth", drop_rate_radps=0.1, work_rad=-0.3) == pytest.approx(-0.1 * 0.2)
    assert moved("float", drop_rate_radps=0.1) == pytest.approx(-0.1 * 0.2)


def test_a_lift_whose_links_something_else_carries_runs_out_no_further():
    assert moved("position", work_rad=-0.1, seconds=5.0) == pytest.approx(-0.05)


def test_depth_control_looks_at_the_depth_only():
    assert moved("depth", depth_m=0.20) == pytest.approx(-0.4 * 0.05 * 0.2)
    assert moved("depth", draft_n=40e3) == 0.0


def test_ripple_of_shear_failure_moves_no_valve():
    """6 Hz of a tenth of the draft moves the lift by less than a millimetre at the links."""
    driver, lifts = WORKING, []
    for k in range(100):
        draft = 20e3 * (1.0 + 0.1 * np.sin(2.0 * np.pi * 6.0 * k * DT_S))
        driver = drive(task("draft"), driver, Observation(20.0, 0.0, 0.0, 0.25, draft, 0.1), DT_S)
        lifts.append(driver.lift_rad)
    assert np.ptp(lifts[50:]) < 1e-3


@cache
def toughened(mode, factor):
    """Means before and after the soil's draft is scaled by a factor; 20 cm, even soil."""
    plough = Plough(depth_m=0.20, hitch=mode)
    course = Course(approach_m=3.0, length_m=60.0)
    simulation = Simulation(build(replace(EVEN_PLOUGHING, plough=plough, course=course)))
    parameters = simulation.batch.expand("numeric_data")[:, -block.SIZE :]
    seen = []
    for decision in range(1400):
        if decision == 900:
            parameters[0, block.SOIL + block.Soil.DRAFT_SCALE] *= factor
        simulation.advance()
        slots = simulation.slots[0]
        wheels = slots[: block.MACHINE_SLOTS].reshape(4, int(WheelSlot.SIZE))
        machine = slots[block.MACHINE_SLOTS :]
        seen.append(
            [
                machine[MachineSlot.DRAFT_N],
                machine[MachineSlot.DEPTH_M],
                wheels[2:, WheelSlot.LOAD_N].sum(),
                machine[MachineSlot.DEPTH_WHEEL_N],
                simulation.drivers["lift_rad"][0],
            ]
        )
    seen = np.array(seen)
    names = ("draft_n", "depth_m", "rear_n", "depth_wheel_n", "lift_rad")
    before, after = seen[800:900].mean(axis=0), seen[1300:].mean(axis=0)
    held_n = float(simulation.tasks["draft_n"][0])
    return dict(zip(names, before, strict=True)), dict(zip(names, after, strict=True)), held_n


def test_draft_control_gives_harder_soil_less_depth_and_keeps_the_draft():
    before, after, held_n = toughened("draft", 1.2)
    assert before["draft_n"] == pytest.approx(held_n, rel=0.02)
    assert after["draft_n"] == pytest.approx(held_n, rel=0.02)
    assert after["depth_m"] < before["depth_m"] - 0.02
    assert after["lift_rad"] > before["lift_rad"] + 0.02
    assert before["depth_wheel_n"] == after["depth_wheel_n"] == 0.0


def test_the_mix_gives_way_by_a_part_of_it():
    before, after, _ = toughened("mix", 1.2)
    held, harder, _ = toughened("position", 1.2)
    assert before["depth_m"] == pytest.approx(0.20, abs=0.003)
    assert harder["depth_m"] > held["depth_m"] + 0.002
    assert after["depth_m"] < before["depth_m"] + 0.001
    assert 1.05 < after["draft_n"] / before["draft_n"] < harder["draft_n"] / held["draft_n"]


def test_before_the_plough_is_at_work_it_is_lowered_at_the_drop_rate():
    driver = WORKING._replace(lift_rad=0.6, felt_n=0.0, full_depth_at_m=math.inf)
    for mode in ("position", "mix", "draft"):
        seen = Observation(20.0, 0.0, 0.0, 0.0, 0.0, 0.6)
        lift = drive(task(mode), driver, seen, DT_S).lift_rad
        assert lift == pytest.approx(0.6 - 0.35 * DT_S)


def test_position_control_takes_the_draft_as_it_comes():
    before, after, _ = toughened("position", 1.2)
    assert after["draft_n"] > 1.15 * before["draft_n"]
    assert before["depth_m"] == pytest.approx(0.20, abs=0.003)
    assert after["depth_m"] == pytest.approx(before["depth_m"], abs=0.005)
    assert abs(after["rear_n"] - before["rear_n"]) < 2e3


def test_depth_control_holds_the_depth():
    before, after, _ = toughened("depth", 1.2)
    assert after["depth_m"] == pytest.approx(0.20, abs=0.002)
    assert before["depth_m"] == pytest.approx(0.20, abs=0.002)


MODES = ("position", "mix", "draft", "float")


@cache
def worked(mode, law, over, seed):
    """Ploughing at 20 cm where the draft is so many times what the operator expects."""
    soil = Soil(law=law)
    expected = soil.resolved.draft_scale
    scenario = replace(
        PLOUGHING,
        soil=replace(soil, draft_scale=over * expected),
        plough=Plough(depth_m=0.20, hitch=mode, expected_draft_scale=expected),
        course=Course(approach_m=3.0, length_m=60.0),
        seed=seed,
    )
    return hitch_row(scenario)


def means(mode, law, over):
    return {n: np.mean([worked(mode, law, over, s)[n] for s in (0, 1)]) for n in NAMES}


@pytest.mark.parametrize(("law", "over"), [("brixius", 0.7), ("bekker", 1.3)])
def test_each_mode_holds_what_it_holds_where_the_draft_is_not_as_expected(law, over):
    """Two seeds; eight, and all there is of the rest, in tests/long."""
    found = {mode: means(mode, law, over) for mode in MODES}
    for mode in ("position", "float"):
        assert found[mode]["depth_m"] == pytest.approx(0.20, abs=0.015)
    assert found["draft"]["draft_over_held"] == pytest.approx(1.0, abs=0.05)
    sds = [found[mode]["slip_sd"] for mode in ("draft", "mix", "position")]
    assert sds == sorted(sds)
    assert found["mix"]["depth_sd_m"] < found["draft"]["depth_sd_m"]


def test_floating_the_lift_carries_nothing():
    scenario = replace(EVEN_PLOUGHING, plough=Plough(depth_m=0.15, hitch="float"))
    c = {n: v[-4000:] for n, v in driven(scenario).items()}
    assert not np.any(c["power_lift_w"])
    simulation = Simulation(build(scenario))
    for _ in range(900):
        simulation.advance()
    lift = simulation.machine.model.actuator("lift").id
    assert simulation.batch.get_data(0).actuator_force[lift] == 0.0
    assert c["depth_wheel_n"].mean() > 10e3  # held by the lift it has about half of 17 kN
    assert c["depth_m"].mean() == pytest.approx(0.15, abs=0.004)


@pytest.mark.parametrize("drop_m", [0.0, 0.2])
def test_floating_the_depth_wheel_carries_what_the_links_do_not(drop_m):
    """The work of a small swing says how much, but for the wheel's drag and the tractor's pitch."""
    scenario = replace(
        EVEN_PLOUGHING, plough=Plough(depth_m=0.15, hitch="float", top_link_drop_m=drop_m)
    )
    machine = build(scenario, setting=build(scenario, settle=False).setting)
    load_n = np.concatenate([c["depth_wheel_n"] for c in simulate(machine)])[-2000:].mean()
    stiffness_npm = machine.numbers["plough.depth_wheel.stiffness_npm"]
    assert load_n == pytest.approx(machine.setting.sag_m * stiffness_npm, rel=0.1)


def test_a_steeper_top_link_puts_more_of_a_floating_plough_on_the_rear_wheels():
    rear_n = []
    for drop_m in (0.0, 0.1, 0.2):
        plough = Plough(depth_m=0.15, hitch="float", top_link_drop_m=drop_m)
        loads = driven(replace(EVEN_PLOUGHING, plough=plough))["load_n"][-2000:, 2:]
        rear_n.append(loads.sum(axis=1).mean())
    assert np.all(np.diff(rear_n) > 2e3)


def test_ballast_rests_on_the_front_wheels_by_its_place():
    front_n = []
    for kg in (100.0, 500.0):
        plough = Plough(depth_m=0.20, front_ballast_kg=kg)
        machine = build(replace(EVEN_PLOUGHING, plough=plough))
        front_n.append(machine.start_load_n[:2].sum())
    model = machine.model
    arm = model.body("front_ballast").pos[0] / model.body("front_axle").pos[0]
    assert front_n[1] - front_n[0] == pytest.approx(400.0 * 9.81 * arm, rel=0.02)


def test_ballast_moves_the_centre_of_gravity_that_sideslip_is_told_at():
    plain, laden = (
        build(replace(EVEN_PLOUGHING, plough=Plough(front_ballast_kg=kg)), settle=False).model
        for kg in (0.0, 400.0)
    )
    moved = laden.site("cg").pos - plain.site("cg").pos
    arm = laden.body("front_ballast").pos - plain.site("cg").pos
    assert moved == pytest.approx(400.0 / (5260.0 + 400.0) * arm)


def test_the_trial_is_on_the_soil_that_is_expected():
    """A wrong belief changes what the hitch is set to, and nothing of the soil."""
    scenario = replace(EVEN_PLOUGHING, plough=Plough(depth_m=0.20, hitch="draft"))
    own = scenario.soil.resolved.draft_scale
    right = build(scenario).setting
    told = replace(scenario, plough=replace(scenario.plough, expected_draft_scale=own))
    assert build(told).setting == right
    low = replace(scenario, plough=replace(scenario.plough, expected_draft_scale=0.8 * own))
    assert build(low).setting.draft_n == pytest.approx(0.8 * right.draft_n, rel=0.05)


def test_where_the_tractor_gets_stuck_in_the_trial_the_linkage_says_how_it_is_set():
    scenario = replace(
        EVEN_PLOUGHING,
        soil=replace(EVEN_PLOUGHING.soil, draft_scale=2.0),
        plough=Plough(depth_m=0.35, hitch="position"),
    )
    assert build(scenario).setting == build(scenario, settle=False).setting
