"""The paper's simulation.

What it prints of its signals holds, and the same seed drives the same.
"""

from dataclasses import replace

import numpy as np
import pytest

from scenarios.ima_pkf import Trial, simulate
from scenarios.ima_pkf_signals import SD
from scenarios.ima_pkf_tracks import CENTRES_S

TRACKS = ("smooth", "medium", "rough")


@pytest.mark.parametrize("track", TRACKS)
def test_speeds_are_one_to_three_metres_a_second(track):
    for seed in range(10):
        signals = simulate(Trial(seed=seed, track=track))
        assert len(signals.time_s) == 1500
        assert signals.ground_mps.min() > 0.9
        assert signals.wheel_mps.max() < 3.0
        assert signals.slip.min() > 0.0
        assert signals.slip.max() < 0.45


def test_tracks_are_ever_rougher():
    """Power of the ground's acceleration."""
    power = [
        np.mean([np.var(np.diff(simulate(Trial(seed=s, track=t)).ground_mps)) for s in range(8)])
        for t in TRACKS
    ]
    assert power[0] < 0.7 * power[1] < 0.5 * power[2]


def test_noise_is_as_printed():
    off = {name: [] for name in SD}
    for seed in range(20):
        s = simulate(Trial(seed=seed))
        off["front"].append(s.front_mps - s.ground_mps)
        off["gnss"].append(s.gnss_mps - s.ground_mps)
        off["rear"].append(s.rear_mps - s.wheel_mps)
        off["accel"].append(s.accel_mps2 - np.gradient(s.ground_mps, 0.02))
        off["rear_accel"].append(s.rear_accel_mps2 - np.gradient(s.wheel_mps, 0.02))
    for name, sd in SD.items():
        assert np.std(off[name]) == pytest.approx(sd, rel=0.02)
        assert abs(np.mean(off[name])) < 0.05 * sd


def test_proportional_noise():
    quiet, s = simulate(Trial(seed=1)), simulate(Trial(seed=1, noise="proportional"))
    share = (s.gnss_mps - s.ground_mps) / s.ground_mps
    assert np.std(share) == pytest.approx(0.05, rel=0.06)
    assert s.accel_mps2.tobytes() == quiet.accel_mps2.tobytes()


def test_disturbances_are_where_and_as_large_as_printed():
    quiet = simulate(Trial(seed=2))
    lobe = simulate(Trial(seed=2, disturbance="lobe"))
    added = lobe.gnss_mps - quiet.gnss_mps
    assert np.all(lobe.front_mps == quiet.front_mps)
    assert np.all(lobe.slip == quiet.slip)
    starts = lobe.time_s[np.flatnonzero(np.diff((added != 0).astype(int)) == 1)]
    assert len(starts) == 5
    assert np.all(np.abs(starts - CENTRES_S) < 2.0)
    for start in starts:
        pulse = added[(lobe.time_s >= start) & (lobe.time_s < start + 0.25)]
        assert 0.38 < np.abs(pulse).max() <= 0.8
        assert 8 <= np.count_nonzero(pulse) <= 12
        assert np.all(pulse >= 0) or np.all(pulse <= 0)


def test_a_whole_cycle_changes_sign():
    added = simulate(Trial(seed=2, disturbance="cycle")).gnss_mps - simulate(Trial(seed=2)).gnss_mps
    assert added.min() < -0.38
    assert added.max() > 0.38


def test_disturbed_may_be_both_speeds_or_the_motion_itself():
    quiet = simulate(Trial(seed=2))
    both = simulate(Trial(seed=2, disturbance="lobe", disturbed="speeds"))
    assert both.front_mps - quiet.front_mps == pytest.approx(both.gnss_mps - quiet.gnss_mps)
    assert np.all(both.slip == quiet.slip)
    moved = simulate(Trial(seed=2, disturbance="lobe", disturbed="truth"))
    jump = moved.ground_mps - quiet.ground_mps
    assert np.abs(jump).max() > 0.38
    assert moved.gnss_mps - quiet.gnss_mps == pytest.approx(jump)
    assert np.abs(moved.accel_mps2 - quiet.accel_mps2).max() > 5.0
    scale = np.maximum(moved.wheel_mps, moved.ground_mps)
    assert moved.slip == pytest.approx((moved.wheel_mps - moved.ground_mps) / scale)


def test_a_machine_without_wheel_accelerometer_and_with_bias():
    quiet = simulate(Trial(seed=3))
    machine = simulate(Trial(seed=3, wheel_accel=False, accel_bias_sd_mps2=0.1))
    assert np.all(np.isnan(machine.rear_accel_mps2))
    assert np.ptp(machine.accel_mps2 - quiet.accel_mps2) == pytest.approx(0.0, abs=1e-12)
    assert abs(np.mean(machine.accel_mps2 - quiet.accel_mps2)) > 1e-3


def test_same_seed_same_bits_another_seed_others():
    one, again, other = (simulate(Trial(seed=s)) for s in (4, 4, 5))
    assert one.gnss_mps.tobytes() == again.gnss_mps.tobytes()
    assert np.any(one.gnss_mps != other.gnss_mps)
    assert np.any(simulate(replace(Trial(seed=4), track="rough")).slip != one.slip)
