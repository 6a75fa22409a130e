"""Scores of what was held out."""

import numpy as np
import pytest

from twin.calibration.held_out import gain, line, rms

TIME_S = 5.0 * np.arange(600)


def test_a_line_is_found_again_though_some_rows_are_off():
    force = np.linspace(1e3, 3e3, 200)
    slip = 0.02 + 3e-5 * force
    slip[::20] += 0.3
    np.testing.assert_allclose(line(slip, force, np.array([1e3, 2e3])), [0.05, 0.08], atol=3e-3)


def test_equal_errors_are_no_gain():
    error = np.random.default_rng(0).standard_normal(600)
    assert gain(error, error, TIME_S, seed=0) == (0.0, 0.0)


def test_a_gain_is_told_from_chance_by_blocks():
    rng = np.random.default_rng(0)
    low, high = gain(0.01 * rng.standard_normal(600), 0.03 * rng.standard_normal(600), TIME_S, 0)
    assert 0.015 < low < high < 0.025


def test_fewer_than_three_blocks_give_no_interval():
    assert np.isnan(gain(np.ones(10), np.ones(10), TIME_S[:10], 0)).all()


def test_rms_of_nothing_is_none():
    assert np.isnan(rms(np.array([np.nan])))
    assert rms(np.array([3.0, np.nan, 4.0])) == pytest.approx(np.sqrt(12.5))
