"""Control steps to the bit: the same seed again, a pickled copy, one of many."""

import pickle

import numpy as np
import pytest

from twin.env import IDS
from twin.env.observations import MODES
from twin.env.plough import PloughEnv
from twin.env.plough_field import PloughFieldEnv
from twin.env.slip_line import SlipLineEnv
from twin.env.vector import (
    PloughFieldVectorEnv,
    PloughVectorEnv,
    SlipLineVectorEnv,
    WheelSlipVectorEnv,
)
from twin.env.wheel_slip import WheelSlipEnv

KINDS = {
    "Plough-v0": (PloughEnv, PloughVectorEnv),
    "WheelSlip-v0": (WheelSlipEnv, WheelSlipVectorEnv),
    "Plough-v1": (PloughFieldEnv, PloughFieldVectorEnv),
    "WheelSlip-v1": (SlipLineEnv, SlipLineVectorEnv),
}
SEED = 3


def rolled(env, actions):
    observation, info = env.reset(seed=SEED)
    return [(observation, 0.0, False, False, info), *(env.step(a) for a in actions[:, 0])]


def bits(episode):
    return [(observation.tobytes(), *rest) for observation, *rest in episode]


def repeats_itself(name, mode, steps):
    single, vector = KINDS[name]
    env = single(mode)
    shape = (steps, 2, *env.action_space.shape)
    random = np.random.default_rng(3).uniform(-1.0, 1.0, shape)
    actions = (0.4 + 0.3 * random).astype("f4")  # none that stalls
    once = bits(rolled(env, actions))
    assert not any(step[2] for step in once)
    copy = pickle.loads(pickle.dumps(env))  # in the midst of an episode
    assert bits(rolled(env, actions)) == once
    assert bits(rolled(copy, actions)) == once
    many = vector(2, observation=mode)
    observation, infos = many.reset(seed=[SEED, SEED + 1])
    seen = [(observation, np.zeros(2), np.zeros(2, bool), np.zeros(2, bool), infos)]
    seen += [many.step(action) for action in actions]
    of_first = [
        (observations[0].tobytes(), values[0], stalls[0], cuts[0], {n: infos[n][0] for n in info})
        for (observations, values, stalls, cuts, infos), (*_, info) in zip(seen, once, strict=True)
    ]
    assert of_first == once


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", IDS)
def test_100_steps(name, mode):
    """500 of them: tests/long."""
    repeats_itself(name, mode, 100)
