"""The core of a calibration on models whose answer is known."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from twin.calibration.fitting import NotFitted, Prior, fit
from twin.calibration.noise import estimated, huber_weights, whitened
from twin.calibration.verdicts import IDENTIFIED, NOT, WEAK, found, together, verdict

NAMES = ("soil.friction", "soil.cone_index_kpa")


def prior(names=NAMES, sd=1.0, low=-5.0, high=5.0):
    many = len(names)
    return Prior(names, np.zeros(many), np.full(many, sd), np.full(many, low),
                 np.full(many, high), ("assumed",) * many)  # fmt: skip


@dataclass
class Linear:
    """Channels that are linear in the logarithms of the parameters: everything is closed form."""

    rows: np.ndarray
    measured: np.ndarray
    sd: float
    time_s: np.ndarray = field(init=False)
    covariance: np.ndarray = field(init=False)
    floor: np.ndarray = field(init=False)

    def __post_init__(self):
        n = len(self.rows)
        self.time_s = 5.0 * np.arange(n)
        self.covariance = np.full((n, 1, 1), self.sd**2)
        self.floor = np.array([1e-6])

    def foretold(self, values):
        return (np.log(values) @ self.rows.T)[..., None]


def linear(sd=0.1, n=60, seed=1, together=0.0):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((n, 2))
    rows[:, 1] = together * rows[:, 0] + (1.0 - together) * rows[:, 1]
    truth = np.array([0.4, -0.7])
    return Linear(rows, (rows @ truth + sd * rng.standard_normal(n))[:, None], sd), truth


def test_a_linear_model_gets_bayes_closed_form():
    model, _ = linear(sd=0.1)
    weights = huber_weights(np.zeros(1))
    assert weights[0] == 1.0
    result = fit(model, prior(), starts=2)
    precision = model.rows.T @ model.rows / 0.01 + np.eye(2)
    mean = np.linalg.solve(precision, model.rows.T @ model.measured[:, 0] / 0.01)
    np.testing.assert_allclose(result.u, mean, atol=0.02)  # Huber's loss bends a few of the rows
    wide = result.misfit**2 if result.misfit > 1.0 else 1.0
    np.testing.assert_allclose(result.cov, wide * np.linalg.inv(precision), rtol=0.25)


def test_intervals_cover_as_often_as_they_say():
    inside = []
    for seed in range(40):
        model, truth = linear(sd=0.3, n=30, seed=seed)
        result = fit(model, prior(sd=3.0), starts=1)
        inside.append(np.abs(result.u - truth) < 1.96 * np.sqrt(np.diag(result.cov)))
    assert 0.86 <= np.mean(inside) <= 1.0


def test_a_bound_that_is_hit_is_told_and_kept():
    model, _ = linear()
    result = fit(model, prior(high=0.2), starts=1)
    assert result.u[0] == pytest.approx(0.2)
    assert result.at_bound.tolist() == [True, False]
    assert found(result)[0].at_bound


def test_the_same_seed_gives_the_same_bits():
    model, _ = linear()
    one, other = (fit(model, prior(), starts=3, seed=4) for _ in range(2))
    assert np.array_equal(one.u, other.u)
    assert np.array_equal(one.cov, other.cov)


def test_what_was_kept_of_a_killed_calibration_is_used():
    model, _ = linear()
    kept = {}

    def remember(key, find):
        return kept.setdefault(key, None) if key in kept else kept.setdefault(key, find())

    first = fit(model, prior(), starts=2, remember=remember)
    model.measured = model.measured + 100.0  # not looked at where all is remembered
    again = fit(model, prior(), starts=2, remember=remember)
    assert np.array_equal(first.u, again.u)


def test_residuals_that_are_not_finite_are_said():
    model, _ = linear()
    model.measured[:] = np.nan
    with pytest.raises(NotFitted, match="no start"):
        fit(model, prior(), starts=2)


@pytest.mark.parametrize(("share", "said"), [(0.1, IDENTIFIED), (0.5, WEAK), (0.95, NOT)])
def test_a_verdict_is_by_what_the_log_left_of_the_prior(share, said):
    assert verdict(share) == said


def test_what_is_told_only_together_is_named():
    model, _ = linear(together=0.97)
    pairs = list(together(fit(model, prior(sd=10.0), starts=1)))
    assert len(pairs) == 1
    assert set(pairs[0].names) == set(NAMES)
    assert "only together" in str(pairs[0])
    apart, _ = linear()
    assert not list(together(fit(apart, prior(), starts=1)))


def test_noise_that_lasts_is_found_and_whitened():
    rng = np.random.default_rng(3)
    time_s, tau_s = 5.0 * np.arange(600), 40.0
    kept = np.exp(-5.0 / tau_s)
    noise = np.empty((600, 1))
    noise[0] = rng.standard_normal()
    for i in range(1, 600):
        noise[i] = kept * noise[i - 1] + np.sqrt(1 - kept**2) * rng.standard_normal()
    known = estimated(0.02 * noise, time_s, np.array([1e-6]))
    assert known.tau_s in (20.0, 40.0, 80.0)
    assert known.sd()[0, 0] == pytest.approx(0.02, rel=0.25)
    white = whitened(known, 0.02 * noise, time_s)[:, 0]
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.15
