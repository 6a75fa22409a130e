"""The bound of a total sideslip against closed forms."""

import dataclasses
import math

import numpy as np
import pytest

from estimators.bounds import total_sd_m
from estimators.bounds.total import ASKEW_SD_RAD, STANCE_SD_RAD
from twin.streams import GnssSetup, ImuSetup, Setup, Streams

SPEED_MPS, GNSS_HZ = 1.5, 20.0
BEFORE_S, PAUSE_S, START_S, RUN_S = 20.0, 6.0, 26.0, 40.0
FAR, EXACT = 1e3, 1e-6
SETUP = Setup(
    machine="slide",
    wheelbase_m=2.5,
    track_front_m=1.6,
    track_rear_m=1.6,
    cg_x_m=0.0,
    gnss=GnssSetup(
        rate_hz=GNSS_HZ,
        lever_arm_m=(0.0, 0.0, 0.0),
        position_sd_m=FAR,
        velocity_sd_mps=EXACT,
        heading_sd_rad=EXACT,
        heading_mount_rad=-np.pi / 2,
    ),
    imu=ImuSetup(
        rate_hz=50.0,
        lever_arm_m=(0.0, 0.0, 0.0),
        gyro_noise_radps_rthz=1e-9,
        accel_noise_mps2_rthz=4e-3,
        gyro_bias_sd_radps=1e-9,
        accel_bias_sd_mps2=0.1,
    ),
)


def least(before=True, roll_rad=0.0, lean_rad=0.0, changed=None, **noises):
    """The bound of a straight run to the east, which leans by so much.

    `changed` makes other columns of GNSS from the time since the run's start.
    """
    setup = dataclasses.replace(SETUP, gnss=dataclasses.replace(SETUP.gnss, **noises))
    t = np.arange(0.0, RUN_S, 1.0 / GNSS_HZ)
    if before:
        t = np.concatenate([np.arange(0.0, BEFORE_S, 1.0 / GNSS_HZ) - BEFORE_S - PAUSE_S, t])
    t += START_S
    ones = np.ones(len(t))
    gnss = {
        "epoch_ns": np.round(t * 1e9).astype(np.int64),
        "v_east_mps": SPEED_MPS * ones,
        "v_north_mps": 0.0 * ones,
        "heading_rad": -np.pi / 2 * ones,
        "east_m": SPEED_MPS * t,
        "north_m": 0.0 * ones,
    }
    gnss |= changed(t - START_S) if changed else {}
    gnss["arrival_ns"] = gnss["epoch_ns"]
    at = START_S + np.arange(0.0, RUN_S, 0.02)
    some = np.ones(len(at))
    truth = {
        "epoch_ns": np.round(at * 1e9).astype(np.int64),
        "speed_mps": SPEED_MPS * some,
        "v_y_rear_mps": 0.0 * some,
        "qw": math.cos(roll_rad / 2) * some,
        "qx": math.sin(roll_rad / 2) * some,
        "qy": 0.0 * some,
        "qz": 0.0 * some,
    }
    return total_sd_m(setup, Streams({"gnss": gnss}), truth, (START_S, START_S + RUN_S), lean_rad)


def test_without_a_drive_before_the_mounting_angle_goes_on_for_the_whole_way():
    assert least(before=False) == pytest.approx(ASKEW_SD_RAD * SPEED_MPS * RUN_S, rel=0.01)


@pytest.mark.parametrize("noise_mps", [0.01, 0.05])
def test_noise_of_velocity_counts_before_and_in_the_run(noise_mps):
    """var = (s T)^2 (1 / n_before + 1 / n_run)"""
    each = (1.0 / BEFORE_S + 1.0 / RUN_S) / GNSS_HZ
    due = noise_mps * RUN_S * math.sqrt(each)
    assert least(velocity_sd_mps=noise_mps) == pytest.approx(due, rel=0.02)


def test_noise_of_the_heading_counts_as_that_of_the_velocity():
    """var = (s v T)^2 (1 / n_before + 1 / n_run), the gyro being exact"""
    each = (1.0 / BEFORE_S + 1.0 / RUN_S) / GNSS_HZ
    due = 0.003 * SPEED_MPS * RUN_S * math.sqrt(each)
    assert least(heading_sd_rad=0.003) == pytest.approx(due, rel=0.02)


def test_fixed_positions_tell_what_slides():
    noisy = {"velocity_sd_mps": 0.05}
    assert least(position_sd_m=0.008, **noisy) < 0.6 * least(**noisy)


def test_a_body_that_leans_turns_the_baseline_by_the_pitch_that_is_not_known():
    due = STANCE_SD_RAD * math.tan(0.15) * SPEED_MPS * RUN_S
    assert least(roll_rad=0.15) == pytest.approx(due, rel=0.02)
    assert least(roll_rad=0.25, lean_rad=0.1) == pytest.approx(due, rel=0.03)


def test_a_heading_that_is_masked_tells_nothing_more():
    """Without a heading of the run, what is known of the mounting angle does not help it."""

    def masked(t):
        return {"heading_rad": np.where(t > 5.0, np.nan, -np.pi / 2)}

    rough = {"heading_sd_rad": 0.02, "velocity_sd_mps": 0.01}
    assert least(changed=masked, **rough) > 1.1 * least(**rough)


def test_the_sd_that_a_receiver_states_counts_and_a_position_only_where_fixed():
    rough = {"heading_sd_rad": 0.003, "velocity_sd_mps": 0.02, "position_sd_m": 0.008}

    def stated(t):
        return {"velocity_sd_mps": np.where(t > 0.0, 0.06, 0.02)}

    def floating(t):
        return {"quality": np.where(t > 0.0, 5, 4)}

    def noisier(t):
        return {**stated(t), **floating(t)}

    assert least(changed=noisier, **rough) > max(
        least(changed=stated, **rough), least(changed=floating, **rough)
    )
    assert least(changed=floating, **rough) > 1.1 * least(**rough)


def test_it_needs_a_receiver():
    with pytest.raises(ValueError, match=r"setup\.gnss"):
        total_sd_m(dataclasses.replace(SETUP, gnss=None), Streams({}), {}, (0.0, 1.0))
