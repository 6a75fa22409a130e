"""The driver: steering geometry in closed form, a line held, a depth reached."""

import math

import numpy as np
import pytest

from twin.simulation.driver import (
    DriverState,
    DriverTask,
    HitchControl,
    Observation,
    ackermann,
    drive,
)

L, TRACK = 2.55, 1.8
TASK = DriverTask(
    wheelbase_m=L, track_m=TRACK, approach_m=5.0, depth_m=0.25, full_depth_m=0.2375,
    raised_rad=0.6, work_rad=0.05, throttle=0.5, hitch=HitchControl.DEPTH,
)  # fmt: skip


@pytest.mark.parametrize("steer", [-0.6, -0.1, 0.02, 0.5])
def test_both_front_wheels_roll_about_one_point_on_the_rear_axle(steer):
    left, right = ackermann(steer, L, TRACK)
    centre_m = L / math.tan(steer)  # to the left of the rear-axle centre
    assert L / math.tan(left) + 0.5 * TRACK == pytest.approx(centre_m)
    assert L / math.tan(right) - 0.5 * TRACK == pytest.approx(centre_m)
    assert abs(left) > abs(right) if steer > 0 else abs(right) > abs(left)


def test_straight_ahead_both_wheels_are_straight():
    assert ackermann(0.0, L, TRACK) == (0.0, 0.0)


def follow(left_m, heading_rad, speed_mps=1.5, seconds=90.0):
    """Lateral errors of a kinematic bicycle under the driver."""
    driver, dt_s, along, path = DriverState(lift_rad=0.6), 0.02, 0.0, []
    for _ in range(round(seconds / dt_s)):
        driver = drive(TASK, driver, Observation(along, left_m, heading_rad, 0.0), dt_s)
        along += speed_mps * math.cos(heading_rad) * dt_s
        left_m += speed_mps * math.sin(heading_rad) * dt_s
        heading_rad += speed_mps * math.tan(driver.steer_rad) / L * dt_s
        path.append((left_m, heading_rad))
    return np.array(path)


@pytest.mark.parametrize(("left_m", "heading"), [(1.0, 0.0), (-0.5, 0.3), (0.0, -0.5)])
def test_the_line_is_found_and_held(left_m, heading):
    path = follow(left_m, heading)
    assert np.all(np.abs(path[-250:]) < 1e-3)
    assert np.abs(path[:, 0]).max() < 2.0
    mirrored = follow(-left_m, -heading)
    assert mirrored == pytest.approx(-path, abs=1e-9)


def test_a_force_that_stays_is_steered_against_until_the_line_is_held():
    """As a cross-slope does: the machine drifts a degree to the right of its heading."""
    driver, dt_s, left_m, heading_rad = DriverState(lift_rad=0.6), 0.02, 0.0, 0.0
    for k in range(6000):
        driver = drive(TASK, driver, Observation(0.03 * k, left_m, heading_rad, 0.0), dt_s)
        left_m += 1.5 * (math.sin(heading_rad) - math.radians(1.0)) * dt_s
        heading_rad += 1.5 * math.tan(driver.steer_rad) / L * dt_s
    assert left_m == pytest.approx(0.0, abs=0.002)
    assert heading_rad == pytest.approx(math.radians(1.0), abs=1e-3)


def test_controls_move_no_faster_than_a_driver_does():
    driver = DriverState(lift_rad=0.6)
    turned = drive(TASK, driver, Observation(10.0, -3.0, 0.0, 0.0), 0.02)
    assert turned.steer_rad == pytest.approx(0.4 * 0.02)
    assert turned.lift_rad == pytest.approx(0.6 - 0.35 * 0.02)


def test_the_plough_stays_up_for_the_approach_and_without_a_plough():
    driver = DriverState(lift_rad=0.6)
    assert drive(TASK, driver, Observation(4.99, 0.0, 0.0, 0.0), 0.02).lift_rad == 0.6
    bare = TASK._replace(hitch=HitchControl.RAISED)
    assert drive(bare, driver, Observation(50.0, 0.0, 0.0, 0.0), 0.02).lift_rad == 0.6


@pytest.mark.parametrize("error_m", [0.06, -0.04])
def test_a_hitch_that_is_set_wrong_is_corrected(error_m):
    """Depth = set depth - error - lever * (lift - work angle): found whichever the error's sign."""
    driver, depth, along, lever_m = DriverState(lift_rad=0.6), 0.0, 5.0, 1.4
    for _ in range(3000):
        driver = drive(TASK, driver, Observation(along, 0.0, 0.0, depth), 0.02)
        depth = max(0.0, 0.25 - error_m - lever_m * (driver.lift_rad - TASK.work_rad))
        along += 0.03
    assert depth == pytest.approx(0.25, abs=0.001)
    assert 5.0 < driver.full_depth_at_m < 30.0
