"""Grounds that the constructor fixes or schedules: kept over autoreset, one for each tractor."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

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
from twin.errors import BadInput, OutOfRange, UnknownName

SOFT = {"soil.preset": "soft", "field.cross_slope_deg": 0.0}
LEVEL = {"soil.preset": "firm", "field.cross_slope_deg": 0.0}
KINDS = [
    (PloughEnv, PloughVectorEnv),
    (WheelSlipEnv, WheelSlipVectorEnv),
    (PloughFieldEnv, PloughFieldVectorEnv),
    (SlipLineEnv, SlipLineVectorEnv),
]
STILL = np.zeros(2, dtype=np.float32)


def steeper(episode, generator):
    """A curriculum: 0.5 degrees more with each episode, on a soil that is drawn."""
    return {
        "soil.cone_index_kpa": float(generator.uniform(500.0, 600.0)),
        "field.grade_deg": 0.5 * episode,
    }


def test_a_fixed_ground_is_every_episode_s_and_reset_s_options_come_before():
    env = PloughEnv("truth", grounds=SOFT)
    for seed in (1, None, 2):
        assert env.reset(seed=seed)[1]["soil.preset"] == "soft"
    _, info = env.reset(options={"soil.preset": "firm"})
    assert (info["soil.preset"], info["field.cross_slope_deg"]) == ("firm", 0.0)


def test_a_schedule_counts_the_episodes_and_draws_from_the_seed():
    env = PloughEnv("truth", grounds=steeper)
    seen = [env.reset(seed=3 if i == 0 else None)[1] for i in range(3)]
    assert [info["field.grade_deg"] for info in seen] == [0.0, 0.5, 1.0]
    again = PloughEnv("truth", grounds=steeper)
    assert again.reset(seed=3)[1] == seen[0]
    assert again.reset()[1] == seen[1]


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize(("single", "many"), KINDS)
def test_grounds_of_each_tractor_stay_over_autoreset(single, many, mode):
    """And each tractor's seed draws what the single environment with that seed draws."""
    grounds = [LEVEL, steeper, {}]
    env = many(3, 4, observation="truth", autoreset_mode=mode, grounds=grounds, nthread=1)
    _, infos = env.reset(seed=1)
    singles = [single("truth", grounds=each) for each in grounds]
    firsts = [each.reset(seed=1 + i)[1] for i, each in enumerate(singles)]
    assert infos["soil.preset"].tolist() == [info["soil.preset"] for info in firsts]
    ends = 0
    for _ in range(12):
        _, _, _, late, infos = env.step(np.zeros(env.action_space.shape, dtype=np.float32))
        ends += int(late[0])
    seconds = [[each.reset()[1] for _ in range(ends)][-1] for each in singles]
    assert ends >= 2
    for name in ("soil.preset", "field.grade_deg", "soil.cone_index_kpa", "field.origin_m"):
        assert infos[name].tolist() == [info[name] for info in seconds]
    assert env.np_random_seed == (1, 2, 3)


def test_vector_environments_report_their_seeds():
    env = PloughVectorEnv(3, observation="truth")
    assert env.np_random_seed == (None, None, None)
    env.reset(seed=7)
    assert env.np_random_seed == (7, 8, 9)
    env.reset(seed=[None, 3, None])
    assert env.np_random_seed == (7, 3, 9)
    assert all(isinstance(each, np.random.Generator) for each in env.np_random)


@pytest.mark.parametrize("kind", [PloughEnv, WheelSlipEnv])
def test_infos_have_one_structure(kind):
    env = kind("truth", grounds={"field.patches": ()})
    _, first = env.reset(seed=1)
    last = env.step(STILL)[4]
    assert list(first) == list(last)
    assert [type(v) for v in first.values()] == [type(v) for v in last.values()]
    assert {n: v for n, v in first.items() if "." in n} == {
        n: v for n, v in last.items() if "." in n
    }


def test_a_step_after_the_end_raises():
    env = PloughEnv("truth", grounds={"soil.preset": "soft", "soil.friction": 0.1,
                                      "soil.cone_index_kpa": 200.0})  # fmt: skip
    env.reset(seed=1)
    down = np.array([0.0, 1.0], dtype=np.float32)
    for _ in range(1500):
        if env.step(down)[2]:
            break
    with pytest.raises(gymnasium.error.ResetNeeded, match="the episode has ended; call reset"):
        env.step(down)
    env.reset()
    env.step(down)


@pytest.mark.parametrize(
    ("grounds", "kind", "said"),
    [
        ({"soil.frictoin": 0.8}, UnknownName, "did you mean 'soil.friction'"),
        ({"soil.friction": 40.0}, OutOfRange, "soil.friction = 40 is outside"),
        ("soft", BadInput, "grounds = 'soft' is not options by name"),
        (3, BadInput, "grounds = 3 is not options by name"),
        ([SOFT, SOFT], BadInput, "2 grounds for 1 tractors; give one for each"),
        ([3], BadInput, "grounds gives 3, not options by name"),
    ],
)
def test_impossible_grounds_are_named(grounds, kind, said):
    with pytest.raises(kind, match=said):
        PloughEnv("truth", grounds=grounds)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda episode, generator: 3, "grounds gives 3, not options"),
        (lambda episode: {}, r"grounds fails: TypeError: .* \(schedule.py|test_schedule.py, line"),
        (lambda episode, generator: {"soil.preset": "mud"}, "no soil preset is called 'mud'"),
    ],
)
def test_a_schedule_that_fails_is_named(function, said):
    env = PloughEnv("truth", grounds=function)
    with pytest.raises((BadInput, UnknownName), match=said):
        env.reset(seed=1)


def test_both_ids_are_the_same_environment():
    made = [gymnasium.make(f"twin.env:{n}Plough-v0") for n in ("", "tractor_twin/")]
    (one, first), (two, second) = (env.reset(seed=1) for env in made)
    assert one.tobytes() == two.tobytes()
    assert first == second
    assert made[1].spec.max_episode_steps == made[0].spec.max_episode_steps
