"""Policies of stable-baselines3 as controllers."""

import zipfile

import numpy as np
import pytest

from twin.control import own, saved
from twin.control.policy import TASKS, Policy
from twin.control.saved import PlainPolicy
from twin.control.trials import drive
from twin.env.vector import PloughVectorEnv
from twin.errors import BadInput

pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")

import gymnasium
from gymnasium.spaces import Box
from stable_baselines3 import PPO, SAC

COUNT = 3


@pytest.fixture(scope="module")
def env():
    return PloughVectorEnv(COUNT, observation="truth")


@pytest.fixture(scope="module")
def setup(env):
    return own.setup_of(env.episodes)


class Blank(gymnasium.Env):
    """Spaces alone: what a policy is made for."""

    def __init__(self, entries, low=-1.0, actions=2):
        self.observation_space = Box(-np.inf, np.inf, (entries,), np.float32)
        self.action_space = Box(low, 1.0, (actions,), np.float32)


def made(kind, blank, path):
    model = kind("MlpPolicy", blank, device="cpu", seed=1)
    model.save(path)
    return model


@pytest.mark.parametrize("kind", [PPO, SAC])
def test_a_plain_policy_sees_the_observation_in_order_and_drives(kind, env, setup, tmp_path):
    model = made(kind, Blank(len(env.entries)), tmp_path / "mine.zip")
    found = saved.load(tmp_path / "mine.zip", setup)
    assert isinstance(found, PlainPolicy)
    observation, _ = env.reset(seed=1)
    names = [entry.name for entry in env.entries]
    state = own.started(found, COUNT, "mine")
    _, actions = own.acted(found, state, names, observation, setup, "mine")
    expected, _ = model.predict(observation, deterministic=True)
    np.testing.assert_array_equal(actions, expected)
    assert np.isfinite(drive(env, found, [1, 2, 3], 5.1)["reward"]).all()


def test_a_policy_of_features_adds_to_the_pi(setup, tmp_path):
    made(PPO, Blank(TASKS["Plough-v0"].size), tmp_path / "adds.zip")
    assert isinstance(saved.load(tmp_path / "adds.zip", setup), Policy)


@pytest.mark.parametrize(
    ("blank", "said"),
    [
        (Blank(5), r"sees an observation of shape \(5,\), and this one of Plough-v0 has 21"),
        (Blank(21, low=0.0), r"acts in Box\(0.0, 1.0, \(2,\), float32\), not in 2 numbers in \[-1"),
        (Blank(21, actions=3), r"acts in Box.*\(3,\).*, not in 2 numbers"),
    ],
)
def test_a_policy_for_something_else_is_refused(blank, said, setup, tmp_path):
    made(PPO, blank, tmp_path / "other.zip")
    with pytest.raises(BadInput, match=said):
        saved.load(tmp_path / "other.zip", setup)


def test_a_file_that_is_no_policy_is_named(setup, tmp_path):
    with pytest.raises(BadInput, match="there is no such file"):
        saved.load(tmp_path / "none.zip", setup)
    (tmp_path / "bad.zip").write_text("not a zip")
    with pytest.raises(BadInput, match="is no zip file"):
        saved.load(tmp_path / "bad.zip", setup)
    with zipfile.ZipFile(tmp_path / "empty.zip", "w") as made_zip:
        made_zip.writestr("readme", "nothing")
    with pytest.raises(BadInput, match="holds no policy of PPO, SAC, TD3, A2C"):
        saved.load(tmp_path / "empty.zip", setup)
