"""Adaptation by what is identifiable: it reaches the floor that no tuning can go below."""

from dataclasses import replace

import ima_pkf
import numpy as np
import pytest

from estimators.filter_bank import MMAE, WHITENESS
from estimators.smoother import SMOOTHER

PRINTED = {"front_sd_mps": 0.10, "gnss_sd_mps": 0.13, "rear_sd_mps": 0.11}
UNBIASED = {"bias_sd_mps2": 0.0, "wheel_bias_sd_mps2": 0.0, "bias_psd_m2ps5": 0.0}
BANKS = [replace(bank, **PRINTED) for bank in (MMAE, WHITENESS)]


def rmse(estimator, trials=6, skip=50, **kind):
    squares = []
    for seed in range(trials):
        streams, _, slip = ima_pkf.streams(seed, **kind)
        _, table = estimator.run(estimator.init(ima_pkf.SETUP), streams)
        squares.append(np.mean((table["slip"] - slip)[skip:] ** 2))
    return np.sqrt(np.mean(squares))


@pytest.mark.parametrize("bank", BANKS)
def test_reaches_the_closed_form_floor_without_tuning(bank):
    """sigma_v sigma_a dt of both speeds is 0.0065-0.0069 in slip."""
    assert rmse(replace(bank, **UNBIASED)) < 0.0073


@pytest.mark.parametrize("bank", BANKS)
def test_a_bias_it_is_not_told_of_ruins_it_and_one_it_is_does_not(bank):
    assert rmse(replace(bank, **UNBIASED), bias_mps2=0.1) > 0.06
    assert rmse(bank, bias_mps2=0.1) < 0.014


def test_likelihood_finds_the_density_that_was():
    """Weight of the filter with the jerk density that drove the ground, after 60 s."""
    rng, dt, n, rate = np.random.default_rng(5), 0.02, 3000, MMAE.jerk_rate_ps
    x, truth = np.zeros(3), np.zeros((n, 3))
    f = np.array([[1, dt, dt * dt / 2], [0, 1, dt], [0, 0, np.exp(-rate * dt)]])
    for k in range(n):
        truth[k] = x
        x = f @ x + [0, 0, np.sqrt(1e2 * dt) * rng.standard_normal()]
    streams, _, _ = ima_pkf.streams(0, duration_s=n * dt)
    tables = {s: dict(t) for s, t in streams.tables.items()}
    tables["gnss"]["v_east_mps"] = 200.0 + truth[:, 0] + 0.13 * rng.standard_normal(n)
    tables["imu"]["accel_x_mps2"] = truth[:, 1] + 0.06 * rng.standard_normal(n)
    for wheel in ("fl", "fr"):
        tables["wheels"][f"speed_{wheel}_mps"] = np.full(n, np.nan)
    bank = replace(BANKS[0], **UNBIASED, memory_s=1e9)
    state, _ = bank.run(bank.init(ima_pkf.SETUP), type(streams)(tables))
    weight = state.memory["weight"][0, 0]
    assert bank.jerk_psd_m2ps7[np.argmax(weight)] == 1e2
    assert weight.max() > 0.9


def test_smoother_beats_every_causal_filter():
    assert rmse(SMOOTHER) < 0.85 * min(rmse(replace(bank, **UNBIASED)) for bank in BANKS)


def test_smoother_ends_where_its_filter_ends():
    """At the last sample there is nothing later to use: smoothing all is filtering all but once."""
    streams, _, _ = ima_pkf.streams(2, duration_s=4.0)
    whole = SMOOTHER.run(SMOOTHER.init(ima_pkf.SETUP), streams)[1]
    head = SMOOTHER.run(SMOOTHER.init(ima_pkf.SETUP), streams.samples(0, 300))[1]
    assert np.all(np.abs(whole["slip"][:90] - head["slip"][:90]) < 0.01)
    assert whole["slip"][99] != head["slip"][99]
    assert whole["slip_sd"][50] < whole["slip_sd"][-1]
