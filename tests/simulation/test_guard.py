"""What diverges is named, and what it leaves repeats it to the bit."""

import dataclasses
import itertools
import json
import pickle
import sys

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import BARE, PLOUGHING, replace, soiled
from twin import cli
from twin.errors import BadInput
from twin.io import run_folder as runfolder
from twin.physics import block
from twin.physics.block import Soil, Wheel
from twin.scenario import Field, Patch
from twin.simulation.build import build
from twin.simulation.finite import all_finite
from twin.simulation.guard import FAILURE_FILE, STATES_FILE, Diverged, StateRing, replay
from twin.simulation.simulate import simulate
from twin.simulation.simulation import DECISION_S, Simulation

LAW = """
import math

def pushes(soil, wheel, load_n, slip, side_slip):
    shear = 0.8 * load_n * (1.0 - math.exp(-7.5 * abs(slip)))
    if slip > {most} and soil[2] < {below}:
        return math.nan, 0.0, 0.0, 0.0, 0.0
    return math.copysign(shear, slip), 3.0 * load_n * side_slip, 0.05 * load_n, 0.0, 0.0
"""


@pytest.fixture
def law(tmp_path, monkeypatch):
    """Writes a law that fails beyond a slip where the cone index is low; its name."""
    monkeypatch.chdir(tmp_path)
    written = []

    def write(name, most, below=1e9):
        (tmp_path / f"{name}.py").write_text(LAW.format(most=most, below=below))
        written.append(name)
        return f"{name}:pushes"

    yield write
    for name in written:
        sys.modules.pop(name, None)
    sys.path[:] = [p for p in sys.path if p != str(tmp_path)]


SOFTER = replace(
    PLOUGHING, field=Field(patches=(Patch(start_m=4.0, length_m=9.0, cone_index_factor=0.5),))
)
"""Softer from 4 m on, so that a law fails there and not while the machine settles."""


def failure_of(scenario):
    machine = build(scenario)
    with pytest.raises(Diverged) as caught:
        for _ in simulate(machine):
            pass
    return caught.value


def left(error, folder):
    folder.mkdir()
    error.evidence.write(folder)
    return folder


def test_a_law_that_fails_is_named_with_time_wheel_and_scenario(law, tmp_path):
    error = failure_of(soiled(SOFTER, law=law("failing_law", 0.1, 900.0)))
    failure = error.evidence.failure
    assert failure.quantity in ("shear_x_n of wheel rl", "shear_x_n of wheel rr")
    assert np.isnan(failure.value)
    text = (
        f"{failure.quantity} is nan at {failure.time_s:.3f} s of the run of 'test-plough' (seed 4)"
    )
    assert str(error) == text
    assert failure.time_s > 1.0


def test_the_folder_repeats_the_last_second_to_the_bit(law, tmp_path):
    error = failure_of(soiled(SOFTER, law=law("repeated_law", 0.1, 900.0)))
    folder = left(error, tmp_path / "failed")
    seen = replay(folder)
    assert seen.failure.time_s == error.evidence.failure.time_s
    assert seen.failure.quantity == error.evidence.failure.quantity
    with np.load(folder / STATES_FILE) as kept:
        states, steps = kept["states"], int(kept["steps"])
    assert len(states) * DECISION_S == pytest.approx(1.0)
    assert np.array_equal(seen.states[::steps], states)
    assert np.all(np.isfinite(seen.states))  # all before the failure


def test_what_fails_while_settling_is_caught_there(law, tmp_path):
    with pytest.raises(Diverged, match=r"of settling 'test-bare' \(seed 0\)") as caught:
        build(soiled(BARE, law=law("never_law", -2.0)))
    seen = replay(left(caught.value, tmp_path / "failed"))
    assert seen.failure.time_s == caught.value.evidence.failure.time_s == 0.0


SPOILT = {
    "a soil's number": (block.SOIL + Soil.CONE_INDEX_KPA, "soil cone_index_kpa"),
    "a tyre's stiffness": (block.WHEEL + Wheel.STIFFNESS_NPM, "of wheel fl"),
}


@pytest.mark.parametrize("what", SPOILT)
def test_a_spoilt_parameter_is_caught_within_a_decision(what, tmp_path):
    at, says = SPOILT[what]
    machine = build(BARE)
    machine.model.numeric_data[machine.model.nnumericdata - block.SIZE + at] = np.nan
    simulation = Simulation(machine)
    with pytest.raises(Diverged) as caught:
        simulation.advance()
    assert caught.value.evidence.failure.time_s == 0.0
    assert says in str(caught.value) or "wheel fl" in str(caught.value)
    seen = replay(left(caught.value, tmp_path / "failed"))
    assert seen.failure.quantity == caught.value.evidence.failure.quantity


def test_a_state_that_is_no_number_names_its_joint():
    simulation = Simulation(build(BARE))
    simulation.advance()
    simulation.qvel[0, simulation.machine.model.joint("rl_spin").dofadr[0]] = np.inf
    with pytest.raises(Diverged) as caught:
        simulation.advance()
    assert caught.value.evidence.failure.time_s == pytest.approx(DECISION_S)
    assert "rl" in str(caught.value)


def test_a_number_too_large_is_a_failure_too():
    """MuJoCo warns beyond 1e10, though it is finite."""
    simulation = Simulation(build(BARE))
    simulation.qvel[0, 0] = 1e12
    with pytest.raises(Diverged):
        simulation.advance()


def test_nothing_is_printed_and_no_log_is_written(law, tmp_path, capfd):
    failure_of(soiled(SOFTER, law=law("quiet_law", 0.1, 900.0)))
    out = capfd.readouterr()
    assert (out.out, out.err) == ("", "")
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()
    assert mujoco.get_mju_user_warning() is None


def test_at_the_command_line_it_is_one_line_and_a_folder(law, tmp_path, capsys):
    spec = law("command_law", 0.1)
    status = cli.main(["run", "plough-25cm", "--soil.law", spec, "--course.approach-m", "1"])
    (line,) = capsys.readouterr().err.splitlines()
    assert status == 2
    assert "'plough-25cm' (seed 0)" in line
    assert "runs/failed-plough-25cm-seed0 repeats it" in line
    assert [p.name for p in (tmp_path / "runs").iterdir()] == ["failed-plough-25cm-seed0"]
    folder = tmp_path / "runs" / "failed-plough-25cm-seed0"
    failure = replay(folder).failure
    assert json.loads((folder / FAILURE_FILE).read_text())["time_s"] == failure.time_s
    # again: the folder is replaced, not refused
    assert cli.main(["run", "plough-25cm", "--soil.law", spec, "--course.approach-m", "1"]) == 2
    assert "repeats it" in capsys.readouterr().err


def test_another_folder_of_that_name_is_left_alone(law, tmp_path, capsys):
    taken = tmp_path / "runs" / "failed-plough-25cm-seed0"
    taken.mkdir(parents=True)
    (taken / "diary.txt").write_text("mine")
    assert cli.main(["run", "plough-25cm", "--soil.law", law("taken_law", -2.0)]) == 2
    assert "could not be written" in capsys.readouterr().err
    assert [p.name for p in taken.iterdir()] == ["diary.txt"]


def test_an_edited_law_or_a_damaged_folder_is_refused(law, tmp_path):
    spec = law("edited_guard_law", -2.0)
    with pytest.raises(Diverged) as caught:
        build(soiled(BARE, law=spec))
    folder = left(caught.value, tmp_path / "failed")
    law("edited_guard_law", 0.5)
    sys.modules.pop("edited_guard_law")
    with pytest.raises(BadInput, match="has been edited"):
        replay(folder)
    (folder / STATES_FILE).unlink()
    with pytest.raises(BadInput, match="does not repeat"):
        replay(folder)
    with pytest.raises(BadInput, match="does not repeat"):
        replay(tmp_path / "nowhere")


def test_the_error_travels_between_processes(law):
    with pytest.raises(Diverged) as caught:
        build(soiled(BARE, law=law("travelled_law", -2.0)))
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value)
    assert np.array_equal(again.evidence.states, caught.value.evidence.states)


@pytest.mark.parametrize("count", [0, 1, 49, 50, 51, 120])
def test_the_ring_holds_the_last_states_of_each_in_order(count):
    ring = StateRing((2, 3), 50)
    for k in range(count):
        ring.keep(np.array([[k, 0, 0], [-k, 0, 0]], dtype=float))
    kept = np.arange(max(0, count - 50), count)
    assert np.array_equal(ring.states()[:, 0], kept)
    assert np.array_equal(ring.states(1)[:, 0], -kept)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200])
def test_one_bad_number_anywhere_is_seen(value):
    good = np.linspace(-1e9, 1e9, 24).reshape(2, 12)
    assert all_finite(good)
    for k in itertools.product(range(2), range(12)):
        bad = good.copy()
        bad[k] = value
        assert not all_finite(bad)


def test_a_good_run_leaves_nothing():
    short = replace(BARE, course=dataclasses.replace(BARE.course, length_m=2.0))
    assert sum(len(c) for c in simulate(build(short))) > 500


def test_the_failed_folder_is_written_whole(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    class Broken:
        scenario = BARE

        def write(self, directory):
            (directory / "half").write_text("x")
            raise BadInput("no more room")

    with pytest.raises(BadInput):
        runfolder.write_failed(Broken())
    assert not (tmp_path / "runs").exists()
