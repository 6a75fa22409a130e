"""WheelSlip-v1: motors behind a lag, a speed loop, a line across a slope, a draft that varies."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from twin.env import reward, traction_drive
from twin.env.observations import TRACTION_TASK
from twin.env.slip_line import SlipLineEnv
from twin.errors import OutOfRange, UnknownName

SEED = 3
LEVEL = {"field.cross_slope_deg": 0.0, "field.grade_deg": 0.0, "field.patches": []}


@pytest.fixture(scope="module")
def env():
    made = SlipLineEnv("truth")
    yield made
    made.close()


def driven(env, action, steps, options=None):
    env.reset(seed=SEED, options=options)
    return [env.step(np.array(action, dtype=np.float32)) for _ in range(steps)]


def named(env, observation):
    return dict(zip([entry.name for entry in env.entries], observation.tolist(), strict=True))


def test_gymnasium_finds_nothing_to_say():
    made = gymnasium.make("twin.env:WheelSlip-v1", observation="truth")
    check_env(made.unwrapped, skip_render_check=True)


def test_the_reward_is_the_sum_of_its_terms_and_limits_kept_are_earned(env):
    for _, value, _, _, info in driven(env, [0.6, 0.4], 200):
        terms = {name: info[f"reward_{name}"] for name in reward.TRACTION}
        assert value == pytest.approx(sum(terms.values()), abs=1e-12)
        for name in ("line", "slip"):
            assert 0.0 <= info[f"cost_{name}"] <= 1.0
            assert terms[name] == reward.kept(info[f"cost_{name}"])


def test_costs_are_none_at_their_limits_and_whole_beyond_them():
    np.testing.assert_allclose(reward.traction_costs(0.10, 0.20, -0.5), 0.0)
    np.testing.assert_allclose(reward.traction_costs(-0.30, 0.40, 0.40), 1.0, atol=1e-12)
    assert reward.traction_costs(0.0, 0.40, 0.0)[1] == pytest.approx(0.5)


def test_the_torque_follows_as_a_first_order_lag(env):
    """After t it has gone 1 - exp(-t / T) of its way."""
    steps = driven(env, [0.9, 0.9], 10)
    torque = np.array([named(env, step[0])["torque_left"] for step in steps])
    start = env.episodes.begun[0][0].action[0]
    time_s = 0.02 * np.arange(1, 11)
    expected = 0.9 - (0.9 - start) * np.exp(-time_s / traction_drive.LAG_S)
    np.testing.assert_allclose(torque, expected, atol=1e-6)


def test_the_speed_loop_holds_the_wheels_speeds():
    env = SlipLineEnv("truth", actuation="speed")
    assert env.episodes.actions_named == ("speed_left", "speed_right")
    asked = 7.0
    action = 2.0 * asked / traction_drive.FASTEST_RADPS - 1.0
    driven(env, [action, action], 400, LEVEL)
    fleet = env.episodes.fleet
    np.testing.assert_allclose(fleet.qvel[0, fleet.spins], asked, rtol=0.05)


def test_uneven_torques_turn_it_against_a_slope(env):
    """More torque downhill pushes the tractor up to its line."""
    slope = {"field.cross_slope_deg": 12.0, "field.grade_deg": 0.0, "field.patches": []}
    far = {
        turn: np.mean([s[4]["left_m"] for s in driven(env, [0.5 - turn, 0.5 + turn], 500, slope)])
        for turn in (-0.2, 0.2)
    }
    assert far[0.2] > far[-0.2] + 0.02


def test_the_draft_varies_with_place_and_comes_back_with_the_seed(env):
    drafts = np.array([info["draft_n"] for *_, info in driven(env, [0.5, 0.5], 800, LEVEL)])
    assert drafts[100:].std() > 0.08 * drafts[100:].mean()
    again = np.array([info["draft_n"] for *_, info in driven(env, [0.5, 0.5], 800, LEVEL)])
    np.testing.assert_array_equal(drafts, again)


def test_guidance_sees_the_line_within_the_receivers_error():
    env = SlipLineEnv("estimate")
    slope = {"field.cross_slope_deg": 12.0}
    steps = driven(env, [0.5, 0.5], 150, slope)[50:]
    seen = np.array([named(env, step[0])["line_left_m"] for step in steps])
    true = np.array([step[4]["left_m"] for step in steps])
    assert np.abs(seen - true).mean() < 0.05


def test_what_cannot_be_is_named(env):
    with pytest.raises(UnknownName, match="no actuation is called 'air'"):
        SlipLineEnv("truth", actuation="air")
    with pytest.raises(OutOfRange, match="cross_slope_deg"):
        env.reset(options={"field.cross_slope_deg": 40.0})


def test_the_docstring_names_every_entry_with_its_bounds():
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in SlipLineEnv.__doc__.splitlines()
        if line.strip().startswith("|")
    ]
    for entry in TRACTION_TASK:
        assert any(r[0] == entry.name and float(r[1]) == entry.low and float(r[2]) == entry.high
                   for r in rows if len(r) == 5)  # fmt: skip
    for name in (*SlipLineEnv("truth").episodes.recipe.options, *reward.TRACTION):
        assert name in SlipLineEnv.__doc__
