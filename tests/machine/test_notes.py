"""A run says where its wheels leave the range of their soil's law."""

import dataclasses

import numpy as np
import pytest

from tests.machine.rigs import BARE, PLOUGHING, bare_rig, plough_rig, soiled
from twin.machine.build import build
from twin.machine.notes import notes, overspeed
from twin.run import run
from twin.scenario import Course, Field, Scenario, Soil


def test_the_settled_loads_are_the_weight():
    machine = bare_rig()
    weight_n = 9.81 * machine.model.body("tractor").subtreemass[0]
    assert machine.start_load_n.sum() == pytest.approx(weight_n, rel=1e-3)


def test_a_carried_plough_lifts_the_front_below_what_brixius_measured():
    """W / (b d) by hand, below 15 kPa with the plough and within the range without."""
    machine = plough_rig()
    (note,) = notes(machine)
    load_n = np.mean(machine.start_load_n[:2])
    width_m, diameter_m = (machine.numbers[f"tyre_front.{n}_m"] for n in ("width", "diameter"))
    assert note.startswith("front wheels with the plough carried: W/(b d) = ")
    assert f"{1e-3 * load_n / (width_m * diameter_m):.3g} kPa" in note
    assert notes(bare_rig()) == ()


def test_a_light_tractor_is_outside_on_both_axles():
    machine = build(Scenario(name="light", machine="electric_tractor", soil=Soil(preset="dry")))
    assert {n.split(":")[0] for n in notes(machine)} == {
        "front wheels at rest",
        "rear wheels at rest",
    }


def test_a_soil_that_bears_is_not_noted_and_one_that_does_not_is():
    assert notes(build(soiled(BARE, law="bekker"))) == ()
    soft = {"preset": "sandy-loam-22", "k_phi_kn_per_m_n2": 33.0, "cohesion_kpa": 1.0}
    bogged = notes(build(soiled(BARE, law="bekker", **soft)))
    assert any("does not carry" in note for note in bogged)


def test_a_run_carries_its_notes():
    short = dataclasses.replace(PLOUGHING, plough=None, course=Course(approach_m=1, length_m=3))
    assert run(short, estimators={}).notes == notes(build(short))


def turning(rpm):
    """Truth at 50 Hz of an engine with these speeds."""
    epoch_ns = 20_000_000 * np.arange(len(rpm), dtype=np.int64)
    return {"epoch_ns": epoch_ns, "engine_radps": np.asarray(rpm) * np.pi / 30.0}


def test_an_engine_far_above_its_no_load_speed_for_a_second_is_noted():
    numbers = {"engine.no_load_rpm": 2000.0}
    rpm = np.full(500, 2290.0)
    assert overspeed(numbers, turning(rpm)) == ()
    rpm[100:140], rpm[200:240] = 3000.0, 3000.0  # 0.8 s each
    assert overspeed(numbers, turning(rpm)) == ()
    rpm[300:361], rpm[400:] = 2400.0, 2500.0
    (note,) = overspeed(numbers, turning(rpm))
    assert "above 2300 rpm, 1.15 of its no-load speed, for 3.2 s from 6.0 s on" in note
    assert "up to 3000 rpm" in note


def test_down_a_steep_slope_a_run_notes_its_engine():
    down = dataclasses.replace(
        BARE, plough=None, field=Field(grade_deg=-15.0), course=Course(approach_m=1, length_m=50)
    )
    *_, note = run(down, estimators={}).notes
    assert note.startswith("engine above 2760 rpm")
