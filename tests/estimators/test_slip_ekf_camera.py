"""A camera's speed among the streams of the slip filter."""

import dataclasses

import numpy as np

from estimators.slip_ekf import SLIP_EKF
from twin.streams import CameraSetup, Streams
from twin.testing import drives as synthetic

CAMERA = CameraSetup(
    rate_hz=30.0,
    width_px=1280,
    height_px=800,
    focal_px=1200.0,
    lever_arm_m=(0.5, 0.2, 0.5),
    height_m=0.5,
)
SETUP = synthetic.setup(camera=CAMERA)
DRIVE = synthetic.Drive(duration_s=90.0)
HIGH = 1.015
"""The camera looks from 1.5 % less height than it is said to."""


def with_camera(streams, seed=0, used=lambda t: t >= 0.0):
    rng = np.random.default_rng(seed)
    t = synthetic.times(DRIVE, 30.0)
    seen = used(t)
    camera = synthetic.stamps(t, 0.05) | {
        "v_x_mps": np.where(seen, HIGH * DRIVE.speed(t) + 0.004 * rng.standard_normal(t.shape), 0),
        "v_y_mps": np.zeros_like(t),
        "var_x_m2ps2": np.full_like(t, 0.004**2),
        "interval_s": np.full_like(t, 1.0 / 30.0),
        "used": seen.astype(float),
    }
    return Streams({**streams.tables, "camera": camera})


def blind(streams, after_s=30.0):
    """No GNSS from then on, and nothing that counts the front wheels."""
    seen = synthetic.seconds(streams["gnss"]["epoch_ns"]) < after_s
    gnss = {name: column[seen] for name, column in streams["gnss"].items()}
    wheels = {n: c for n, c in streams["wheels"].items() if n not in ("ticks_fl", "ticks_fr")}
    return Streams({**streams.tables, "gnss": gnss, "wheels": wheels})


def error_and_sd(streams, setup=SETUP):
    _, table = SLIP_EKF.run(SLIP_EKF.init(setup), streams)
    at = synthetic.seconds(table["epoch_ns"])
    late = at > 40.0
    return (table["slip"] - DRIVE.slip(at))[late], table["slip_sd"][late]


def test_it_stands_for_the_receiver_and_its_height_is_learnt_while_that_is_there():
    streams = blind(synthetic.streams(DRIVE, SETUP))
    alone, _ = error_and_sd(streams)
    seen, sd = error_and_sd(with_camera(streams))
    assert np.sqrt(np.mean(seen**2)) < 0.006  # 1.5 % of height not learnt would be 0.013
    assert np.sqrt(np.mean(seen**2)) < 0.25 * np.sqrt(np.mean(alone**2))
    assert np.mean((seen / sd) ** 2) < 2.0


def test_frames_that_show_nothing_are_no_standstill():
    streams = blind(synthetic.streams(DRIVE, SETUP))
    dark, _ = error_and_sd(with_camera(streams, used=lambda t: (t < 50.0) | (t > 55.0)))
    assert np.abs(dark).max() < 0.05


def test_a_camera_that_never_sees_changes_next_to_nothing():
    """Only the steps in which the motion is predicted."""
    streams = synthetic.streams(DRIVE, SETUP)
    plain = dataclasses.replace(SETUP, camera=None)
    _, without = SLIP_EKF.run(SLIP_EKF.init(plain), streams)
    _, dark = SLIP_EKF.run(SLIP_EKF.init(SETUP), with_camera(streams, used=lambda t: t < 0.0))
    assert np.abs(without["slip"] - dark["slip"])[100:].max() < 1e-3
