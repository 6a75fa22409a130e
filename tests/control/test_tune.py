"""The search of gains: a known best, equal budgets, boxes kept."""

from types import SimpleNamespace

import numpy as np
import pytest

from twin.control import tune
from twin.control.controllers import PI
from twin.control.trials import ENVIRONMENTS, TRAINING

PLACE = {"throttle": 0.9, "trim_m": -0.03, "kp_m": 0.5, "ki_mps": 0.1}


def test_rounds_close_in_on_the_best_and_stay_in_the_ranges(monkeypatch):
    """Reward falls with the squared distance from a place, in widths of each range."""
    seen = []

    def drive(env, controller, seeds, duration_s):
        assert seeds == [TRAINING, TRAINING + 1] * 24
        seen.append(controller)
        lost = 0.0
        for gain, place in PLACE.items():
            low, high = tune.RANGES[gain]
            values = getattr(controller, gain)
            assert np.all((values >= low) & (values <= high))
            lost = lost + ((values - place) / (high - low)) ** 2
        return {"reward": -lost + np.tile([0.3, -0.3], 24)}

    monkeypatch.setattr(tune, "drive", drive)
    pi = PI(throttle=0.0, trim_m=0.0, kp_m=0.0, ki_mps=0.0)
    gains, reward = tune.tune(SimpleNamespace(num_envs=48), pi, 24, 10.0, rounds=4)
    assert len(seen) == 4
    assert gains.keys() == PLACE.keys()
    for gain, place in PLACE.items():
        low, high = tune.RANGES[gain]
        assert gains[gain] == pytest.approx(place, abs=0.12 * (high - low))
    assert reward == pytest.approx(0.0, abs=0.02)
    first, last = (np.ptp(controller.kp_m) for controller in (seen[0], seen[-1]))
    assert last < 0.2 * first


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_each_baseline_acts_on_what_its_environment_shows(name):
    kind, baselines = ENVIRONMENTS[name]
    env = kind(2, observation="truth", nthread=1)
    observation, _ = env.reset(seed=TRAINING)
    names = [entry.name for entry in env.entries]
    seen = dict(zip(names, observation.T.astype(float), strict=True))
    for baseline in baselines.values():
        _, actions = baseline.act(baseline.init(2), seen, 0.02)
        assert actions.shape == env.action_space.shape
        assert np.abs(actions).max() <= 1.0
    assert name in tune.BUDGETS
