"""The core: parameters of a model that is known in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from twin.calibration.fitting import NotFitted, Prior, fit
from twin.calibration.noise import Noise, estimated, known, whitened
from twin.calibration.verdicts import IDENTIFIED, NOT, told

Array = NDArray[np.float64]
NAMES = ("mass_kg", "soil.friction", "soil.draft_scale")


@dataclass
class Power:
    """y = a x**b; the third parameter does nothing."""

    measured: Array
    x: Array
    covariance: Array | None = None

    def __post_init__(self) -> None:
        self.time_s: Array = np.arange(len(self.x), dtype=np.float64) * 5.0
        self.floor: Array = np.array([1e-6])

    def foretold(self, values: Array) -> Array:
        return np.asarray(values[:, 0, None] * self.x ** values[:, 1, None])[..., None]


def prior(sd: float = 0.3) -> Prior:
    mean = np.log([1.0, 1.0, 1.0])
    return Prior(NAMES, mean, np.full(3, sd), mean - 2.0, mean + 2.0, ("assumed",) * 3)


def model(seed: int, known_noise: bool = True) -> Power:
    x = np.linspace(0.5, 2.0, 60)
    noise = 0.02 * np.random.default_rng(seed).standard_normal(60)
    covariance = np.full((60, 1, 1), 0.02**2) if known_noise else None
    return Power((1.3 * x**0.8 + noise)[:, None], x, covariance)


@pytest.mark.parametrize("known_noise", [True, False])
def test_parameters_are_found_within_their_own_interval(known_noise: bool) -> None:
    inside = 0
    for seed in range(20):
        found = fit(model(seed, known_noise), prior(), starts=1)
        away = (found.u[:2] - np.log([1.3, 0.8])) / np.sqrt(np.diag(found.cov))[:2]
        inside += int(np.all(np.abs(away) < 2.5))
    assert inside >= 17


def test_what_nothing_depends_on_keeps_its_prior_and_is_called_so() -> None:
    found = fit(model(0), prior(), starts=2)
    verdicts = {p.name: p.verdict for p in told(found)}
    assert verdicts == {"mass_kg": IDENTIFIED, "soil.friction": IDENTIFIED, "soil.draft_scale": NOT}
    assert np.sqrt(found.cov[2, 2]) == pytest.approx(0.3, rel=1e-6)


def test_a_bound_is_kept_and_said() -> None:
    narrow = prior()
    narrow.high[0] = np.log(1.1)
    found = fit(model(0), narrow, starts=1)
    assert found.values["mass_kg"] == pytest.approx(1.1)
    assert found.at_bound.tolist() == [True, False, False]


def test_an_outlier_hardly_pulls() -> None:
    clean, spoilt = model(0), model(0)
    spoilt.measured[30] += 1.0
    before, after = (fit(m, prior(), starts=1).values["mass_kg"] for m in (clean, spoilt))
    assert after == pytest.approx(before, rel=0.01)


def test_a_model_that_gives_nothing_is_refused() -> None:
    lost = model(0)
    lost.measured[:] = np.nan
    with pytest.raises(NotFitted, match="finite"):
        fit(lost, prior(), starts=2)


def test_what_was_kept_is_not_sought_again() -> None:
    kept: dict[str, Array] = {}

    def remember(name: str, find: object) -> Array:
        if name not in kept:
            kept[name] = find()  # type: ignore[operator]
        return kept[name]

    first = fit(model(0), prior(), starts=2, remember=remember)
    again = fit(model(0), prior(), starts=2, remember=lambda name, find: kept[name])
    assert np.array_equal(first.u, again.u)
    assert np.array_equal(first.cov, again.cov)


def test_whitening_takes_the_correlation_out() -> None:
    tau_s, count = 20.0, 4000
    kept = float(np.exp(-5.0 / tau_s))
    noise: Array = np.random.default_rng(0).standard_normal(count)
    for i in range(1, count):
        noise[i] = kept * noise[i - 1] + np.sqrt(1 - kept**2) * noise[i]
    time_s: Array = 5.0 * np.arange(count, dtype=np.float64)
    found = estimated(0.3 * noise[:, None], time_s, np.array([1e-3]))
    assert found.tau_s == 20.0
    assert found.sd()[0, 0] == pytest.approx(0.3, rel=0.08)
    white = whitened(found, 0.3 * noise[:, None], time_s)[:, 0]
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.05
    assert white.std() == pytest.approx(1.0, rel=0.08)


def test_whitening_of_channels_has_unit_covariance() -> None:
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    drawn = np.random.default_rng(0).multivariate_normal([0, 0], covariance, 5000)
    white = whitened(known(np.repeat(covariance[None], 5000, axis=0)), drawn, np.arange(5000.0))
    assert np.cov(white.T) == pytest.approx(np.eye(2), abs=0.06)
    assert Noise(np.ones((1, 1, 1)), 0.0).scaled(2.0).sd()[0, 0] == 2.0
