"""Drives in which things happen: the power balance closes, and they happen."""

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.simulation.closure import balance
from twin.errors import BadInput
from twin.scenario import Course, Driver, Event, Field, Plough, Scenario
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.trajectory.phase import Phase
from twin.vehicle import files

BARE = Scenario(name="test-events", course=Course(approach_m=5.0, length_m=20.0))
PLOUGHING = Scenario(
    name="test-events", plough=Plough(), field=Field(roughness_class="C"),
    course=Course(approach_m=15.0, length_m=20.0),
)  # fmt: skip
UP, DOWN = Field(grade_deg=15.0), Field(grade_deg=-15.0)
STOP, BACK = Event(do="stop", at_s=4.0, for_s=2.0), Event(do="reverse", at_s=4.0, distance_m=3.0)


def synchronised(scenario, **more):
    machine = files.machine(scenario.machine)
    gears = replace(machine.transmission, kind="synchronised")
    return replace(scenario, machine_numbers=replace(machine, transmission=gears), **more)


SHIFTS = (Event(do="shift", at_s=9.0, by=1), Event(do="shift", at_s=12.0, by=-2))
ROWS = {
    "stop and restart on 15 degrees up": replace(BARE, field=UP, events=(STOP,)),
    "stop and restart on 15 degrees down": replace(BARE, field=DOWN, events=(STOP,)),
    "reverse on 15 degrees": replace(BARE, field=UP, events=(BACK,)),
    "reverse with the plough": replace(PLOUGHING, events=(replace(BACK, at_s=11.0),)),
    "brake": replace(BARE, events=(Event(do="brake", at_s=4.0, pedal=0.5, for_s=1.0),)),
    "clutch": replace(PLOUGHING, events=(Event(do="clutch", at_s=10.0, pedal=1.0, for_s=2.0),)),
    "powershift under load": replace(PLOUGHING, events=SHIFTS),
    "synchronised under load": synchronised(PLOUGHING, events=SHIFTS),
    "stepless under load": replace(
        PLOUGHING, machine="jd_8245r", events=(Event(do="shift", at_s=9.0, kmh=5.0),)
    ),
    "electric": replace(BARE, machine="electric_tractor", events=(STOP, replace(BACK, at_s=12.0))),
    "lug and recover": replace(
        PLOUGHING, driver=Driver(shifts=True), events=(Event(do="shift", at_s=2.0, by=4),)
    ),
    "headland with backing": replace(
        PLOUGHING, driver=Driver(headland_rpm=1000.0),
        course=Course(approach_m=15.0, length_m=8.0, passes=2, headland="backing"),
    ),
    "engine off and on": replace(BARE, events=(replace(STOP, for_s=5.0, engine_off=True),)),
    "front drive and lock": replace(
        PLOUGHING, events=(
            Event(do="front_drive", at_s=8.0, engaged=True), Event(do="shift", at_s=10.0, by=-1),
            Event(do="lock", at_s=12.0, engaged=False),
            Event(do="front_drive", at_s=14.0, engaged=False),
        ),
    ),
    "a tank is filled": replace(
        BARE, events=(STOP, Event(do="mass", at_s=5.0, mass_kg=300.0, rate_kgps=100.0))
    ),
    "lift, lower, another depth, a full tank": replace(
        PLOUGHING, course=Course(length_m=30.0), events=(
            Event(do="lift", at_s=10.0), Event(do="lower", at_s=13.0),
            Event(do="depth", at_s=16.0, depth_m=0.18),
            Event(do="mass", at_s=17.0, mass_kg=300.0, rate_kgps=100.0),
        ),
    ),
    "from a stand": replace(PLOUGHING, driver=Driver(starts_standing=True, shifts=True)),
    "road there and back": replace(
        PLOUGHING, driver=Driver(road_kmh=20.0, shifts=True, starts_standing=True),
        course=Course(approach_m=15.0, length_m=5.0, passes=2, road_m=40.0),
    ),
}  # fmt: skip


@cache
def drive(name):
    """Chunks of a row's drive, and its columns."""
    chunks = list(simulate(build(ROWS[name])))
    return chunks, {n: np.concatenate([c[n] for c in chunks]) for n in chunks[0].columns}


def speed_mps(columns):
    return columns["wheel_speed_x_mps"][:, 2:].mean(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_energy_closes_and_the_course_is_driven(name):
    chunks, columns = drive(name)
    found = balance(chunks)
    assert abs(found.missing_j) < 1e-3 * abs(found.engine_j)
    assert found.closes
    assert chunks[-1].end.as_planned
    for column, values in columns.items():
        bare = ROWS[name].plough is None and column in (
            "laser_m", "inclination_rad", "plough_pitch_rad"
        )  # fmt: skip
        assert bare or np.isfinite(values).all(), column


@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_the_gear_is_one_that_the_machine_has_and_changes_its_way_at_a_stand(name):
    _, columns = drive(name)
    ratio, box = columns["gear_ratio"], ROWS[name].gearbox
    if box.stepless:
        assert np.all((np.abs(ratio) >= box.ratios[1]) & (np.abs(ratio) <= box.ratios[0]))
    else:
        assert set(np.abs(ratio).tolist()) <= set(box.ratios)
    turned = np.flatnonzero(np.diff(np.sign(ratio)))
    assert np.all(np.abs(speed_mps(columns)[turned]) < 0.3)


@pytest.mark.slow
def test_a_stop_stands_and_does_not_roll_back():
    _, columns = drive("stop and restart on 15 degrees up")
    stopped = columns["phase"] == Phase.STOP
    speed = speed_mps(columns)
    standing = stopped & (np.abs(speed) < 0.02)
    assert np.sum(standing) * 0.002 == pytest.approx(2.0, abs=1.0)
    place_m = np.cumsum(np.where(speed < 0.0, speed, 0.0)) * 0.002
    assert place_m[-1] > -0.1


@pytest.mark.slow
def test_backing_goes_back_with_the_plough_up():
    _, columns = drive("reverse with the plough")
    back = speed_mps(columns) < -0.3
    assert np.sum(speed_mps(columns)[back]) * 0.002 == pytest.approx(-3.0, abs=0.5)
    assert columns["depth_m"][back].max() < 0.1


@pytest.mark.slow
def test_an_engine_that_lugs_is_shifted_down_until_it_runs():
    _, columns = drive("lug and recover")
    used = columns["gear_ratio"]
    fastest = used.min()
    after = np.flatnonzero(used == fastest)[-1]
    assert used[-1] > fastest
    assert columns["engine_radps"][after:].min() > 300.0 * np.pi / 30.0
    assert columns["engine_radps"][-500:].mean() > 1200.0 * np.pi / 30.0


@pytest.mark.slow
def test_an_engine_that_was_off_runs_again():
    _, columns = drive("engine off and on")
    assert columns["engine_radps"].min() == pytest.approx(0.0, abs=0.5)
    assert np.median(columns["fuel_lph"][columns["engine_radps"] < 1.0]) == 0.0
    assert columns["engine_radps"][-1] > 150.0


@pytest.mark.slow
def test_a_headland_with_backing_ends_on_the_next_line():
    _, columns = drive("headland with backing")
    place = columns["position_w"]
    assert speed_mps(columns).min() < -0.5
    assert abs(place[-1, 1]) == pytest.approx(1.4, abs=0.15)
    assert {Phase.ROAD, Phase.TURN, Phase.WORK} == set(columns["phase"])


@pytest.mark.slow
def test_the_road_leads_to_the_field_and_back():
    _, columns = drive("road there and back")
    place = columns["position_w"]
    assert place[0, 0] == pytest.approx(-40.0, abs=0.05)
    assert place[-1, 0] == pytest.approx(-40.0, abs=1.0)
    assert columns["phase"][0] == columns["phase"][-1] == Phase.ROAD
    assert speed_mps(columns).max() > 3.5


@pytest.mark.slow
def test_mass_is_carried_from_then_on():
    _, columns = drive("a tank is filled")
    load, second = columns["load_n"].sum(axis=1), round(1.0 / 0.002)
    before, after = load[2 * second : 4 * second].mean(), load[-second:].mean()
    assert after - before == pytest.approx(300.0 * 9.81, rel=0.01)


def test_more_than_a_machine_carries_is_refused():
    filled = tuple(Event(do="mass", at_s=t, mass_kg=50.0) for t in (1.0, 2.0))
    light = replace(BARE, machine="electric_tractor", plough=None, events=filled)
    with pytest.raises(BadInput, match="fill in 100 kg, but the machine weighs 115 kg; at most 69"):
        build(light)
    emptied = replace(filled[1], mass_kg=-40.0)
    build(replace(light, events=(filled[0], emptied)))


def test_a_laden_light_machine_is_held_by_its_brake_without_chatter():
    """On a grade, with as much as it carries: its wheels neither swing nor take energy."""
    laden = replace(
        BARE, machine="electric_tractor", plough=None, field=Field(grade_deg=7.0),
        events=(
            Event(do="mass", at_s=0.2, mass_kg=69.0, rate_kgps=100.0),
            Event(do="stop", at_s=2.0, for_s=4.0),
        ),
    )  # fmt: skip
    chunks = list(itertools.takewhile(lambda c: c.epoch_ns[-1] < 9e9, simulate(build(laden))))
    stands = np.concatenate([c["phase"] for c in chunks]) == Phase.STOP
    spin = np.concatenate([c["spin_radps"] for c in chunks])[stands][500:, 2:]
    assert len(spin) > 1000
    assert abs(spin[:, 0] - spin[:, 1]).max() < 0.02
    assert balance(chunks).closes


@pytest.mark.slow
def test_another_depth_is_worked_at():
    _, columns = drive("lift, lower, another depth, a full tank")
    assert columns["depth_m"][-1000:].mean() == pytest.approx(0.18, abs=0.02)


def test_same_seed_same_bits():
    scenario = replace(BARE, events=(STOP, Event(do="shift", at_s=8.0, by=2)))
    first, second = ([c["position_w"] for c in simulate(build(scenario))] for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_a_trial_furrow_and_a_calibration_have_no_events():
    from twin.simulation.calibration import legs
    from twin.simulation.trial import _expected

    late = (Event(do="lower", at_m=60.0), Event(do="lift", at_m=90.0))
    course = Course(length_m=100.0, calibration_m=20.0)
    scenario = replace(PLOUGHING, course=course, events=late, driver=Driver(shifts=True))
    parts = (_expected(scenario, scenario.plough), *legs(scenario))
    assert all(part.events == () and part.driver == Driver() for part in parts)
