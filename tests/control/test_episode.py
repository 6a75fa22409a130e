"""One environment with a controller, step by step."""

import gymnasium
import numpy as np
import pytest

from twin.control.episode import drive_episode
from twin.errors import BadInput, OutOfRange, UnknownName


class Halfway:
    def init(self, setup):
        return 0

    def act(self, state, observation):
        return state + 1, (0.2, 0.5 + 0.001 * state)


@pytest.fixture(scope="module")
def env():
    return gymnasium.make("twin.env:Plough-v0", observation="truth")


def test_an_episode_is_what_the_environment_gives(env):
    episode = drive_episode(env, Halfway(), seed=4, duration_s=0.2)
    observation, _ = env.reset(seed=4)
    for i in range(10):
        for j, values in enumerate(episode.observation.values()):
            assert values[i] == observation[j]
        action = np.array([0.2, 0.5 + 0.001 * i], dtype=np.float32)
        assert episode.action["hitch"][i] == action[1]
        observation, reward, _, _, info = env.step(action)
        assert episode.reward[i] == reward
        assert set(episode.info) == set(info)
        for name, values in episode.info.items():
            np.testing.assert_array_equal(values[i], info[name])
    assert len(episode.reward) == 10
    assert not episode.terminated


def test_it_ends_with_the_environment():
    short = gymnasium.make("twin.env:WheelSlip-v0", observation="truth", max_episode_steps=7)
    assert len(drive_episode(short, "pi", seed=1).reward) == 7


def test_it_is_recorded(env, tmp_path):
    drive_episode(env, "pi", seed=4, duration_s=0.1, record=tmp_path / "kept")
    assert (tmp_path / "kept" / "episode_0.rrd").stat().st_size > 1000


def test_what_cannot_be_is_named(env):
    with pytest.raises(UnknownName, match="no controller is called 'pid'"):
        drive_episode(env, "pid")
    with pytest.raises(OutOfRange, match="duration_s = 0 is outside"):
        drive_episode(env, "pi", duration_s=0.0)
    with pytest.raises(BadInput, match="controller 'dict' has no init and no act"):
        drive_episode(env, {})
