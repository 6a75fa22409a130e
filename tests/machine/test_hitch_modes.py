"""Depth, position, draft and float: what each lets the hitch do, and where the weight goes."""

from functools import cache

import numpy as np
import pytest

from tests.machine.rigs import EVEN_PLOUGHING, driven, replace
from twin.machine.build import build
from twin.machine.driver import Hands, Observed, Task, drive
from twin.machine.simulate import Cab
from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.scenario import Course, Plough, Soil

DT_S, LEVER_M = 0.02, 1.4
WORKING = Hands(lift_rad=0.1, full_depth_at_m=6.0, working=True)


def task(mode):
    return Task(
        wheelbase_m=2.55, approach_m=5.0, depth_m=0.25, raised_rad=0.6, work_rad=0.1,
        throttle=0.5, hitch=mode, draft_n=20e3,
    )  # fmt: skip


def trim_after(mode, *, draft_n=20e3, depth_m=0.25, seconds=0.2):
    """Correction of the hitch after a while of seeing one draft and depth."""
    hands = WORKING
    for _ in range(round(seconds / DT_S)):
        hands = drive(task(mode), hands, Observed(20.0, 0.0, 0.0, depth_m, draft_n), DT_S)
    return hands.trim_rad


def test_draft_control_raises_when_the_draft_rises_and_lowers_when_it_falls():
    """0.5 rad/s per relative error: a tenth too much for 0.2 s raises by 0.01 rad."""
    assert trim_after("draft", draft_n=22e3) == pytest.approx(0.5 * 0.10 * 0.2)
    assert trim_after("draft", draft_n=18e3) == pytest.approx(-0.5 * 0.10 * 0.2)
    assert trim_after("draft", depth_m=0.20) == 0.0  # it does not look at the depth


@pytest.mark.parametrize("error", [-0.049, -0.02, 0.0, 0.049])
def test_inside_the_dead_band_draft_control_lets_the_hitch_be(error):
    assert trim_after("draft", draft_n=20e3 * (1.0 + error)) == 0.0


@pytest.mark.parametrize("error", [-0.051, 0.051])
def test_outside_the_dead_band_it_acts(error):
    assert trim_after("draft", draft_n=20e3 * (1.0 + error)) * error > 0.0


def test_the_valve_is_no_faster_than_the_lift():
    assert trim_after("draft", draft_n=90e3) == pytest.approx(0.35 * 0.2)


def test_depth_control_looks_at_the_depth_only():
    assert trim_after("depth", depth_m=0.20) == pytest.approx(-0.4 * 0.05 * 0.2)
    assert trim_after("depth", draft_n=40e3) == 0.0


def test_position_control_corrects_nothing():
    assert trim_after("position", draft_n=40e3, depth_m=0.1) == 0.0
    hands = WORKING
    for _ in range(200):
        hands = drive(task("position"), hands, Observed(20.0, 0.0, 0.0, 0.1, 40e3), DT_S)
    assert hands.lift_rad == task("position").work_rad


@cache
def toughened(mode, factor):
    """Means before and after the soil's draft is scaled by a factor; 20 cm, even soil."""
    plough = Plough(depth_m=0.20, hitch=mode)
    course = Course(approach_m=3.0, length_m=60.0)
    cab = Cab(build(replace(EVEN_PLOUGHING, plough=plough, course=course)))
    parameters = cab.batch.expand("numeric_data")[:, -block.SIZE :]
    seen = []
    for decision in range(1400):
        if decision == 900:
            parameters[0, block.SOIL + block.Soil.DRAFT_SCALE] *= factor
        cab.act()
        slots = cab.userdata[0]
        wheels = slots[: block.MACHINE_SLOTS].reshape(4, int(WheelSlot.SIZE))
        machine = slots[block.MACHINE_SLOTS :]
        seen.append(
            [
                machine[MachineSlot.DRAFT_N],
                machine[MachineSlot.DEPTH_M],
                wheels[2:, WheelSlot.LOAD_N].sum(),
                machine[MachineSlot.DEPTH_WHEEL_N],
                cab.hands.lift_rad,
            ]
        )
    seen = np.array(seen)
    names = ("draft_n", "depth_m", "rear_n", "depth_wheel_n", "lift_rad")
    before, after = seen[800:900].mean(axis=0), seen[1300:].mean(axis=0)
    return dict(zip(names, before, strict=True)), dict(zip(names, after, strict=True)), cab.task


def test_draft_control_gives_harder_soil_less_depth_and_the_rear_wheels_more_load():
    """Soil a fifth harder: the draft comes back into the band; the hitch carries what was borne."""
    before, after, task = toughened("draft", 1.2)
    assert after["draft_n"] == pytest.approx(task.draft_n, rel=0.055)
    assert after["depth_m"] < before["depth_m"] - 0.02
    assert after["lift_rad"] > before["lift_rad"] + 0.02
    assert after["rear_n"] > before["rear_n"] + 5e3
    assert after["depth_wheel_n"] < before["depth_wheel_n"] - 2e3


def test_position_control_takes_the_draft_as_it_comes():
    before, after, _ = toughened("position", 1.2)
    assert after["draft_n"] > 1.15 * before["draft_n"]
    assert after["lift_rad"] == before["lift_rad"]
    assert after["depth_m"] == pytest.approx(before["depth_m"], abs=0.005)
    assert abs(after["rear_n"] - before["rear_n"]) < 2e3


def test_depth_control_holds_the_depth():
    before, after, _ = toughened("depth", 1.2)
    assert after["depth_m"] == pytest.approx(0.20, abs=0.002)
    assert before["depth_m"] == pytest.approx(0.20, abs=0.002)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_draft_control_evens_out_a_draft_that_varies(seed):
    """Soil of coefficient 0.15: the draft's own falls by a quarter at least, the depth's grows."""
    soil = Soil(draft_cv=0.15, ripple_cv=0.0, strength_cv=0.0)
    spread, depth_sd = {}, {}
    for mode in ("depth", "draft"):
        course = Course(approach_m=3.0, length_m=60.0)
        plough = Plough(depth_m=0.20, hitch=mode)
        scenario = replace(EVEN_PLOUGHING, soil=soil, course=course, plough=plough, seed=seed)
        c = {n: v[-14000:] for n, v in driven(scenario).items()}
        spread[mode] = c["draft_n"].std() / c["draft_n"].mean()
        depth_sd[mode] = c["depth_m"].std()
    assert spread["draft"] < 0.75 * spread["depth"]
    assert depth_sd["draft"] > 2.0 * depth_sd["depth"]


def test_floating_the_lift_carries_nothing():
    plough = Plough(depth_m=0.15, hitch="float", wheel_share=1.0)
    scenario = replace(EVEN_PLOUGHING, plough=plough)
    c = {n: v[-4000:] for n, v in driven(scenario).items()}
    assert not np.any(c["power_lift_w"])
    cab = Cab(build(scenario))
    for _ in range(900):
        cab.act()
    lift = cab.machine.model.actuator("lift").id
    assert cab.batch.get_data(0).actuator_force[lift] == 0.0
    assert c["depth_wheel_n"].mean() > 10e3  # held by the lift it has about half of 17 kN
    assert c["depth_m"].mean() == pytest.approx(0.15, abs=0.03)
