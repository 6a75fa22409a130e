"""Many tractors at once: the single environment's numbers, autoreset, parts, rates."""

import os
import pickle
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode

from twin.env.observations import MODES
from twin.env.reward import LIMIT_PRICE
from twin.env.vector import (
    PloughFieldVectorEnv,
    PloughVectorEnv,
    SlipLineVectorEnv,
    WheelSlipVectorEnv,
)
from twin.errors import BadInput, TwinError

COUNT = 4
VECTORS = (PloughVectorEnv, WheelSlipVectorEnv, PloughFieldVectorEnv, SlipLineVectorEnv)
STALLS = {"soil.preset": "soft", "soil.friction": 0.1, "soil.cone_index_kpa": 200.0}


def made(**arguments):
    return gymnasium.make_vec(
        "twin.env:Plough-v0",
        num_envs=COUNT,
        vectorization_mode="vector_entry_point",
        **{"observation": "truth", **arguments},
    )


@pytest.fixture(scope="module")
def vector():
    return PloughVectorEnv(COUNT, observation="truth", max_episode_steps=25)


def actions(steps, seed=0):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, COUNT, 2)).astype(np.float32)


def assert_info_of(infos, i, info):
    for name, value in info.items():
        assert infos[f"_{name}"][i]
        assert infos[name][i] == value, name


@pytest.mark.parametrize("mode", MODES)
def test_each_is_the_single_environment_to_the_bit_through_ends(mode, environments):
    """500 control steps in all; NEXT_STEP: the step after an end begins anew and earns nothing."""
    many, limit = made(observation=mode, max_episode_steps=40), 40
    single = environments[mode]
    taken = actions(130, seed=1)
    first, infos = many.reset(seed=[7, 8, 9, 10])
    seen = [(first, None, None, None, infos), *(many.step(a) for a in taken)]
    for i in (0, COUNT - 1):
        observation, info = single.reset(seed=7 + i)
        assert first[i].tobytes() == observation.tobytes()
        assert_info_of(infos, i, info)
        age, ended = 0, False
        for action, (others, values, stalls, cuts, vector_infos) in zip(
            taken, seen[1:], strict=True
        ):
            if ended:
                (observation, info), value, stall, age = single.reset(), 0.0, False, 0
            else:
                observation, value, stall, _, info = single.step(action[i])
                age += 1
            ended = stall or age >= limit
            assert others[i].tobytes() == observation.tobytes()
            assert (values[i], stalls[i], cuts[i]) == (value, stall, age >= limit)
            assert_info_of(vector_infos, i, info)
    many.close()


def test_gymnasium_gives_the_limit_and_finds_the_mode_named():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", ".*-v0 is out of date")
        many = made()
    assert many.limit == 1500
    assert many.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert many.observation_space.shape == (COUNT, *many.single_observation_space.shape)
    many.reset(seed=0)
    observation = many.step(many.action_space.sample())[0]
    assert many.observation_space.contains(observation)


def test_same_step_keeps_what_was_last_seen_and_begins_at_once(vector):
    other = made(autoreset_mode="SAME_STEP", max_episode_steps=25)
    taken = actions(26, seed=2)
    one, two = vector.reset(seed=3)[0], other.reset(seed=3)[0]
    assert one.tobytes() == two.tobytes()
    for action in taken[:24]:
        np.testing.assert_array_equal(vector.step(action)[0], other.step(action)[0])
    last, values, _, cut, last_info = vector.step(taken[24])
    now, other_values, _, other_cut, infos = other.step(taken[24])
    assert cut.all()
    assert other_cut.all()
    np.testing.assert_array_equal(values, other_values)
    np.testing.assert_array_equal(np.stack(infos["final_obs"]), last)
    np.testing.assert_array_equal(infos["final_info"]["slip"], last_info["slip"])
    np.testing.assert_array_equal(now, vector.step(taken[25])[0])


def test_disabled_waits_for_a_reset_of_those_that_ended():
    many = made(autoreset_mode="DISABLED", max_episode_steps=2)
    many.reset(seed=0)
    many.step(actions(1)[0])
    assert many.step(actions(1)[0])[3].all()
    with pytest.raises(ResetNeeded):
        many.step(actions(1)[0])
    many.reset(options={"reset_mask": np.array([True] * COUNT)})
    many.step(actions(1)[0])


def test_a_part_begins_anew_and_the_others_go_on(vector):
    taken = actions(20, seed=4)
    vector.reset(seed=5)
    untouched = [vector.step(a)[0] for a in taken]
    vector.reset(seed=5)
    for action in taken[:10]:
        vector.step(action)
    mask = np.array([False, True, False, False])
    observation, infos = vector.reset(seed=[0, 77, 0, 0], options={"reset_mask": mask})
    assert infos["_soil.preset"].tolist() == infos["_slip"].tolist() == mask.tolist()
    np.testing.assert_array_equal(observation[~mask], untouched[9][~mask])
    for action, before in zip(taken[10:], untouched[10:], strict=True):
        observation = vector.step(action)[0]
        np.testing.assert_array_equal(observation[~mask], before[~mask])
    assert np.any(observation[mask] != before[mask])


def test_a_stall_ends_one_and_not_its_neighbours(vector):
    vector.limit = None
    vector.reset(seed=6, options={"soil.preset": "firm", "field.patches": ()})
    vector.reset(options={"reset_mask": np.array([True, False, False, False]), **STALLS})
    action = np.tile(np.array([0.0, 0.3], dtype=np.float32), (COUNT, 1))
    for _ in range(600):
        stalled = vector.step(action)[2]
        if stalled.any():
            break
    vector.limit = 25
    assert stalled.tolist() == [True, False, False, False]


def test_a_pickled_copy_gives_the_same_bits(vector):
    copy = pickle.loads(pickle.dumps(vector))
    assert vector.reset(seed=1)[0].tobytes() == copy.reset(seed=1)[0].tobytes()
    for action in actions(30):
        one, two = vector.step(action), copy.step(action)
        assert [a.tobytes() for a in one[:4]] == [a.tobytes() for a in two[:4]]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"reset_mask": [True] * COUNT}, "is not a numpy array of booleans"),
        ({"reset_mask": np.zeros(COUNT, bool)}, "one true at least"),
        ({"reset_mask": np.ones(2, bool)}, r"give shape \(4,\)"),
        ({"soil.frictoin": 1.0}, "did you mean 'soil.friction'"),
    ],
)
def test_an_impossible_option_is_named_and_changes_nothing(vector, options, said):
    vector.reset(seed=2)
    before = vector.step(actions(2)[0])[0]
    vector.reset(seed=2)
    with pytest.raises(TwinError, match=said):
        vector.reset(seed=9, options=options)
    np.testing.assert_array_equal(vector.step(actions(2)[0])[0], before)


def test_an_impossible_action_is_named(vector):
    vector.reset(seed=3)
    wrong = actions(1)[0]
    with pytest.raises(BadInput, match=r"shape \(2,\), not \(4, 2\)"):
        vector.step(wrong[0])
    wrong[2, 1] = np.nan
    with pytest.raises(BadInput, match=r"action\[2, 1\] \(hitch\) = nan"):
        vector.step(wrong)
    with pytest.raises(BadInput, match="2 seeds for 4 tractors"):
        vector.reset(seed=[1, 2])
    vector.step(actions(1)[0])


EPISODES = int(os.environ.get("TWIN_RANDOM_EPISODES", "160"))
"""Of each environment; 10000 by hand: TWIN_RANDOM_EPISODES=10000 pytest -k random_episodes."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", VECTORS)
def test_random_episodes_over_the_whole_action_range_stay_finite(kind):
    """Episodes of 2 s, a new random action every 0.2 s, corners as often as the inside.

    The reward is the sum of its terms, and what is earned at a limit is what its cost leaves.
    """
    many = kind(64, observation="truth", max_episode_steps=100)
    generator, size = np.random.default_rng(0), many.single_action_space.shape
    terms = many.episodes.rewarded
    many.reset(seed=0)
    ended, going = 0, np.ones(64, dtype=bool)
    while ended < EPISODES:
        inside = generator.uniform(-1.0, 1.0, (64, *size))
        corner = generator.random((64, 1)) < 0.5
        action = np.where(corner, np.sign(inside), inside).astype(np.float32)
        for _ in range(10):
            seen, values, stalls, cuts, infos = many.step(action)
            assert np.isfinite(seen).all()
            assert np.isfinite(values).all()
            np.testing.assert_allclose(values, sum(infos[term] for term in terms), atol=1e-12)
            for cost in (name for name in many.episodes.derived if name.startswith("cost_")):
                assert ((infos[cost] >= 0.0) & (infos[cost] <= 1.0)).all()
                earned = infos[cost.replace("cost", "reward", 1)]
                np.testing.assert_array_equal(
                    earned[going], LIMIT_PRICE * (1.0 - infos[cost][going])
                )
            going = ~(stalls | cuts)  # the others begin anew in the next step and earn nothing
            ended += int((~going).sum())
