"""Trials, intervals and the command."""

import json

import numpy as np
import pytest

from twin.cli import main
from twin.control import policy
from twin.control.baselines import BASELINES
from twin.control.compare import compare, rows
from twin.control.judged import quantities
from twin.control.trials import ENVIRONMENTS, HELD_OUT, TRAINING, drive
from twin.env.vector import PloughVectorEnv


def test_differences_are_paired():
    """Grounds differ much, controllers by a constant: the difference has no interval left."""
    ground = np.array([0.1, 0.5, 0.9])
    names = quantities("Plough-v0")
    made = {n: dict.fromkeys(names, ground + d) for n, d in (("pi", 0.0), ("mine", 0.05))}
    last = rows(made)[-1]
    assert (last["case"], last["ours"]) == ("mine", pytest.approx(0.05))
    assert last["high"] - last["low"] == pytest.approx(0.0, abs=1e-12)


def test_held_out_grounds_are_never_trained_on():
    assert HELD_OUT - TRAINING > 900_000


@pytest.fixture(scope="module")
def trials():
    env = PloughVectorEnv(3, observation="truth")
    return [drive(env, BASELINES[n], [5, 6, 7], 8.0) for n in ("pi", "pi", "constant")]


def test_the_same_grounds_give_the_same_numbers(trials):
    for name, values in trials[0].items():
        np.testing.assert_array_equal(values, trials[1][name])
    assert np.any(trials[0]["reward"] != trials[2]["reward"])


def test_what_is_measured_is_a_tractor_s(trials):
    seen = trials[0]
    assert np.all((seen["work_rate"] > 0.3) & (seen["work_rate"] < 1.5))  # ha/h
    assert np.all((seen["fuel"] > 8.0) & (seen["fuel"] < 60.0))  # L/ha, ploughing 15 to 40
    assert np.all((seen["traction_efficiency"] > 0.2) & (seen["traction_efficiency"] < 0.95))
    assert np.all(seen["stalled"] == 0.0)


def test_what_is_measured_of_a_pull_is_the_electric_tractor_s():
    seen = compare({"constant": ENVIRONMENTS["WheelSlip-v0"][1]["constant"]}, 3, 6.0, "truth",
                   environment="WheelSlip-v0").measured["constant"]  # fmt: skip
    assert seen.keys() == quantities("WheelSlip-v0").keys()
    assert np.all((seen["speed"] > 0.5) & (seen["speed"] < 3.0))
    assert np.all((seen["traction_efficiency"] > 0.2) & (seen["traction_efficiency"] < 0.95))
    assert np.all(seen["slip_rms_error"] < 0.6)


def test_both_ways_of_seeing_drive_the_same_grounds():
    done = {
        m: compare({"pi": BASELINES["pi"]}, 2, 6.0, m).measured["pi"] for m in ("truth", "estimate")
    }
    np.testing.assert_allclose(done["truth"]["work_rate"], done["estimate"]["work_rate"], atol=0.1)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_features_are_of_order_one_and_the_policy_adds_to_the_pi_and_holds(name):
    class Model:
        calls = 0

        def predict(self, observation, deterministic):
            Model.calls += 1
            assert observation.shape == (2, task.size)
            assert np.abs(observation).max() <= 5.0
            return np.full((2, len(task.reach)), 0.5), None

    task, base = policy.TASKS[name], policy.TASKS[name].base
    env = ENVIRONMENTS[name][0](2, observation="truth")
    names = [e.name for e in env.entries]
    observation, _ = env.reset(seed=0)
    driver, alone = policy.Policy(Model(), task), base.init(2)
    state = driver.init(2)
    for _ in range(20):
        seen = dict(zip(names, observation.T.astype(float), strict=True))
        state, action = driver.act(state, seen, 0.02)
        alone, own = base.act(alone, seen, 0.02)
        np.testing.assert_array_equal(action, np.clip(own + 0.5 * np.array(task.reach), -1, 1))
        observation = env.step(action.astype(np.float32))[0]
    assert Model.calls == 2


@pytest.mark.slow
def test_the_command_prints_and_writes_rows(tmp_path, capsys):
    file = tmp_path / "rows.json"
    asked = ["--episodes", "2", "--duration-s", "6", "--observation", "truth", "--json", str(file)]
    assert main(["compare-controllers", *asked]) == 0
    said = capsys.readouterr().out
    written = json.loads(file.read_text())["rows"]
    assert {row["case"] for row in written} == set(BASELINES)
    assert {row["quantity"] for row in written} >= set(quantities("Plough-v0"))
    assert all(name in said for name in BASELINES)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--episodes", "1"], "episodes = 1 is outside"),
        (["--observation", "sensors"], "no observation is called 'sensors'"),
        (["--json", "nowhere/rows.json"], "there is no directory nowhere"),
    ],
)
def test_what_cannot_be_is_one_line(arguments, said, capsys):
    assert main(["compare-controllers", *arguments]) == 2
    assert said in capsys.readouterr().err
