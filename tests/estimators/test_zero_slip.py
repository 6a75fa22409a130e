import numpy as np
import pytest

from estimators.zero_slip import block_length, bootstrap_medians, zero_slip_scale


def ar1(n, rho, seed):
    generator = np.random.default_rng(seed)
    noise = generator.normal(size=n)
    series = np.empty(n)
    series[0] = noise[0]
    for i in range(1, n):
        series[i] = rho * series[i - 1] + np.sqrt(1 - rho**2) * noise[i]
    return series


def test_the_ratio_and_only_the_rows_given():
    wheel = np.linspace(1.0, 4.0, 300)
    gnss = 0.97 * wheel
    moving = np.arange(300) < 200
    gnss[~moving] = 5.0
    scale = zero_slip_scale(gnss, wheel, moving, rule="first 200")
    assert (scale.scale, scale.low, scale.high) == pytest.approx((0.97, 0.97, 0.97))
    assert (scale.n, scale.rule) == (200, "first 200")


def test_rows_that_slip_hardly_move_it():
    generator = np.random.default_rng(1)
    wheel = np.full(400, 2.0)
    gnss = wheel * (1.01 + 0.01 * generator.normal(size=400))
    gnss[:40] *= 0.7
    assert zero_slip_scale(gnss, wheel, wheel > 0).scale == pytest.approx(1.01, abs=0.004)


def test_standing_and_missing_rows_do_not_count():
    wheel = np.array([0.0, 0.0, 2.0, 2.0, np.nan, 2.0])
    gnss = np.array([0.0, 1.0, 2.0, np.nan, 2.0, 2.0])
    assert zero_slip_scale(gnss, wheel, np.ones(6, bool)).n == 2
    nothing = zero_slip_scale(gnss, wheel, np.zeros(6, bool))
    assert nothing.n == 0
    assert np.isnan([nothing.scale, nothing.low, nothing.high]).all()


def test_same_seed_same_bits():
    series = ar1(200, 0.5, 0)
    np.testing.assert_array_equal(
        bootstrap_medians(series, seed=3), bootstrap_medians(series, seed=3)
    )


def test_spread_of_independent_values_is_that_of_the_median():
    # the median of n normal values has sd sqrt(pi / 2 / n)
    medians = bootstrap_medians(np.random.default_rng(5).normal(size=2000), seed=0)
    assert medians.std() == pytest.approx(np.sqrt(np.pi / 2 / 2000), rel=0.25)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_the_interval_holds_the_truth_about_as_often_as_it_says(rho):
    held = 0
    for seed in range(100):
        ratio = 1.0 + 0.02 * ar1(400, rho, seed)
        scale = zero_slip_scale(ratio, np.ones(400), np.ones(400, bool), seed=seed)
        held += scale.low <= 1.0 <= scale.high
    # 95 of 100 promised; block bootstraps of short correlated series are known to fall short of it
    assert held >= 84


def test_blocks_grow_with_memory():
    lengths = [np.median([block_length(ar1(1000, r, s)) for s in range(20)]) for r in (0, 0.5, 0.9)]
    assert lengths[0] < lengths[1] < lengths[2]
    # theory for a first-order process: n^(1/3) (6 rho^2 / (1 - rho^2)^2)^(1/3), 13.9 at rho = 0.5
    assert lengths[1] == pytest.approx(13.9, rel=0.4)
