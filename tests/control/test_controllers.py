"""The baselines' laws against their closed forms."""

import math
from contextlib import closing

import numpy as np
import pytest

from twin.control.baselines import BASELINES
from twin.control.controllers import (
    MOST_RELIEF_M,
    PI,
    Constant,
    ScheduledPI,
    SlidingMode,
)
from twin.control.trials import drive
from twin.env.levers import depth_set_m
from twin.env.vector import PloughVectorEnv
from twin.errors import BadInput

PERIOD_S = 0.02
SAME = {"throttle": 0.3, "trim_m": -0.05}


def seen(slip, target=0.12):
    slip = np.atleast_1d(np.asarray(slip, dtype=float))
    same = np.ones_like(slip)
    return {
        "slip": slip, "slip_target": target * same, "depth_target_m": 0.25 * same,
        "depth_m": 0.24 * same, "draft_n": 2e4 * same, "speed_mps": 1.5 * same,
        "engine_torque_nm": 300.0 * same, "engine_radps": 220.0 * same,
    }  # fmt: skip


def held(controller, slip, steps):
    """Relief after the slip was held for some control steps."""
    state, what = controller.init(len(np.atleast_1d(slip))), seen(slip)
    for _ in range(steps):
        state, actions = controller.act(state, what, PERIOD_S)
    assert actions[:, 0] == pytest.approx(0.3)
    return 0.25 - 0.05 - depth_set_m(actions[:, 1])


def test_constant_sets_target_and_trim():
    np.testing.assert_allclose(held(Constant(**SAME), [0.0, 0.5], 3), 0.0, atol=1e-12)


def test_pi_is_proportional_and_integral():
    controller = PI(**SAME, kp_m=0.4, ki_mps=0.1)
    expected = 0.4 * 0.05 + 0.1 * 0.05 * 50 * PERIOD_S
    np.testing.assert_allclose(held(controller, 0.17, 50), expected, atol=1e-12)


def test_pi_winds_up_no_further_than_its_range():
    controller = PI(**SAME, kp_m=0.0, ki_mps=1.0)
    state = controller.init(1)
    for slip in (0.9, 0.0):
        for _ in range(500):
            state, _ = controller.act(state, seen(slip), PERIOD_S)
        assert state[0] == pytest.approx(MOST_RELIEF_M if slip else 0.0)


def test_scheduled_gain_falls_by_the_exponential_and_is_the_pi_on_target():
    plain, scheduled = PI(**SAME, kp_m=0.4, ki_mps=0.0), ScheduledPI(**SAME, kp_m=0.4, ki_mps=0.0)
    ratio = held(scheduled, 0.20, 1) / held(plain, 0.20, 1)
    assert ratio == pytest.approx(math.exp(-7.5 * 0.08))
    assert scheduled.gain(seen(0.12)) == pytest.approx(1.0)


def test_sliding_mode_stays_within_its_reach_and_takes_all_of_it_far_off():
    controller = SlidingMode(**SAME, reach_m=0.1, surface_radps=0.5, layer=0.1)
    np.testing.assert_allclose(held(controller, [0.0, 0.12, 0.17], 1), [0.0, 0.0, 0.025], atol=1e-3)
    np.testing.assert_allclose(held(controller, [0.0, 0.9], 2000), [0.0, 0.1], atol=1e-9)


@pytest.mark.parametrize("name", BASELINES)
def test_each_tractor_is_driven_by_its_own_slip_and_within_the_bounds(name):
    slips = np.linspace(-1.0, 1.0, 9)
    controller = BASELINES[name]
    state, together = controller.init(9), None
    for _ in range(20):
        state, together = controller.act(state, seen(slips), PERIOD_S)
    assert np.all(np.abs(together) <= 1.0)
    for i, slip in enumerate(slips):
        alone_state = controller.init(1)
        for _ in range(20):
            alone_state, alone = controller.act(alone_state, seen(slip), PERIOD_S)
        np.testing.assert_allclose(together[i], alone[0], atol=1e-14)
    if name != "extremum":  # which looks for the best slip, and knows no target
        assert np.all(np.diff(together[:, 1]) <= 1e-12)  # more slip, never deeper


def test_what_a_controller_sees_it_cannot_change():
    class Shifts:
        def init(self, count):
            return None

        def act(self, state, seen, period_s):
            seen["slip"][:] -= 0.1

    with (
        closing(PloughVectorEnv(num_envs=1)) as env,
        pytest.raises(BadInput, match=r"controller 'Shifts' writes .*test_controllers.py, line"),
    ):
        drive(env, Shifts(), [3], 6.0)
