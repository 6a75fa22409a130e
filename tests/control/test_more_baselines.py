"""Draft-position mix, extremum seeking and predictive control against closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from twin.control.controllers import MOST_RELIEF_M
from twin.control.draft_mix import DraftMix
from twin.control.extremum import ExtremumSeeking, overall_efficiency
from twin.control.predictive import STIFFNESS, PredictiveSlip, bounded_minimum
from twin.env.levers import depth_set_m

PERIOD_S = 0.02
SAME = {"throttle": 0.3, "trim_m": 0.0}


def seen(**values):
    usual = {
        "slip": 0.1, "slip_target": 0.12, "depth_target_m": 0.25, "depth_m": 0.25, "draft_n": 2e4,
        "speed_mps": 1.5, "engine_torque_nm": 300.0, "engine_radps": 200.0,
    }  # fmt: skip
    return {name: np.atleast_1d(np.asarray(v, dtype=float)) for name, v in (usual | values).items()}


def relief_m(controller, what, steps):
    state = controller.init(len(what["slip"]))
    for _ in range(steps):
        state, actions = controller.act(state, what, PERIOD_S)
    return 0.25 - depth_set_m(actions[:, 1])


def test_the_mix_settles_where_position_and_draft_agree():
    """relief = m / (1 - m) S (D - D_0) / D_0, either way, and within its limits."""
    mix = DraftMix(**SAME, mix=0.4, held_n=2e4, sensitivity_m=0.1)
    expected = 0.4 / 0.6 * 0.1 * 0.25
    assert relief_m(mix, seen(draft_n=2.5e4), 1000) == pytest.approx(expected, rel=1e-3)
    assert relief_m(mix, seen(draft_n=1.5e4), 1000) == pytest.approx(-expected, rel=1e-3)
    assert relief_m(mix, seen(draft_n=9e5), 1000) == pytest.approx(MOST_RELIEF_M)


def test_position_alone_ignores_the_draft_and_an_entering_plough_is_not_pushed_down():
    position = DraftMix(**SAME, mix=0.0, held_n=2e4, sensitivity_m=0.1)
    assert relief_m(position, seen(draft_n=9e5), 200) == pytest.approx(0.0, abs=1e-12)
    mix = DraftMix(**SAME, mix=0.9, held_n=2e4, sensitivity_m=0.1)
    assert relief_m(mix, seen(draft_n=0.0, depth_m=0.02), 200) == pytest.approx(0.0, abs=1e-12)


def test_the_efficiency_is_drawbar_over_crank_power_and_within_one():
    assert overall_efficiency(seen()) == pytest.approx(2e4 * 1.5 / (300.0 * 200.0))
    assert overall_efficiency(seen(engine_torque_nm=0.0)) == 0.0
    assert overall_efficiency(seen(draft_n=-1e4)) == 0.0
    bus = seen()
    del bus["engine_torque_nm"], bus["draft_n"]
    bus |= {"engine_load": np.array([0.5]), "draft_pin_n": np.array([2e4])}
    assert overall_efficiency(bus) == pytest.approx(overall_efficiency(seen()))


@pytest.mark.parametrize("best_m", [0.03, 0.09])
def test_extremum_seeking_finds_the_maximum_of_a_map(best_m):
    """Efficiency 0.6 - 20 (relief - best)^2: the search goes to the best relief and stays."""
    controller = ExtremumSeeking(**SAME, dither_m=0.01, dither_radps=4.0, seek_mps=1.0)
    state, relief = controller.init(1), np.zeros(1)
    for _ in range(6000):
        worth = 0.6 - 20.0 * (relief - best_m) ** 2
        state, actions = controller.act(state, seen(draft_n=worth * 6e4 / 1.5), PERIOD_S)
        relief = 0.25 - depth_set_m(actions[:, 1])
    assert state.relief_m[0] == pytest.approx(best_m, abs=0.012)


def test_the_quadratic_programme_is_solved_within_its_bounds():
    random = np.random.default_rng(1)
    root = random.normal(size=(3, 5, 5))
    hessian = root @ root.transpose(0, 2, 1) + 2.0 * np.eye(5)
    linear = 2.0 * random.normal(size=(3, 5))
    low, high = np.full(3, -0.3), np.full(3, 0.2)
    found = bounded_minimum(hessian, linear, low, high, np.zeros(3))
    for h, g, u in zip(hessian, linear, found, strict=True):

        def cost(x, h=h, g=g):
            return 0.5 * x @ h @ x + g @ x

        exact = minimize(cost, np.zeros(5), bounds=[(-0.3, 0.2)] * 5)
        assert cost(u) == pytest.approx(exact.fun, abs=2e-3)


def test_predictive_control_learns_the_ground_and_keeps_the_depth_where_it_can():
    """Draft per depth 6e4 N/m and grip 4e4 N: slip at 0.25 m is -ln(1 - 0.375) / k = 0.067."""
    controller = PredictiveSlip(**SAME, slip_weight=1.0, move_weight=0.5, learn_s=0.3)
    slip = -math.log1p(-0.375) / STIFFNESS
    what = seen(draft_n=1.5e4, slip=slip)
    state = controller.init(1)
    for _ in range(400):
        state, actions = controller.act(state, what, PERIOD_S)
    assert state.draft_npm == pytest.approx(6e4, rel=1e-3)
    assert state.grip_n == pytest.approx(4e4, rel=1e-3)
    assert depth_set_m(actions[0, 1]) == pytest.approx(0.25, abs=1e-3)


def test_predictive_control_lifts_more_the_more_the_wheels_slip():
    controller = PredictiveSlip(**SAME, slip_weight=1.0, move_weight=0.5, learn_s=0.3)
    slips = np.array([0.05, 0.2, 0.3, 0.5])
    what = {n: np.broadcast_to(v, 4) for n, v in seen().items()} | {"slip": slips}
    lifted = relief_m(controller, what, 200)
    assert np.all(np.diff(lifted) > 0.0)
    assert lifted[0] == pytest.approx(0.0, abs=1e-3)
    assert lifted[-1] <= MOST_RELIEF_M + 1e-9
