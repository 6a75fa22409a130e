import numpy as np
import pytest

from tests.sensors.trajectories import drive, pieces
from twin.sensors.sampling import arrivals, average, averager, read, reader
from twin.trajectory.trajectory import Trajectory


def ramp(n=501, step_ns=2_000_000, start_ns=0):
    epoch_ns = start_ns + step_ns * np.arange(n)
    t = epoch_ns * 1e-9
    return Trajectory(epoch_ns, {"x": 3.0 * t - 1.0, "v": np.stack([t, -2 * t], axis=1)})


@pytest.mark.parametrize("rate_hz", [20, 30, 70.7, 333])
def test_epochs_fall_at_whole_periods_to_the_nanosecond(rate_hz):
    _, epoch_ns, _ = read(reader(0, rate_hz), ramp(), ["x"])
    k = np.arange(int(1.0 * rate_hz) + 1)
    np.testing.assert_array_equal(epoch_ns, np.rint(k * 1e9 / rate_hz))


@pytest.mark.parametrize("rate_hz", [20, 30, 333])
def test_a_linear_signal_is_interpolated_exactly(rate_hz):
    _, epoch_ns, at = read(reader(0, rate_hz), ramp(), ["x", "v"])
    t = epoch_ns * 1e-9
    np.testing.assert_allclose(at["x"], 3 * t - 1, atol=1e-15)
    np.testing.assert_allclose(at["v"], np.stack([t, -2 * t], axis=1), atol=1e-15)


def test_interpolating_a_parabola_errs_by_no_more_than_its_bound():
    n = 501
    t = np.arange(n) * 0.002
    curve = Trajectory(2_000_000 * np.arange(n), {"x": t * t})
    _, epoch_ns, at = read(reader(0, 333.0), curve, ["x"])
    error = np.abs(at["x"] - (epoch_ns * 1e-9) ** 2)
    assert 0.5 * (2 * 0.002**2 / 8) < error.max() <= 2 * 0.002**2 / 8 * (1 + 1e-9)


def test_rows_on_the_grid_are_taken_as_they_are():
    noisy = np.random.default_rng(0).standard_normal(501)
    chunk = Trajectory(2_000_000 * np.arange(501), {"x": noisy})
    _, _, at = read(reader(0, 20.0), chunk, ["x"])
    np.testing.assert_array_equal(at["x"], noisy[::25])


def test_nothing_is_read_before_the_trajectory_begins():
    _, epoch_ns, _ = read(reader(0, 20.0), ramp(start_ns=130_000_000), ["x"])
    assert epoch_ns[0] == 150_000_000


def test_means_over_windows_are_the_integrals_closed_form():
    t = np.arange(2501) * 0.002
    _, end_ns, mean, number = average(
        averager(0, 200.0, 1), 2_000_000 * np.arange(2501), np.cos(20 * t)[:, None]
    )
    b = end_ns * 1e-9
    exact = (np.sin(20 * b) - np.sin(20 * (b - 0.005))) / (20 * 0.005)
    np.testing.assert_allclose(mean[:, 0], exact, atol=20**2 * 0.002**2 / 8)
    np.testing.assert_array_equal(end_ns, number * 5_000_000)


def test_a_mean_over_the_window_has_its_null_at_the_conversion_rate():
    t = np.arange(5001) * 0.0005
    alias = np.sin(2 * np.pi * 200 * t + 0.4)[:, None]
    _, _, mean, _ = average(averager(0, 200.0, 1), 500_000 * np.arange(5001), alias)
    assert np.abs(mean).max() < 1e-9 < np.abs(alias[::10]).max()


def test_arrivals_never_overtake():
    delay_s = np.random.default_rng(0).exponential(0.2, 500)
    sent_ns = 50_000_000 * np.arange(500)
    last, arrival_ns = arrivals(0, sent_ns, delay_s)
    assert np.all(np.diff(arrival_ns) >= 0)
    assert np.all(arrival_ns >= sent_ns + np.rint(delay_s * 1e9))
    assert last == arrival_ns[-1]


def test_pieces_make_up_the_whole():
    whole = drive(0.1)
    assert sum(len(p) for p in pieces(whole, 7)) == len(whole) == 51
