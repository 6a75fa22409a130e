"""Plough-v1: levers behind their lags, costs against limits, two soils and two laws."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from twin.env import reward
from twin.env.field_fleet import gearbox
from twin.env.gearbox import RATIO_PS, asked_ratio, nearest
from twin.env.observations import FIELD_TASK
from twin.env.plough_field import PloughFieldEnv
from twin.errors import BadInput, OutOfRange, UnknownName

SEED = 3
STEADY = np.array([0.4, 0.5, 0.5, -0.4], dtype=np.float32)


@pytest.fixture(scope="module")
def env():
    made = PloughFieldEnv("truth")
    yield made
    made.close()


def named(env, observation):
    return dict(zip([entry.name for entry in env.entries], observation.tolist(), strict=True))


def driven(env, action, steps, **reset):
    """Observations and infos of so many control steps."""
    env.reset(seed=SEED, **reset)
    return [env.step(np.array(action, dtype=np.float32)) for _ in range(steps)]


def test_gymnasium_finds_nothing_to_say():
    made = gymnasium.make("twin.env:Plough-v1", observation="truth")
    check_env(made.unwrapped, skip_render_check=True)


def test_the_reward_is_the_sum_of_its_terms_and_the_costs_are_within_their_range(env):
    for _, value, _, _, info in driven(env, STEADY, 200):
        terms = {name: info[f"reward_{name}"] for name in reward.WORKING}
        assert value == pytest.approx(sum(terms.values()), abs=1e-12)
        for name in ("depth", "slip", "lugging"):
            assert 0.0 <= info[f"cost_{name}"] <= 1.0
            assert terms[name] == reward.kept(info[f"cost_{name}"])


def test_a_tractor_on_spinning_wheels_earns_no_less_than_a_stalled_one(env):
    """With 23 L/h, as this one burns with spinning wheels, the engine above its peak torque."""
    costs = reward.working_costs(-0.25, 0.95, 1640.0, 1450.0, 1.0)
    reference_haph = 0.36 * env.episodes.width_m * reward.REFERENCE_MPS
    fuel = reward.FUEL_HA_PER_L * 23.0 / reference_haph
    assert sum(reward.kept(cost) for cost in costs) - fuel > 0.0


def test_costs_are_none_at_their_limits_and_whole_beyond_them():
    np.testing.assert_allclose(reward.working_costs(0.02, 0.15, 1450.0, 1450.0, 1.0), 0.0)
    np.testing.assert_allclose(
        reward.working_costs(-0.07, 0.25, 1305.0, 1450.0, 1.0), 1.0, atol=1e-12
    )
    assert reward.working_costs(0.0, 0.0, 1000.0, 1450.0, 0.0)[2] == 0.0  # turning without load


def test_the_throttle_and_the_ratio_move_no_faster_than_their_actuators(env):
    up = [named(env, step[0]) for step in driven(env, [1.0, 1.0, -1.0, -1.0], 200)]
    throttle = np.array([seen["throttle"] for seen in up])
    speed = np.log([seen["gear_kmh"] for seen in up])
    fleet = env.episodes.fleet
    span = fleet.levers["fastest_rpm"] - fleet.levers["slowest_rpm"]
    rate = 2.0 * (fleet.levers["no_load_rpm"] - fleet.levers["idle_rpm"]) / span
    assert np.diff(throttle).max() <= 0.02 * rate[0] + 1e-6
    assert np.diff(speed).max() <= RATIO_PS * 0.02 + 1e-6
    assert throttle[-1] == pytest.approx(1.0, abs=1e-6)
    assert np.exp(speed[-1]) == pytest.approx(15.0, rel=1e-5)


def test_the_tractor_drives_at_the_speed_of_its_gear(env):
    """The clutch no longer slips, and the tyres roll at their radius, which load makes smaller."""
    *_, (last, _, _, _, _) = driven(env, [1.0, 0.2, -1.0, -1.0], 300)
    seen, episodes = named(env, last), env.episodes
    ratio = float(episodes.fleet.drivetrain["gear_ratio"][0])
    axle_radps = episodes.values[episodes.place["axle_radps"], 0]
    assert seen["engine_radps"] / axle_radps == pytest.approx(ratio, rel=2e-3)
    at_rated = seen["wheel_speed_mps"] * episodes.rated_radps / seen["engine_radps"]
    assert at_rated == pytest.approx(seen["gear_kmh"] / 3.6, rel=0.04)


def test_a_shift_keeps_the_engine_speed_and_makes_no_energy(env):
    """Through a range of ratios the engine stays near the governor's speed."""
    steps = driven(env, [0.5, 0.9, -1.0, -1.0], 200)
    radps = np.array([info["engine_radps"] for *_, info in steps])
    assert np.abs(np.diff(radps)).max() < 12.0
    assert radps.min() > 0.6 * radps.max()


def test_more_draft_in_the_mix_ploughs_shallower_where_the_soil_is_heavier(env):
    heavy = {"soil.preset": "firm", "soil.draft_scale": 1.3, "field.other_soil.draft_scale": 1.3}
    depths = [
        np.mean([step[4]["depth_m"] for step in driven(env, [0.4, -0.2, 0.5, mix], 400,
                                                       options=heavy)[-100:]])
        for mix in (-1.0, 1.0)
    ]  # fmt: skip
    assert depths[1] < depths[0] - 0.02


def test_both_soils_and_both_laws_are_driven(env):
    _, info = env.reset(seed=SEED)
    assert info["field.other_soil.draft_scale"] > info["soil.draft_scale"]
    assert info["soil.law"] == "brixius"
    slips = {
        law: np.mean([s[4]["slip"] for s in driven(env, STEADY, 300, options={"soil.law": law})])
        for law in ("brixius", "bekker")
    }
    assert slips["brixius"] != slips["bekker"]
    assert PloughFieldEnv("truth", law="bekker").reset(seed=SEED)[1]["soil.law"] == "bekker"


def test_the_draft_changes_within_an_episode(env):
    drafts = np.array([info["draft_n"] for *_, info in driven(env, STEADY, 1000)[250:]])
    smooth = np.convolve(drafts, np.ones(50) / 50.0, "valid")
    assert smooth.max() > 1.4 * smooth.min()


def test_a_reset_brings_back_gear_and_throttle(env):
    first = env.reset(seed=SEED)[0]
    driven(env, [1.0, 1.0, 0.5, 0.0], 50)
    np.testing.assert_array_equal(env.reset(seed=SEED)[0], first)


def test_gears_are_the_nearest_and_a_ratio_in_between_is_kept_without_them():
    assert nearest(np.array([20.0, 40.0, 80.0]), 50.0) == 40.0
    assert nearest(np.array([]), 50.0) == 50.0


def test_the_gear_action_spans_its_speeds(env):
    box = gearbox(env.episodes.fleet.machine)
    assert asked_ratio(-1.0, box) == pytest.approx(5.0 * asked_ratio(1.0, box))


@pytest.mark.parametrize(
    ("arguments", "error", "said"),
    [
        ({"law": "sand"}, UnknownName, "no law is called 'sand'"),
        ({"depth_m": 0.01}, OutOfRange, "depth_m"),
        ({"machine": "electric_tractor"}, BadInput, "electric_tractor"),
    ],
)
def test_what_cannot_be_made_is_named(arguments, error, said):
    with pytest.raises(error, match=said):
        PloughFieldEnv("truth", **arguments)


@pytest.mark.parametrize(
    ("options", "error", "said"),
    [
        ({"soil.law": 3}, BadInput, "soil.law = 3 is not the name of a soil law"),
        ({"soil.law": "sand"}, UnknownName, "sand"),
        ({"field.other_soil.preset": "mud"}, UnknownName, "mud"),
        ({"field.other_soil.friction": 9.0}, OutOfRange, "friction"),
    ],
)
def test_options_that_cannot_be_are_named(env, options, error, said):
    with pytest.raises(error, match=said):
        env.reset(options=options)


def test_the_docstring_names_every_entry_with_its_bounds():
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in PloughFieldEnv.__doc__.splitlines()
        if line.strip().startswith("|")
    ]
    for entry in FIELD_TASK:
        assert any(r[0] == entry.name and float(r[1]) == entry.low and float(r[2]) == entry.high
                   for r in rows if len(r) == 5)  # fmt: skip
    for name in (*PloughFieldEnv("truth").episodes.recipe.options, *reward.WORKING):
        assert name in PloughFieldEnv.__doc__
