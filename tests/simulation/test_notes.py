"""A run says where its wheels leave the range of their soil's law."""

import dataclasses

import numpy as np
import pytest

from tests.simulation.rigs import BARE, PLOUGHING, bare_rig, plough_rig, soiled
from twin.pipeline.run import run
from twin.scenario import Course, Field, Scenario, Soil
from twin.simulation.build import build
from twin.simulation.notes import notes, unheld


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


def driven_at(speed_mps):
    """Truth at 50 Hz of a machine with these speeds."""
    epoch_ns = 20_000_000 * np.arange(len(speed_mps), dtype=np.int64)
    return {"epoch_ns": epoch_ns, "speed_mps": np.asarray(speed_mps)}


def test_a_machine_far_faster_than_its_governor_asks_for_a_second_is_noted():
    speed = np.full(500, 2.9)
    assert unheld(2.0, driven_at(speed)) == ()
    speed[100:140], speed[200:240] = 5.0, 5.0  # 0.8 s each
    assert unheld(2.0, driven_at(speed)) == ()
    speed[300:361], speed[400:] = 3.1, 3.5
    (note,) = unheld(2.0, driven_at(speed))
    assert "above 3.0 m/s, 1.5 of what the governor asks, for 3.2 s from 6.0 s on" in note
    assert "up to 5.0 m/s" in note


def test_where_braked_wheels_skid_a_run_notes_it():
    """Wheels on ice down 15 degrees: the engine is held, the tractor is not."""
    down = dataclasses.replace(
        soiled(BARE, friction=0.25), field=Field(grade_deg=-15.0),
        course=Course(approach_m=1, length_m=50),
    )  # fmt: skip
    *_, note = run(down, estimators={}).notes
    assert "of what the governor asks" in note
    held = run(dataclasses.replace(down, soil=Soil()), estimators={}).notes
    assert not any("governor" in note for note in held)
