import dataclasses

import numpy as np
import pytest

from estimators import signals
from estimators.layout import GNSS, IMU, WHEELS
from twin.streams import Streams
from twin.testing import drives as synthetic
from twin.testing.drives import Drive

SETUP = synthetic.setup()


def read(streams, setup=SETUP):
    return signals.read(signals.start(setup), streams)[1]


def of(records, sensor):
    return records[records["sensor"] == sensor]


def test_wheel_speed_is_ticks_over_time():
    t = np.array([0.02, 0.04, 0.07, 0.09])
    ticks = np.array([100, 110, 140, 140])
    wheels = of(read(Streams({"wheels": synthetic.stamps(t) | {"ticks_rl": ticks}})), WHEELS)
    per_tick = 2 * np.pi * 0.8 / 4000
    speed = wheels["wheel_mps"][:, 2]
    assert np.isnan(speed[0])
    assert speed[1:] == pytest.approx(per_tick * np.array([10 / 0.02, 30 / 0.03, 0.0]))
    assert wheels["wheel_age_s"][1:, 2] == pytest.approx([0.01, 0.015, 0.01])
    assert np.isnan(wheels["wheel_mps"][:, 3]).all()


def rear_left(t, ticks):
    """Speeds of the rear left wheel from its counts at 50 Hz."""
    stamps = synthetic.stamps(t)
    stamps["arrival_ns"] = np.maximum.accumulate(stamps["arrival_ns"])
    streams = Streams({"wheels": stamps | {"ticks_rl": ticks}})
    return of(read(streams), WHEELS)["wheel_mps"][:, 2]


def test_over_a_gap_counts_tell_no_speed():
    t = np.array([0.02, 0.04, 0.06, 3.06, 3.08])
    speed = rear_left(t, np.array([5000, 5020, 5040, 40, 60]))
    assert np.isfinite(speed).tolist() == [False, True, True, False, True]
    assert speed[4] == pytest.approx(speed[1])


def test_a_counter_that_begins_anew_without_a_gap_tells_no_speed():
    speed = rear_left(0.02 * np.arange(1, 6), np.array([50_000, 50_020, 0, 20, 40]))
    assert np.isnan(speed[2])
    assert speed[3:] == pytest.approx(speed[1])


def test_a_clock_that_is_set_back_costs_the_samples_until_it_has_caught_up():
    t = np.array([0.02, 0.04, 0.06, 0.03, 0.05, 0.07, 0.09])
    speed = rear_left(t, 5000 + 20 * np.arange(7))
    assert np.isnan(speed[3:6]).all()
    assert speed[6] == pytest.approx(speed[1])


def test_late_samples_change_no_speed():
    t = np.array([0.02, 0.04, 0.06, 0.04, 0.08])
    speed = rear_left(t, np.array([5000, 5020, 5040, 5020, 5060]))
    assert speed[4] == pytest.approx(speed[1])


def test_a_missing_count_widens_the_next_difference():
    t = np.array([0.02, 0.04, 0.06])
    ticks = np.array([100.0, np.nan, 140.0])
    wheels = read(Streams({"wheels": synthetic.stamps(t) | {"ticks_rl": ticks}}))
    per_tick = 2 * np.pi * 0.8 / 4000
    assert np.isnan(wheels["wheel_mps"][1, 2])
    assert wheels["wheel_mps"][2, 2] == pytest.approx(per_tick * 40 / 0.04)


def test_sd_of_ticks_is_that_of_their_rounding():
    drive = Drive(duration_s=60.0)
    wheels = of(read(synthetic.streams(drive, SETUP)), WHEELS)[1:]
    middle = synthetic.seconds(wheels["epoch_ns"]) - wheels["wheel_age_s"][:, 2]
    error = wheels["wheel_mps"][:, 2] - synthetic.wheel_speed(drive, "rl", middle)
    assert np.std(error) == pytest.approx(wheels["wheel_sd_mps"][0, 2], rel=0.1)


def test_antenna_on_a_pitching_roof_is_brought_to_the_axle():
    """The antenna moves at up to 0.24 m/s and its samples come 0.1 s late."""
    drive = Drive(
        duration_s=20.0,
        gnss_delay_s=0.1,
        noise=0.0,
        pitch=lambda t: 0.0087 * np.sin(2 * np.pi * 1.5 * t),
    )
    gnss = of(read(synthetic.streams(drive, SETUP)), GNSS)
    t = synthetic.seconds(gnss["epoch_ns"])
    swing = 2.9 * synthetic.derivative(drive.pitch, t)
    error = (gnss["v_x_mps"] - drive.speed(t))[t > 2]
    assert np.std(swing) > 0.15
    assert np.std(error) < 0.03 * np.std(swing)


def test_a_body_that_pitches_once_is_no_gyro_with_a_bias():
    """Two degrees in the third second: taken for a bias, 25 mm/s at a roof 2.9 m up."""
    drive = Drive(noise=0.0, pitch=lambda t: 0.035 * np.clip(t - 2.0, 0.0, 1.0))
    gnss = of(read(synthetic.streams(drive, SETUP)), GNSS)
    t = synthetic.seconds(gnss["epoch_ns"])
    assert np.abs(gnss["v_x_mps"] - drive.speed(t))[t > 3.2] == pytest.approx(0.0, abs=0.003)


def test_a_gyros_bias_as_large_as_the_set_up_says_is_found_in_a_minute():
    bias = 0.004
    drive = Drive(duration_s=70.0, noise=0.0)
    streams = synthetic.streams(drive, SETUP)
    turned = streams["imu"] | {"gyro_y_radps": streams["imu"]["gyro_y_radps"] + bias}
    told = dataclasses.replace(SETUP.imu, gyro_bias_sd_radps=bias)
    setup = dataclasses.replace(SETUP, imu=told)
    gnss = of(read(Streams({**streams.tables, "imu": turned}), setup), GNSS)
    t = synthetic.seconds(gnss["epoch_ns"])
    error = (gnss["v_x_mps"] - drive.speed(t))[t > 60]
    assert np.abs(error.mean()) < 0.1 * bias * setup.gnss.lever_arm_m[2]


def circle(yaw_rate=0.3, v_x=1.8, v_y=0.0, mount=0.0, n=100):
    """Antenna velocities of a machine that turns with a constant velocity of its rear axle."""
    t = np.arange(1, n + 1) / 20
    heading = 0.4 + yaw_rate * t
    lever = SETUP.gnss.lever_arm_m
    body_x, body_y = v_x - yaw_rate * lever[1], v_y + yaw_rate * lever[0]
    c, s = np.cos(heading), np.sin(heading)
    gnss = synthetic.stamps(t) | {
        "v_east_mps": body_x * c - body_y * s,
        "v_north_mps": body_x * s + body_y * c,
        "heading_rad": (heading + mount + np.pi) % (2 * np.pi) - np.pi,
    }
    return Streams(
        {"gnss": gnss, "imu": synthetic.stamps(t) | {"gyro_z_radps": np.full(n, yaw_rate)}}
    )


def lever_setup(**overrides):
    gnss = dataclasses.replace(SETUP.gnss, lever_arm_m=(0.5, 0.3, 2.9), **overrides)
    return synthetic.setup(gnss=gnss)


@pytest.mark.parametrize("mount", [0.0, 0.2])
def test_turning_makes_no_sideslip_at_the_axle_and_cg_times_yaw_rate_ahead(mount, monkeypatch):
    setup = lever_setup(heading_mount_rad=mount)
    monkeypatch.setattr("test_signals.SETUP", setup)
    # the gyro's first sample comes with the second GNSS sample
    gnss = of(read(circle(mount=mount), setup), GNSS)[2:]
    assert gnss["v_x_mps"] == pytest.approx(1.8, abs=1e-9)
    assert gnss["v_y_held_mps"] == pytest.approx(0.0, abs=1e-9)
    rear = gnss["sideslip_rear_m"]
    assert rear - rear[0] == pytest.approx(0.0, abs=1e-9)
    turned = gnss["sideslip_m"][-1] - gnss["sideslip_m"][0]
    assert turned == pytest.approx(0.9 * 0.3 * (len(gnss) - 1) / 20)


def test_heading_is_carried_by_the_gyro_when_the_receiver_loses_it():
    streams = circle(v_y=0.1)
    heading = streams["gnss"]["heading_rad"]
    streams["gnss"]["heading_rad"] = np.where(np.arange(len(heading)) < 40, heading, np.nan)
    gnss = of(read(streams), GNSS)[2:]
    assert gnss["v_y_held_mps"] == pytest.approx(0.1, abs=1e-9)


def test_without_heading_the_wheels_give_the_sign_and_sideslip_is_unknown():
    t = np.arange(1, 50) / 20
    still = {"v_east_mps": 0 * t + 1.2, "v_north_mps": 0 * t + 0.5}
    back = {"speed_rl_mps": 0 * t - 1.4, "speed_rr_mps": 0 * t - 1.4}
    tables = {"gnss": synthetic.stamps(t) | still, "wheels": synthetic.stamps(t) | back}
    gnss = of(read(Streams(tables)), GNSS)[1:]
    assert gnss["v_x_mps"] == pytest.approx(-1.3)
    assert np.isnan(gnss["v_y_held_mps"]).all()


def test_speed_is_along_the_ground_on_a_grade():
    t, grade = np.arange(1, 100) / 20, np.radians(8)
    gnss = {
        "v_east_mps": 0 * t + 1.5 * np.cos(grade),
        "v_north_mps": 0 * t,
        "v_up_mps": 0 * t + 1.5 * np.sin(grade),
        "heading_rad": 0 * t,
    }
    assert read(Streams({"gnss": synthetic.stamps(t) | gnss}))["v_x_mps"] == pytest.approx(1.5)


def test_sideslip_is_along_the_ground_on_a_cross_slope():
    t, slope = np.arange(1, 500) / 50, np.radians(18)
    gnss = {
        "v_east_mps": 0 * t + 1.0,
        "v_north_mps": 0 * t - 0.05 * np.cos(slope),
        "heading_rad": 0 * t,
    }
    imu = {"accel_x_mps2": 0 * t, "accel_y_mps2": 0 * t + 9.81 * np.sin(slope)}
    streams = Streams({"gnss": synthetic.stamps(t) | gnss, "imu": synthetic.stamps(t) | imu})
    records = of(read(streams), GNSS)[2:]
    assert records["v_y_held_mps"] == pytest.approx(-0.05)
    amount = records["sideslip_rear_m"][-1] - records["sideslip_rear_m"][0]
    assert amount == pytest.approx(-0.05 * (len(records) - 1) / 50)


def test_quick_pitching_leaves_the_accelerometer_and_a_slope_stays():
    drive = Drive(
        duration_s=60.0,
        noise=0.0,
        speed=lambda t: 1.5 + 0 * t,
        pitch=lambda t: 0.05 + 0.02 * np.sin(2 * np.pi * 0.8 * t),
    )
    imu = of(read(synthetic.streams(drive, SETUP)), IMU)
    accel = imu["accel_mps2"][synthetic.seconds(imu["epoch_ns"]) > 30]
    assert np.mean(accel) == pytest.approx(9.81 * np.sin(0.05), abs=0.01)
    assert np.std(accel) < 0.1 * 9.81 * 0.02 / np.sqrt(2)


def test_a_gap_is_not_filled_with_the_rate_at_its_end():
    """A second of the last pitch rate would be 0.09 rad, 0.9 m/s2 for seconds."""
    drive = Drive(duration_s=6.0, noise=0.0, pitch=lambda t: 0.01 * np.sin(9 * t))
    imu = synthetic.streams(drive, SETUP)["imu"]
    after = imu["epoch_ns"] > 4_000_000_000
    imu = {k: v + 20_000_000_000 * after if k.endswith("_ns") else v for k, v in imu.items()}
    t, accel = synthetic.times(drive, drive.imu_hz), of(read(Streams({"imu": imu})), IMU)
    error = accel["accel_mps2"] - synthetic.derivative(drive.speed, t)
    assert np.abs(error[after]).max() < 2 * 9.81 * 0.01


def test_no_fix_is_no_velocity():
    streams = circle()
    streams["gnss"]["quality"] = np.where(np.arange(100) < 50, 4, 0)
    gnss = of(read(streams), GNSS)
    assert np.isfinite(gnss["v_x_mps"][:50]).all()
    assert np.isnan(gnss["v_x_mps"][50:]).all()
