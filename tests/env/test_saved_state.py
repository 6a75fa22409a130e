"""A state kept and put back within an episode: what follows is the same to the bit."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest

from twin.env import IDS
from twin.env.observations import MODES
from twin.env.plough import PloughEnv
from twin.env.vector import PloughVectorEnv
from twin.errors import BadInput

COUNT, BEFORE, AFTER = 3, 12, 15


def single(name, mode):
    return gymnasium.make(f"twin.env:{name}", observation=mode, max_episode_steps=20)


def many(name, mode):
    return gymnasium.make_vec(
        f"twin.env:{name}", num_envs=COUNT, vectorization_mode="vector_entry_point",
        observation=mode, max_episode_steps=20,
    )  # fmt: skip


def plain(value):
    """Something whose equality is that of every bit."""
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value


def gone_on(env, actions):
    """What some steps give; an end of the single environment is reset, as the vector does."""
    out = []
    for action in actions:
        observation, reward, stalled, late, info = env.step(action)
        out.append((observation.tobytes(), plain(reward), plain(stalled), plain(late), plain(info)))
        if np.ndim(late) == 0 and (stalled or late):
            observation, info = env.reset()
            out.append((observation.tobytes(), plain(info)))
    return out


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("make", [single, many])
@pytest.mark.parametrize("name", IDS)
def test_an_episode_goes_on_to_the_bit(name, make, mode):
    env = make(name, mode)
    shape = (BEFORE + AFTER, *env.action_space.shape)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, shape).astype(np.float32)
    env.reset(seed=5)
    gone_on(env, actions[:BEFORE])
    state = pickle.loads(pickle.dumps(env.unwrapped.get_state()))
    copies = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    once = gone_on(env, actions[BEFORE:])
    assert all(gone_on(each, actions[BEFORE:]) == once for each in copies)
    env.unwrapped.set_state(state)
    if make is many:  # a wrapper's own count of steps is not the environment's
        assert gone_on(env, actions[BEFORE:]) == once
    else:
        assert gone_on(env.unwrapped, actions[BEFORE : BEFORE + 7]) == once[:7]


def test_a_branch_changes_nothing_of_the_other():
    env = PloughEnv("truth")
    env.reset(seed=1)
    other = copy.deepcopy(env)
    for _ in range(5):
        other.step(np.array([1.0, 1.0], dtype=np.float32))
    first = env.step(np.zeros(2, dtype=np.float32))[0]
    env.reset(seed=1)
    assert first.tobytes() == env.step(np.zeros(2, dtype=np.float32))[0].tobytes()


def test_an_environment_without_an_episode_is_copied_too():
    env = pickle.loads(pickle.dumps(PloughEnv("estimate")))
    assert not env.running
    env.reset(seed=2)


def test_the_state_of_another_environment_is_refused():
    one, two = PloughVectorEnv(1, observation="truth"), PloughVectorEnv(2, observation="truth")
    one.reset(seed=1)
    with pytest.raises(BadInput, match="the state is not of such an environment"):
        two.set_state(one.get_state())
    with pytest.raises(BadInput, match="not of such an environment"):
        two.set_state({"fleet": {}})
    seen = PloughVectorEnv(1, observation="sensors")
    with pytest.raises(BadInput, match="of an environment with another observation"):
        seen.set_state(one.get_state())
