from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.trajectories import RADIUS_M, STEP_NS, collect, drive
from twin.errors import OutOfRange
from twin.sensors import Wheels, suite, wheels
from twin.streams import WHEELS

IDEAL = suite.ideal().wheels


def ticks(table):
    return np.stack([table[f"ticks_{w}"] for w in WHEELS], axis=1)


def turning(angle_rad):
    """A trajectory with given wheel angles, shape (n, 4)."""
    rate = np.gradient(angle_rad, STEP_NS * 1e-9, axis=0)
    duration_s = (len(angle_rad) - 1) * STEP_NS * 1e-9
    return drive(duration_s, wheel_angle_rad=angle_rad, wheel_rate_radps=rate)


def test_one_turn_is_all_its_counts():
    # half a turn per reading, so every second reading is a whole turn later
    n = 1001
    angle = np.tile(np.pi * np.arange(n)[:, None] / 10, (1, 4))
    count = ticks(collect(wheels, IDEAL, [turning(angle)]))
    assert count.dtype == np.int64
    np.testing.assert_array_equal(count[2:] - count[:-2], IDEAL.counts_per_turn)
    assert IDEAL.counts_per_turn == 4000


def test_ticks_count_down_in_reverse_by_what_they_counted_up():
    there = np.linspace(0.0, 20.0, 2001)
    angle = np.tile(np.concatenate([there, there[-2::-1]])[:, None], (1, 4))
    count = ticks(collect(wheels, IDEAL, [turning(angle)]))
    half = len(count) // 2
    assert np.all(np.diff(count[:half], axis=0) >= 0)
    assert np.all(np.diff(count[half:], axis=0) <= 0)
    np.testing.assert_array_equal(count[-1], count[0])
    assert abs(count[half, 0] - count[0, 0] - 20.0 * 4000 / (2 * np.pi)) <= 1


def test_ticks_are_the_floor_of_the_angle():
    rng = np.random.default_rng(2)
    angle = np.cumsum(rng.normal(0.002, 0.01, (5001, 4)), axis=0)
    count = ticks(collect(wheels, IDEAL, [turning(angle)]))
    # cumulative and floored: from any reading to any other, less than one count off, both ways
    off = count - angle[::10] * 4000 / (2 * np.pi)
    assert 0.9 < np.ptp(off, axis=0).min() <= np.ptp(off, axis=0).max() < 1


def test_an_increment_errs_by_a_triangle_of_one_count():
    rng = np.random.default_rng(2)
    angle = np.cumsum(rng.normal(0.002, 0.01, (50_001, 4)), axis=0)
    count = ticks(collect(wheels, IDEAL, [turning(angle)]))
    error = np.diff(count, axis=0) - np.diff(angle[::10], axis=0) * 4000 / (2 * np.pi)
    np.testing.assert_allclose(error.std(axis=0), 1 / np.sqrt(6), rtol=0.1)


def test_the_resolution_in_speed_is_the_published_one():
    # 2 pi R / (4 N dt) = 0.065 m/s for R 0.83 m, N 1000, 50 Hz
    table = collect(wheels, IDEAL, [drive(20, speed_mps=1.51)])
    speed = np.diff(table["ticks_rl"]) * 2 * np.pi * RADIUS_M[2] / 4000 * 50
    assert np.diff(np.unique(speed)) == pytest.approx([0.0652], abs=1e-4)
    assert speed.mean() == pytest.approx(1.51, abs=0.0652 / len(speed))


def test_a_wheel_of_larger_radius_turns_less():
    truth = drive(100, speed_mps=2.0)
    error = (0.01, -0.02, 0.03, 0.0)
    table = collect(wheels, replace(IDEAL, radius_error=error), [truth])
    travel = (ticks(table)[-1] - ticks(table)[0]) * 2 * np.pi * RADIUS_M / 4000
    np.testing.assert_allclose(travel * (1 + np.array(error)), 200.0, atol=3e-3)


def test_drawn_radius_errors_have_their_sd():
    drawn = [wheels.init(Wheels(), seed, 0).radius_error for seed in range(500)]
    assert np.std(drawn) == pytest.approx(0.005, rel=0.1)


def test_jitter_of_the_reading_shows_as_speed_times_time():
    fine = replace(IDEAL, lines=100_000, read_jitter_s=1e-3)
    table = collect(wheels, fine, [drive(100, speed_mps=3.0)])
    rate = 3.0 / RADIUS_M[2]
    angle = table["ticks_rl"] * 2 * np.pi / fine.counts_per_turn
    error = angle - rate * table["epoch_ns"] * 1e-9
    assert error.std() == pytest.approx(rate * 1e-3, rel=0.1)


def test_turning_back_takes_the_ticks_back():
    t = np.arange(2001) * 0.002
    angle = np.tile(np.sin(np.pi * t / 4)[:, None], (1, 4))  # out and back in 4 s
    count = ticks(collect(wheels, IDEAL, [turning(angle)]))
    assert np.abs(count[-1] - count[0]).max() <= 1
    assert count.max() - count[0].max() > 500


def test_bad_values_are_named():
    with pytest.raises(OutOfRange, match=r"wheels\.radius_error = 0\.5 is outside"):
        Wheels(radius_error=(0, 0, 0.5, 0))
