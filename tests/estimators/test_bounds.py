"""The bounds against closed forms, and through a time without GNSS."""

import dataclasses

import numpy as np
import pytest

from estimators.bounds import bound
from estimators.riccati import System, steady, through
from estimators.slip_ekf import SLIP_EKF
from twin.streams import Streams
from twin.testing import drives as synthetic

Q, R = 1e-4, 0.04
WALK = System(
    transition=np.eye(1), process=np.array([[Q]]), rows=np.eye(1), variances=np.array([R])
)
SETUP = synthetic.setup()
DRIVE = synthetic.Drive(
    duration_s=60.0,
    speed=lambda t: 1.6 + 0.05 * np.sin(0.9 * t) + 0.02 * np.sin(2.3 * t),
    slip=lambda t: 0.12 - 0.03 * np.sin(0.9 * t) - 0.012 * np.sin(2.3 * t),
)


def test_a_random_walk():
    """P = (sqrt(q^2 + 4 q r) - q) / 2;  the smoother's, for q << r, sqrt(q r) / 2."""
    causal, offline = steady(WALK)
    assert causal[0, 0] == pytest.approx((np.sqrt(Q**2 + 4 * Q * R) - Q) / 2, rel=1e-4)
    assert offline[0, 0] == pytest.approx(np.sqrt(Q * R) / 2, rel=0.01)


def test_nothing_measured_is_nothing_known():
    blind = dataclasses.replace(WALK, rows=np.zeros((0, 1)), variances=np.zeros(0))
    assert np.isnan(steady(blind)[0]).all()


def test_through_a_gap_a_walk_grows_by_q_a_step_and_forgets_the_gap():
    causal, offline = steady(WALK)
    seen = np.ones((2000, 1), bool)
    seen[900:1000] = False
    by_filter, by_smoother = through(WALK, seen, 0)
    steps = np.arange(1, 101)
    assert by_filter[900:1000] == pytest.approx(causal[0, 0] + Q * steps, rel=1e-4)
    assert by_filter[[0, 800, 1999]] == pytest.approx(causal[0, 0], rel=1e-4)
    assert by_smoother[[0, 1999]] == pytest.approx(offline[0, 0], rel=1e-3)
    # between two ends that are known by P: P / 2 + q n / 4 in the middle of n steps
    assert by_smoother[949] == pytest.approx(causal[0, 0] / 2 + Q * 101 / 4, rel=0.05)
    assert (by_smoother <= by_filter * (1 + 1e-9)).all()


def seen_until(streams, first_s, last_s, without=()):
    """The drive's streams without GNSS for a time, and without some columns of the wheels."""
    at = synthetic.seconds(streams["gnss"]["epoch_ns"])
    kept = (at < first_s) | (at > last_s)
    gnss = {name: column[kept] for name, column in streams["gnss"].items()}
    wheels = {name: c for name, c in streams["wheels"].items() if name not in without}
    return Streams({**streams.tables, "gnss": gnss, "wheels": wheels})


def test_blind_the_bound_grows_unless_the_front_wheels_are_counted():
    streams = synthetic.streams(DRIVE, SETUP)
    t = synthetic.times(DRIVE, 50.0)
    truth = synthetic.stamps(t) | {
        "speed_mps": DRIVE.speed(t),
        "slip": DRIVE.slip(t),
        "wheel_speed_mps": DRIVE.speed(t) / (1.0 - DRIVE.slip(t)),
    }
    window, within = (6.0, 60.0), (31.0, 41.0)
    hidden = seen_until(streams, 30.0, 40.0)
    blind = seen_until(streams, 30.0, 40.0, ("ticks_fl", "ticks_fr"))
    open_sky = bound(SETUP, streams, truth, window)
    counted = bound(SETUP, hidden, truth, window, within)
    uncounted = bound(SETUP, blind, truth, window, within)
    assert counted.slip_causal == pytest.approx(open_sky.slip_causal, rel=0.3)
    assert uncounted.slip_causal > 2.0 * open_sky.slip_causal
    assert uncounted.slip_causal < np.std(DRIVE.slip(t))
    assert uncounted.slip_offline < uncounted.slip_causal

    _, table = SLIP_EKF.run(SLIP_EKF.init(SETUP), hidden)
    at = synthetic.seconds(table["epoch_ns"])
    inside = (at > 30.0) & (at < 40.0)
    error = (table["slip"] - DRIVE.slip(at))[inside]
    assert error.std() > 0.7 * counted.slip_causal  # none is better than the bound, by chance a bit
