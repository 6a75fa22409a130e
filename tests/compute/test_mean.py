import math

import numpy as np
import pytest

from twin.compute.mean import mean

RNG = np.random.default_rng(0)


def test_interval_is_student_s():
    """Three values: t(0.975, 2) = 4.3027."""
    found = mean([1.0, 2.0, 3.0])
    assert (found.low, found.high) == pytest.approx(
        (2.0 - 4.30265 / 3**0.5, 2.0 + 4.30265 / 3**0.5), rel=1e-5
    )
    assert found.bounds == {"low": found.low, "high": found.high}


def test_one_value_has_no_interval_and_none_no_mean():
    assert mean([2.0]).mean == 2.0
    assert mean([2.0]).bounds == {}
    assert math.isnan(mean([]).mean)


def test_the_interval_holds_the_mean_in_95_percent_of_studies():
    held = 0
    for _ in range(2000):
        found = mean(RNG.normal(3.0, 2.0, 5))
        held += found.low <= 3.0 <= found.high
    assert 0.935 < held / 2000 < 0.965  # three sd of a binomial
