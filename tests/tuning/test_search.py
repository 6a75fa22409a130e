"""The search on likelihoods whose best values, intervals and flat directions are known."""

import numpy as np
import pytest

from twin.tuning.likelihood import log_density
from twin.tuning.search import Prior, search

BLOCKS = 20
WIDE = Prior(sd=np.full(3, 2.0), bound=np.full(3, 6.0))
ALL = np.ones(3, bool)


def scores(best, weight, spread=0.0, seed=0):
    """-weight_k (x_k - best_k - error_b)^2 / 2 in each block."""
    error = spread * np.random.default_rng(seed).standard_normal((BLOCKS, len(best)))
    error -= error.mean(axis=0)

    def score(x):
        return -0.5 * ((np.asarray(x) - best - error) ** 2 * weight).sum(axis=1)

    return score


def test_the_best_values_are_found_and_flat_ones_stay():
    score = scores(np.array([1.0, -0.8, 3.0]), np.array([50.0, 20.0, 1e-6]))
    found = search(score, WIDE, ALL, np.zeros(3), paired=True, seed=0)
    assert found.x[:2] == pytest.approx([1.0, -0.8], abs=0.02)
    assert found.x[2] == 0.0
    assert list(found.flat) == [False, False, True]


def test_the_interval_is_that_of_the_blocks_and_not_of_the_curvature():
    """cov = n spread^2 weight^2 / (n weight)^2: the sd of a mean over the blocks."""
    spread = 0.3
    score = scores(np.array([2.0]), np.array([500.0]), spread)
    prior = Prior(sd=np.array([2.0]), bound=np.array([6.0]))
    found = search(score, prior, np.ones(1, bool), np.zeros(1), paired=True, seed=0)
    assert found.sd[0] == pytest.approx(spread / np.sqrt(BLOCKS), rel=0.35)
    assert found.sd[0] > 3.0 / np.sqrt(BLOCKS * 500.0)


@pytest.mark.parametrize("paired", [True, False])
def test_what_the_blocks_do_not_agree_on_is_not_moved(paired):
    score = scores(np.array([0.2]), np.array([100.0]), spread=1.0)
    prior = Prior(sd=np.array([2.0]), bound=np.array([6.0]))
    found = search(score, prior, np.ones(1, bool), np.zeros(1), paired=paired, seed=0)
    assert found.x[0] == 0.0
    assert not found.flat[0]


def test_what_is_right_within_a_tenth_stays():
    score = scores(np.array([0.08]), np.array([1e4]))
    prior = Prior(sd=np.array([2.0]), bound=np.array([6.0]))
    assert search(score, prior, np.ones(1, bool), np.zeros(1), paired=False, seed=0).x[0] == 0.0


def test_what_is_not_asked_for_stays():
    score = scores(np.array([1.0, 1.0, 1.0]), np.full(3, 50.0))
    asked = np.array([True, False, True])
    found = search(score, WIDE, asked, np.array([0.0, 0.5, 0.0]), paired=True, seed=0)
    assert found.x == pytest.approx([1.0, 0.5, 1.0], abs=0.02)


def test_a_value_stops_at_its_bound():
    score = scores(np.array([9.0]), np.array([50.0]))
    prior = Prior(sd=np.array([2.0]), bound=np.array([6.0]))
    assert search(score, prior, np.ones(1, bool), np.zeros(1), paired=True, seed=0).x[0] == 6.0


def test_two_values_of_which_only_the_sum_is_told_do_not_both_move():
    def score(x):
        return np.full(BLOCKS, -50.0 * (x[0] + x[1] - 1.0) ** 2)

    prior = Prior(sd=np.full(2, 100.0), bound=np.full(2, 6.0))
    found = search(score, prior, np.ones(2, bool), np.zeros(2), paired=True, seed=0)
    assert np.count_nonzero(found.x) == 1
    assert found.x.sum() == pytest.approx(1.0, abs=0.02)


def test_the_density_of_an_innovation_is_one():
    e = np.linspace(-200.0, 200.0, 400_001)
    assert np.trapezoid(np.exp(log_density(e, np.full(e.shape, 4.0))), e) == pytest.approx(1.0)


def test_an_outlier_costs_little_more_the_further_it_is():
    near, far = log_density(np.array([8.0, 16.0]), np.ones(2))
    assert near - far < 2.0
    assert log_density(np.zeros(1), np.ones(1))[0] == pytest.approx(-0.928, abs=0.002)
