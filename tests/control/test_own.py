"""Controllers of users: one tractor or many, what they see, and what is wrong with them."""

from contextlib import closing

import numpy as np
import pytest

from twin.cli import main
from twin.control import chosen, own
from twin.control.baselines import BASELINES
from twin.control.compare import compare
from twin.control.controllers import hitch_action
from twin.control.trials import drive
from twin.env.levers import depth_set_m
from twin.env.vector import PloughVectorEnv
from twin.errors import BadInput, TwinError


@pytest.fixture(scope="module")
def env():
    with closing(PloughVectorEnv(2, observation="truth")) as made:
        yield made


@pytest.fixture(scope="module")
def setup(env):
    return own.setup_of(env.episodes)


class Proportional:
    """Of one tractor: 0.5 m of relief per slip above the target, smoothed in its state."""

    def init(self, setup):
        self.told = setup
        return 0.0

    def act(self, state, observation):
        slow = state + 0.1 * (observation["slip"] - state)
        depth = observation["depth_target_m"] - 0.5 * max(0.0, slow - observation["slip_target"])
        return slow, (0.2, hitch_action(depth))


class Many:
    """The same of many tractors."""

    def init(self, count):
        return np.zeros(count)

    def act(self, state, seen, period_s):
        slow = state + 0.1 * (seen["slip"] - state)
        depth = seen["depth_target_m"] - 0.5 * np.maximum(0.0, slow - seen["slip_target"])
        return slow, np.stack([np.full(len(slow), 0.2), hitch_action(depth)], axis=-1)


def test_a_controller_of_one_is_the_same_law_of_many(env):
    one, many = (drive(env, c, [5, 6], 6.0) for c in (Proportional(), Many()))
    for name, values in one.items():
        np.testing.assert_array_equal(values, many[name])


def test_a_controller_is_told_the_names_the_period_and_the_wheels(env):
    mine = Proportional()
    drive(env, mine, [5, 6], 5.02)
    told = mine.told
    assert (told.environment, told.period_s, told.actions) == (
        "Plough-v0", 0.02, ("throttle", "hitch"),
    )  # fmt: skip
    assert tuple(e.name for e in told.observed) == tuple(e.name for e in env.entries)
    assert 0.5 < told.streams.wheels.radius_m["rl"] < 1.2


def test_the_hitch_action_is_the_inverse_of_the_depth_set_point():
    for depth_m in (-0.1, 0.0, 0.2, 0.35):
        assert depth_set_m(hitch_action(depth_m)) == pytest.approx(depth_m, abs=1e-15)


def gives(what):
    """A controller whose `act` gives or raises this."""

    class Given:
        def init(self, setup):
            return None

        def act(self, state, observation):
            if isinstance(what, Exception):
                raise what
            return what

    return Given()


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ((0.1, 0.2), r"action has shape \(\), not \(2,\); give 2 numbers.*throttle, hitch"),
        ((None, (0.1, 0.2, 0.3)), r"action has shape \(3,\), not \(2,\)"),
        ((None, (0.1, float("nan"))), "action hitch = nan is not finite"),
        ((None, (float("inf"), 0.0)), "action throttle = inf is not finite"),
        ((None, ("full", 0.0)), r"action \('full', 0.0\) is not 2 numbers"),
        ((0.1, 0.2, 0.3), r"act gives \(0.1, 0.2, 0.3\), not \(state, action\)"),
        (None, r"act gives None, not \(state, action\)"),
        (KeyError("slyp"), r"controller 'mine:Mine' fails: KeyError: 'slyp' \(test_own.py, line"),
    ],
)
def test_a_bad_controller_is_named_and_the_others_go_on(what, said):
    done = compare({"mine:Mine": gives(what), "pi": BASELINES["pi"]}, 2, 5.1, "truth")
    assert list(done.measured) == ["pi"]
    with pytest.raises(BadInput, match=said):
        raise BadInput(done.failed["mine:Mine"])
    assert done.failed["mine:Mine"].startswith("controller 'mine:Mine'")


def test_a_bad_action_of_many_is_named(env):
    class Bad(Many):
        def act(self, state, seen, period_s):
            return state, np.zeros((3, 2))

    with pytest.raises(BadInput, match=r"controller 'Bad': action has shape \(3, 2\), not \(2, 2"):
        drive(env, Bad(), [5, 6], 5.1)


MODULE = """
class NoAct:
    def init(self, setup): return None
class Neither: pass
class Arguments:
    def init(self, setup): return None
    def act(self, observation): return 0.0
class Unmade:
    def __init__(self, gain): pass
"""


@pytest.mark.parametrize(
    ("specs", "said"),
    [
        ("mine_bad:NoAct", "controller 'mine_bad:NoAct' has no act; it needs init"),
        ("mine_bad:Neither", "has no init and no act; it needs init"),
        ("mine_bad:Arguments", r"act\(observation\) takes other arguments"),
        ("mine_bad:Unmade", "controller 'mine_bad:Unmade' cannot be made: TypeError"),
        ("mine_bad:Missing", "no attribute of mine_bad is called 'Missing'"),
        ("mine_bad", "of mine_bad.py say what, as mine_bad:Name"),
        ("no_such_module:Mine", "there is no module 'no_such_module'"),
        ("slidingmode", "did you mean 'sliding-mode'"),
        ("none.zip", "controller none.zip: there is no such file"),
        ("pi,constant,pi", "two controllers are called 'pi'"),
        (" , ", "--controllers is empty; there are constant, pi"),
    ],
)
def test_a_controller_that_cannot_be_found_is_named(specs, said, setup, tmp_path, monkeypatch):
    (tmp_path / "mine_bad.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(TwinError, match=said):
        chosen.by_name(specs, setup)


def test_the_command_names_what_failed_and_shows_the_rest(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fails.py").write_text(
        "class Fails:\n"
        "    def init(self, setup): return None\n"
        "    def act(self, state, observation): return state, (observation['slyp'], 0)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    asked = ["--controllers", "fails:Fails,constant", "--episodes", "2", "--duration-s", "6"]
    assert main(["compare-controllers", *asked, "--observation", "truth"]) == 1
    shown = capsys.readouterr()
    assert "constant" in shown.out
    assert "fails:Fails" not in shown.out
    assert shown.err == (
        "twin: controller 'fails:Fails' fails: KeyError: 'slyp' (fails.py, line 3)\n"
    )
