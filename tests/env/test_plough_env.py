"""Plough-v0 as Gymnasium sees it: checks, determinism, errors, ends, documentation."""

import math
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from twin.env import IDS, reward
from twin.env.grounds import OPTIONS
from twin.env.observations import ESTIMATE, MODES, SENSORS, TASK, TRUTH
from twin.env.plough import PloughEnv
from twin.errors import BadInput, OutOfRange, TwinError, UnknownName

INFO = (
    "slip", "depth_m", "speed_mps", "draft_n", "work_rate_haph", "traction_efficiency", "fuel_lph",
)  # fmt: skip
LEVEL = {"field.cross_slope_deg": 0.0, "field.grade_deg": 0.0, "field.furrow_depth_m": 0.25}
STEADY = np.array([0.0, 0.5], dtype=np.float32)


def rolled(env, seed, steps, options=None):
    """Everything an episode with random actions gives."""
    observation, info = env.reset(seed=seed, options=options)
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, 2)).astype(np.float32)
    seen = [(observation, 0.0, False, False, info)]
    for action in actions:
        seen.append(env.step(action))
        if seen[-1][2]:
            break
    return seen


def assert_same_to_the_bit(one, other):
    assert len(one) == len(other)
    for (obs, *rest), (other_obs, *other_rest) in zip(one, other, strict=True):
        assert obs.tobytes() == other_obs.tobytes()
        assert rest == other_rest


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("mode", MODES)
def test_gymnasium_finds_nothing_to_say(name, mode):
    made = gymnasium.make(f"twin.env:{name}", observation=mode)
    check_env(made.unwrapped, skip_render_check=True)
    made.close()


def test_another_seed_is_another_field_and_other_noise(env):
    first, second = rolled(env, 5, 1), rolled(env, 6, 1)
    assert first[0][4] != second[0][4]
    if env.episodes.instruments:
        assert np.any(first[0][0] != second[0][0])


def test_what_is_observed_changes_nothing_that_happens(environments):
    first, *others = (rolled(env, 7, 60) for env in environments.values())
    for other in others:
        assert [step[1:] for step in first] == [step[1:] for step in other]


def test_random_actions_stay_finite_and_inside_the_space(environments):
    names = list(environments)
    for seed in range(50):
        env = environments[names[seed % len(names)]]
        for observation, value, _, _, info in rolled(env, seed, 40):
            assert env.observation_space.contains(observation)
            assert np.isfinite(value)
            assert all(np.isfinite(v) for v in info.values() if isinstance(v, float))


def test_reward_is_the_sum_of_its_terms_and_never_negative(truth_env):
    for _, value, _, _, info in rolled(truth_env, 8, 150)[1:]:
        parts = [info[f"reward_{name}"] for name in reward.PLOUGHING]
        assert value == sum(parts)
        assert min(parts) >= 0.0


def test_ploughing_well_earns_more_than_not_ploughing(truth_env):
    def earned(hitch):
        firm = {"soil.preset": "firm", "soil.friction": 0.88, "soil.cone_index_kpa": 1200.0}
        truth_env.reset(seed=9, options=firm | LEVEL)
        return sum(truth_env.step(np.array([0.0, hitch]))[1] for _ in range(300))

    assert earned(0.3) > 1.5 * earned(-1.0)


def test_it_starts_rolling_steadily_with_the_plough_in_the_air(truth_env):
    observation, info = truth_env.reset(seed=10, options={"soil.preset": "firm"} | LEVEL)
    speed = dict(zip([e.name for e in truth_env.entries], observation, strict=True))["speed_mps"]
    assert info["depth_m"] == 0.0
    still = np.array([observation[-4], -1.0])
    for _ in range(25):
        *_, info = truth_env.step(still)
        assert info["depth_m"] == 0.0
        assert info["speed_mps"] == pytest.approx(speed, rel=0.005)


def test_it_starts_in_the_last_furrow_and_ploughs_at_the_depth_it_is_set_for(truth_env):
    """Rolled to the right by atan(depth / track) and the tyres' share; shares level in the soil."""
    firm = {"soil.preset": "firm", "soil.friction": 0.88, "soil.cone_index_kpa": 1200.0}
    truth_env.reset(seed=10, options=firm | LEVEL)
    w, x, y, z = truth_env.episodes.fleet.qpos[0, 3:7]
    roll = math.degrees(math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))
    assert roll == pytest.approx(math.degrees(math.atan(0.25 / 1.8)), abs=1.5)
    depths = [truth_env.step(np.array([0.0, 0.3]))[-1]["depth_m"] for _ in range(300)]
    assert np.mean(depths[-150:]) == pytest.approx(0.25, abs=0.02)


def test_first_observations_already_know_speed_and_slip(environments):
    observation, info = environments["estimate"].reset(seed=11)
    names = [e.name for e in environments["estimate"].entries]
    seen = dict(zip(names, observation, strict=True))
    assert seen["speed_mps"] == pytest.approx(info["speed_mps"], abs=0.1)
    assert seen["slip"] == pytest.approx(info["slip"], abs=0.05)
    observation, _ = environments["sensors"].reset(seed=11)
    seen = dict(zip([e.name for e in environments["sensors"].entries], observation, strict=True))
    # 2.09 m/s on 0.85 m for 20 ms, of 4000 counts a turn
    assert seen["wheels.ticks_rl"] == pytest.approx(2.09 / 0.849 / (2 * np.pi) * 80.0, abs=3.0)


def test_a_stall_ends_the_episode(truth_env):
    truth_env.reset(seed=12, options={"soil.preset": "firm", "soil.friction": 0.2})
    for _ in range(750):
        _, _, terminated, truncated, info = truth_env.step(np.array([0.0, 1.0]))
        assert not truncated
        if terminated:
            break
    assert terminated
    assert abs(info["speed_mps"]) < 0.05
    assert info["slip"] > 0.9


def test_the_time_limit_truncates():
    made = gymnasium.make("twin.env:Plough-v0", observation="truth", max_episode_steps=5)
    made.reset(seed=0)
    ends = [made.step(STEADY)[2:4] for _ in range(5)]
    assert ends == [(False, False)] * 4 + [(False, True)]
    assert gymnasium.spec("Plough-v0").max_episode_steps == 1500


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (np.zeros(3), r"shape \(3,\), not \(2,\)"),
        (0.5, r"shape \(\), not \(2,\)"),
        (np.zeros((1, 2)), r"shape \(1, 2\), not \(2,\)"),
        (np.array([0.0, np.nan]), r"action\[1\] \(hitch\) = nan"),
        (np.array([np.inf, 0.0]), r"action\[0\] \(throttle\) = inf"),
        (["full", "deep"], "is not 2 numbers"),
    ],
)
def test_an_impossible_action_is_named_and_changes_nothing(truth_env, action, said):
    untouched = rolled(truth_env, 13, 4)
    truth_env.reset(seed=13)
    actions = np.random.default_rng(13).uniform(-1.0, 1.0, (4, 2)).astype(np.float32)
    seen = []
    for good in actions:
        with pytest.raises(BadInput, match=said):
            truth_env.step(action)
        seen.append(truth_env.step(good))
    assert_same_to_the_bit(untouched[1:], seen)


@pytest.mark.parametrize(
    ("options", "kind", "said"),
    [
        ({"soil.frictoin": 0.8}, UnknownName, "did you mean 'soil.friction'"),
        ({"soil.preset": "mud"}, UnknownName, "no soil preset is called 'mud'"),
        (
            {"soil.cone_index_kpa": -5},
            OutOfRange,
            r"soil.cone_index_kpa = -5 is outside \[50, 5000",
        ),
        ({"soil.friction": float("nan")}, OutOfRange, "soil.friction = nan"),
        ({"soil.friction": "much"}, BadInput, "soil.friction = 'much' is not a number"),
        ({"soil.preset": 3}, BadInput, "soil.preset = 3 is not the name"),
        ({"field.grade_deg": 40}, OutOfRange, r"field.grade_deg = 40 is outside \[-15, 15"),
        ({"field.furrow_depth_m": 1}, OutOfRange, r"field.furrow_depth_m = 1 is outside"),
        ({"field.patches": 3}, BadInput, "field.patches = 3 is not a list"),
        ({"field.patches": [(1, 2)]}, BadInput, r"field.patches = \(1, 2\) is not 4 numbers"),
        ({"field.patches": [(1, 2, 9, 1)]}, OutOfRange, "patch.friction_factor = 9 is outside"),
        (
            {"soil.cone_index_kpa": 450, "field.patches": [(0, 10, 1, 0.1), (0, 5, 1, 4)]},
            OutOfRange,
            r"field.patches\[0\].cone_index_factor = 0.1 at 5.25 m",
        ),
        ({"field.origin_m": 3}, BadInput, "field.origin_m = 3 is not 2 numbers"),
    ],
)
def test_an_impossible_option_is_named_and_changes_nothing(truth_env, options, kind, said):
    untouched = rolled(truth_env, 14, 3)
    truth_env.reset(seed=14)
    with pytest.raises(kind, match=said):
        truth_env.reset(seed=99, options=options)
    actions = np.random.default_rng(14).uniform(-1.0, 1.0, (3, 2)).astype(np.float32)
    assert_same_to_the_bit(untouched[1:], [truth_env.step(a) for a in actions])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"observation": "everything"}, "no observation is called 'everything'"),
        ({"estimator": "oracle"}, "no estimator is called 'oracle'"),
        ({"depth_m": 2.0}, "depth_m = 2 is outside"),
        ({"slip_target": 0.9}, "slip_target = 0.9 is outside"),
        ({"render_mode": "ansi"}, "no render_mode is called 'ansi'"),
    ],
)
def test_an_impossible_argument_is_named(arguments, said):
    with pytest.raises(TwinError, match=said):
        PloughEnv(**arguments)


def test_options_are_taken_as_they_are_and_the_rest_is_drawn_the_same(truth_env):
    _, drawn = truth_env.reset(seed=15)
    _, given = truth_env.reset(seed=15, options={"soil.cone_index_kpa": 777})
    assert given["soil.cone_index_kpa"] == 777.0
    kept = ("soil.preset", "soil.friction", "soil.draft_scale")
    assert [given[k] for k in kept] == [drawn[k] for k in kept]


def test_actions_beyond_the_bounds_are_the_bounds(truth_env):
    truth_env.reset(seed=16)
    beyond = truth_env.step(np.array([-3.0, 7.0]))
    truth_env.reset(seed=16)
    assert_same_to_the_bit([beyond], [truth_env.step(np.array([-1.0, 1.0]))])


def test_several_side_by_side():
    several = gymnasium.make_vec(
        "twin.env:Plough-v0", num_envs=2, vectorization_mode="sync", observation="truth"
    )
    several.reset(seed=17)
    observation, value, *_ = several.step(np.stack([STEADY, STEADY]))
    assert observation.shape == several.observation_space.shape
    assert value.shape == (2,)
    several.close()


def test_the_docstring_tables_name_every_entry_with_its_bounds():
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in PloughEnv.__doc__.splitlines()
        if line.strip().startswith("|")
    ]
    found = [(r[0], float(r[1]), float(r[2])) for r in rows if len(r) == 5 and _is_number(r[1])]
    entries = [(e.name, e.low, e.high) for e in (*ESTIMATE, *SENSORS, *TRUTH, *TASK)]
    assert [row for row in found if not row[0].isdigit()] == entries
    for name in (*reward.PLOUGHING, *OPTIONS, *INFO):
        assert name in PloughEnv.__doc__


def _is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True


def test_a_run_imports_no_gymnasium():
    code = "import sys, twin.pipeline.run, twin.truth.truth; sys.exit('gymnasium' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("mode", MODES)
def test_stable_baselines3_finds_nothing_to_say(name, mode):
    pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.env_checker import check_env as check_for_learning

    check_for_learning(gymnasium.make(f"twin.env:{name}", observation=mode))
