"""A controller at the levers of a scenario's run."""

import numpy as np
import pytest

import twin
from twin.cli import main
from twin.control.controllers import hitch_action
from twin.control.on_machine import ENTRIES, controlled_by
from twin.errors import BadInput

SHORT = {"course.length_m": 8.0, "course.approach_m": 6.0}


class Watches:
    """Ploughs at 0.15 m, and keeps what it saw."""

    def __init__(self):
        self.seen = []

    def init(self, setup):
        return None

    def act(self, state, observation):
        self.seen.append(observation)
        return None, (0.5, hitch_action(0.15))


@pytest.fixture(scope="module")
def driven():
    mine = Watches()
    result = twin.run(
        twin.load("plough-25cm", SHORT),
        ["slip-ekf"],
        controlled=controlled_by(mine, slip_target=0.2),
    )
    return mine, result


def test_the_levers_are_the_controller_s_after_the_approach(driven):
    mine, result = driven
    depth_m = result.truth["depth_m"]
    assert np.median(depth_m[len(depth_m) * 3 // 4 :]) == pytest.approx(0.22, abs=0.03)
    # as in Plough-v0, the tractor sinks and squats by about 0.07 m
    approach_s = (result.truth["epoch_ns"][-1] - result.truth["epoch_ns"][0]) * 1e-9 - 0.02 * len(
        mine.seen
    )
    assert 1.0 < approach_s < 6.0  # 6 m at about 2 m/s
    assert "throttle and hitch in work were set by controller 'Watches'" in result.notes


def test_it_sees_what_the_run_s_estimator_says_and_its_sensors(driven):
    """What it last saw is a row of the tables, to the last bit of a float32."""
    mine, result = driven
    last = mine.seen[-1]
    assert list(last) == [entry.name for entry in ENTRIES]
    for name, values in (
        ("slip", result.estimates["slip-ekf"]["slip"]),
        ("speed_mps", result.estimates["slip-ekf"]["speed_mps"]),
        ("draft_pin_n", result.streams["machine"]["draft_pin_n"]),
        ("engine_radps", result.streams["machine"]["engine_radps"]),
    ):
        assert np.float32(last[name]) in values[-25:].astype(np.float32)
    assert (last["slip_target"], last["depth_target_m"]) == (np.float32(0.2), 0.25)


def test_the_same_run_without_a_controller_keeps_its_driver():
    one = twin.run(twin.load("plough-25cm", {"course.length_m": 2.0}), ["ratio"])
    assert not any("controller" in note for note in one.notes)


@pytest.mark.parametrize(
    ("name", "overrides", "said"),
    [
        ("road-grass-5kmh", {}, "controller 'pi': scenario 'road-grass-5kmh' has no implement"),
        ("plough-25cm", {"sensors.depth": None}, "needs the sensors .* has no depth"),
        ("ima-pkf", {}, "controller 'pi': scenario 'ima-pkf' has signals alone"),
    ],
)
def test_what_cannot_be_controlled_is_named(name, overrides, said):
    with pytest.raises(BadInput, match=said):
        twin.run(twin.load(name, overrides), ["ratio"], controlled=controlled_by("pi"))


def test_a_controller_that_fails_leaves_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "wrong.py").write_text(
        "class Wrong:\n"
        "    def init(self, setup): return None\n"
        "    def act(self, state, observation): return state, (1.0, float('nan'))\n"
    )
    asked = ["plough-25cm", "--controller", "wrong:Wrong", "--course.approach-m", "2"]
    assert main(["run", *asked, "--out", str(tmp_path / "run")]) == 2
    assert "controller 'wrong:Wrong': action hitch = nan is not finite" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
