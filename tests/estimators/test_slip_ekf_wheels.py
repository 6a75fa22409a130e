"""Wheels that tell nothing of the ground, and drivers who do not wait for a filter."""

import numpy as np
import pytest

from estimators.slip_ekf import SLIP_EKF
from estimators.slip_ekf.wheels import in_the_air
from twin.streams import Streams
from twin.testing.drives import Drive, seconds, setup, streams

NOMINAL = np.zeros(1, [("driven", "f8", 4)])
NOMINAL["driven"] = 0.0, 0.0, 1.0, 1.0


def counted(made, wheels, share):
    """Streams in which some wheels count only a share of their way, by time."""
    table = dict(made["wheels"])
    t = seconds(table["epoch_ns"])
    for wheel in wheels:
        ticks = table[f"ticks_{wheel}"]
        steps = np.diff(ticks, prepend=ticks[0]) * share(t)
        table[f"ticks_{wheel}"] = ticks[0] + np.floor(np.cumsum(steps)).astype(np.int64)
    return Streams({**made.tables, "wheels": table})


def blind(made, after_s):
    """Streams without GNSS after a time."""
    table = made["gnss"]
    kept = seconds(table["epoch_ns"]) < after_s
    return Streams({**made.tables, "gnss": {name: v[kept] for name, v in table.items()}})


def slip_error(made, drive):
    _, rows = SLIP_EKF.run(SLIP_EKF.init(setup()), made)
    t = seconds(rows["epoch_ns"])
    return t, rows["slip"] - drive.slip(t)


@pytest.mark.parametrize("wheel", ["fl", "fr"])
@pytest.mark.parametrize("seen", [True, False])
def test_a_towed_wheel_that_coasts_in_the_air_is_left_out(wheel, seen):
    drive = Drive(duration_s=40.0)
    made = counted(streams(drive, setup()), [wheel], lambda t: np.exp(-np.maximum(t - 20, 0) / 10))
    t, error = slip_error(made if seen else blind(made, 21.0), drive)
    assert np.abs(error[t > 2]).max() < 0.03
    assert np.abs(error[t > 25]).mean() < 0.012


def test_gnss_is_believed_when_both_towed_wheels_come_to_skid():
    drive = Drive(duration_s=40.0)
    made = counted(streams(drive, setup()), ["fl", "fr"], lambda t: 1 - 0.05 * (t > 20))
    t, error = slip_error(made, drive)
    assert np.abs(error[(t > 20) & (t < 24)]).max() < 0.06
    assert np.abs(error[t > 24]).mean() < 0.008


def test_a_throttle_step_is_a_motion_and_no_miscount():
    drive = Drive(
        speed=lambda t: 1.8 + 0.25 * np.tanh((t - 10) / 0.15),
        slip=lambda t: 0.06 + 0.04 * np.tanh((t - 10) / 0.1),
        duration_s=14.0,
    )
    t, error = slip_error(streams(drive, setup()), drive)
    assert np.abs(error[t > 9]).max() < 0.06
    assert np.abs(error[t > 11]).mean() < 0.008


def test_counts_that_cannot_be_are_believed_when_they_go_on():
    drive = Drive(duration_s=12.0)
    made = counted(streams(drive, setup()), ["rl", "rr"], lambda t: np.where(t > 6, 2.5, 1.0))
    _, rows = SLIP_EKF.run(SLIP_EKF.init(setup()), made)
    t = seconds(rows["epoch_ns"])
    wheel = 2.5 * drive.speed(t) / (1 - drive.slip(t))
    assert np.abs(rows["wheel_speed_mps"] - wheel)[t > 7].max() < 0.2


def test_a_towed_wheel_that_lags_is_in_the_air_until_it_turns_again():
    at_speed, lagging = np.array([2.0, 2.0, 2.0, 2.0]), np.array([2.0, 1.9, 2.0, 2.0])
    assert in_the_air(at_speed, 0.0, 0, NOMINAL[0]) == 0
    assert in_the_air(lagging, -0.1, 0, NOMINAL[0]) == 2
    assert in_the_air(at_speed, -0.04, 2, NOMINAL[0]) == 2
    assert in_the_air(at_speed, -0.01, 2, NOMINAL[0]) == 0


def test_in_reverse_the_slower_wheel_is_in_the_air_too():
    lagging = np.array([-2.0, -1.9, -2.0, -2.0])
    assert in_the_air(lagging, 0.1, 0, NOMINAL[0]) == 2
    assert in_the_air(-lagging, -0.1, 0, NOMINAL[0]) == 2
    assert in_the_air(lagging[[1, 0, 2, 3]], -0.1, 0, NOMINAL[0]) == 1
    # 3 % of the faster one
    assert in_the_air(np.array([-2.0, -1.0, -2.0, -2.0]), 0.05, 0, NOMINAL[0]) == 0


@pytest.mark.parametrize("wheel", ["fl", "fr"])
def test_backwards_too_a_towed_wheel_in_the_air_is_left_out(wheel):
    back = Drive(
        speed=lambda t: -1.6 + 0.2 * np.sin(0.9 * t), slip=lambda t: 0.05 + 0.0 * t, duration_s=40.0
    )
    made = counted(streams(back, setup()), [wheel], lambda t: np.exp(-np.maximum(t - 20, 0) / 10))
    made = blind(made, 21.0)
    _, rows = SLIP_EKF.run(SLIP_EKF.init(setup()), made)
    t = seconds(rows["epoch_ns"])
    assert np.abs(rows["speed_mps"] - back.speed(t))[t > 25].mean() < 0.03
