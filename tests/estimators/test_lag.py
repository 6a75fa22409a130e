import numpy as np
import pytest

from estimators.lag import gnss_lag


def drive(seed, cutoff_hz):
    """A speed as a function of time, with content up to `cutoff_hz`."""
    generator = np.random.default_rng(seed)
    frequency = generator.uniform(0.01, cutoff_hz, 60)
    phase = generator.uniform(0, 2 * np.pi, 60)
    amplitude = 0.3 / np.sqrt(60) * generator.rayleigh(size=60)

    def speed_mps(time_s):
        return 2.0 + np.sum(amplitude * np.cos(2 * np.pi * frequency * time_s[:, None] + phase), 1)

    return speed_mps


def ns(time_s):
    return np.round(time_s * 1e9).astype(np.int64)


def logged(lag_s, *, gnss_hz, wheel_hz, duration_s, seed=0, cutoff_hz=0.4, noise_mps=0.02):
    speed = drive(seed, cutoff_hz)
    generator = np.random.default_rng(seed + 100)
    gnss_s, wheel_s = np.arange(0, duration_s, 1 / gnss_hz), np.arange(0, duration_s, 1 / wheel_hz)
    gnss = 0.93 * speed(gnss_s - lag_s) + noise_mps * generator.normal(size=len(gnss_s))
    wheel = speed(wheel_s) + noise_mps * generator.normal(size=len(wheel_s))
    return ns(gnss_s), gnss, ns(wheel_s), wheel


@pytest.mark.parametrize("lag_s", [-0.6, 0.0, 0.27, 0.5, 1.3])
def test_a_known_lag_at_1_hz(lag_s):
    found = gnss_lag(*logged(lag_s, gnss_hz=1, wheel_hz=1, duration_s=3000))
    assert found.lag_s == pytest.approx(lag_s, abs=0.03)
    assert found.high_s - found.low_s < 0.1


@pytest.mark.parametrize("lag_s", [0.0, 0.04, 0.113])
def test_a_known_lag_at_20_and_50_hz(lag_s):
    found = gnss_lag(
        *logged(lag_s, gnss_hz=20, wheel_hz=50, duration_s=120, cutoff_hz=1.5, noise_mps=0.03)
    )
    assert found.lag_s == pytest.approx(lag_s, abs=0.01)
    assert found.low_s < found.lag_s < found.high_s


def test_the_interval_holds_the_truth_about_as_often_as_it_says():
    held = 0
    for seed in range(40):
        found = gnss_lag(*logged(0.3, gnss_hz=1, wheel_hz=1, duration_s=2000, seed=seed))
        held += found.low_s <= 0.3 <= found.high_s
    assert held >= 32


def test_a_gap_is_not_bridged():
    gnss_ns, gnss, wheel_ns, wheel = logged(0.3, gnss_hz=1, wheel_hz=1, duration_s=2000)
    there = (np.arange(2000) < 700) | (np.arange(2000) > 1100)
    found = gnss_lag(gnss_ns[there], gnss[there], wheel_ns[there], wheel[there])
    assert found.lag_s == pytest.approx(0.3, abs=0.04)
    whole = gnss_lag(gnss_ns, gnss, wheel_ns, wheel)
    assert whole.segments - 16 < found.segments < whole.segments - 10


def test_a_drive_that_cannot_tell_has_no_lag():
    time_ns = np.arange(20) * 10**9
    short = gnss_lag(time_ns, np.ones(20), time_ns, np.ones(20))
    assert np.isnan(short.lag_s)
    time_ns = np.arange(1000) * 10**9
    steady = gnss_lag(time_ns, np.ones(1000), time_ns, np.ones(1000))
    assert np.isnan(steady.lag_s)
    missing = gnss_lag(time_ns, np.full(1000, np.nan), time_ns, np.ones(1000))
    assert np.isnan(missing.lag_s)
    noise = np.random.default_rng(0).normal(size=(2, 1000))
    unrelated = gnss_lag(time_ns, noise[0], time_ns, noise[1])
    assert np.isnan(unrelated.lag_s) or unrelated.high_s - unrelated.low_s > 0.5
