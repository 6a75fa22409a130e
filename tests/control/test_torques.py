"""The torque baselines' laws against their closed forms."""

import math

import numpy as np
import pytest

from twin.control.torques import (
    TORQUE_BASELINES,
    ConstantTorque,
    ScheduledTorquePI,
    SlidingTorque,
    TorquePI,
)

PERIOD_S = 0.02


def seen(left, right, target=0.15):
    left, right = np.atleast_1d(left).astype(float), np.atleast_1d(right).astype(float)
    return {"slip_rl": left, "slip_rr": right, "slip_target": target * np.ones_like(left)}


def held(controller, left, right, steps):
    state, what = controller.init(len(np.atleast_1d(left))), seen(left, right)
    for _ in range(steps):
        state, actions = controller.act(state, what, PERIOD_S)
    return actions


def test_constant_is_its_feed():
    np.testing.assert_array_equal(held(ConstantTorque(feed=0.6), 0.9, 0.0, 3), [[0.6, 0.6]])


def test_each_wheel_has_its_own_pi():
    """left: e = 0.05, right: e = -0.10, after 10 periods."""
    actions = held(TorquePI(feed=0.5, kp=2.0, ki_ps=1.0), 0.10, 0.25, 10)
    np.testing.assert_allclose(actions, [[0.5 + 0.1 + 0.01, 0.5 - 0.2 - 0.02]])


def test_the_integral_winds_up_no_further_than_the_action():
    controller = TorquePI(feed=0.5, kp=0.0, ki_ps=5.0)
    state = controller.init(1)
    for slip, reached in ((0.0, 1.0), (0.9, -1.0)):
        for _ in range(500):
            state, actions = controller.act(state, seen(slip, slip), PERIOD_S)
        np.testing.assert_allclose(actions, [[reached, reached]])


def test_the_schedule_is_an_exponential_and_the_pi_on_target():
    plain = TorquePI(feed=0.0, kp=1.0, ki_ps=0.0)
    scheduled = ScheduledTorquePI(feed=0.0, kp=1.0, ki_ps=0.0, rate=4.0)
    ratio = held(scheduled, 0.25, 0.05, 1) / held(plain, 0.25, 0.05, 1)
    np.testing.assert_allclose(ratio, [[math.exp(0.4), math.exp(-0.4)]])
    np.testing.assert_allclose(held(scheduled, 0.15, 0.15, 1), 0.0, atol=1e-15)


def test_sliding_mode_takes_all_its_reach_far_off_and_its_part_within_the_layer():
    controller = SlidingTorque(feed=0.5, reach=0.3, surface_radps=0.0, layer=0.1)
    np.testing.assert_allclose(held(controller, 0.9, 0.10, 1), [[0.2, 0.5 + 0.3 * 0.5]])


@pytest.mark.parametrize("name", TORQUE_BASELINES)
def test_side_by_side_is_alone_within_the_bounds_and_more_slip_is_less_torque(name):
    slips, controller = np.linspace(0.1, 1.0, 7), TORQUE_BASELINES[name]
    together = held(controller, slips, slips[::-1], 20)
    assert np.all(np.abs(together) <= 1.0)
    for i in range(7):
        alone = held(controller, slips[i], slips[::-1][i], 20)
        np.testing.assert_allclose(together[i], alone[0], atol=1e-14)
    assert np.all(np.diff(together[:, 0]) <= 1e-12)
