"""Signals of the IMA-PKF paper's simulation, and what of them the estimators see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.streams import GnssSetup, ImuSetup, Setup, Streams, Table, WheelsSetup

Array = NDArray[np.float64]

RATE_HZ = 50.0
SD = {"front": 0.10, "gnss": 0.13, "rear": 0.11, "accel": 0.06, "rear_accel": 0.06}
"""Noise of each signal as R1 and R2 print it [m/s, m/s2]."""
SETUP = Setup(
    machine="ima-pkf",
    wheelbase_m=2.55,
    track_front_m=1.7,
    track_rear_m=1.7,
    cg_x_m=0.9,
    wheels=WheelsSetup(rate_hz=RATE_HZ, radius_m={"fl": 0.6, "fr": 0.6, "rl": 0.8, "rr": 0.8}),
    gnss=GnssSetup(
        rate_hz=RATE_HZ,
        lever_arm_m=(0.0, 0.0, 0.0),
        position_sd_m=0.01,
        velocity_sd_mps=SD["gnss"],
        heading_sd_rad=0.0,
    ),
    imu=ImuSetup(
        rate_hz=RATE_HZ,
        lever_arm_m=(0.0, 0.0, 0.0),
        gyro_noise_radps_rthz=0.0,
        accel_noise_mps2_rthz=SD["accel"] / RATE_HZ**0.5,
        gyro_bias_sd_radps=0.0,
        accel_bias_sd_mps2=0.0,
        gravity=False,
    ),
)
"""Set-up of the estimators; the paper's simulation has no geometry."""


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Truth and measurements of a trial, all at the same epochs; arrays of shape (1500,)."""

    time_s: Array
    ground_mps: Array
    """True ground speed v_e."""
    wheel_mps: Array
    """True theoretical speed of the driven wheels v_q."""
    slip: Array
    """(v_q - v_e) / max(v_q, v_e)."""
    front_mps: Array
    gnss_mps: Array
    rear_mps: Array
    accel_mps2: Array
    rear_accel_mps2: Array
    """NaN without a wheel accelerometer."""


def streams(signals: Signals) -> Streams:
    """The measurements as the streams of a straight drive to the east."""
    epoch_ns = np.round(signals.time_s * 1e9).astype(np.int64)
    stamps = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns}
    zero = np.zeros_like(signals.time_s)
    wheels = stamps | {
        "speed_fl_mps": signals.front_mps,
        "speed_fr_mps": signals.front_mps,
        "speed_rl_mps": signals.rear_mps,
        "speed_rr_mps": signals.rear_mps,
        "speed_sd_mps": np.full_like(zero, SD["rear"]),
        "accel_rl_mps2": signals.rear_accel_mps2,
        "accel_rr_mps2": signals.rear_accel_mps2,
    }
    return Streams(
        {
            "gnss": stamps
            | {"v_east_mps": signals.gnss_mps, "v_north_mps": zero, "heading_rad": zero},
            "imu": stamps | {"accel_x_mps2": signals.accel_mps2},
            "wheels": wheels,
        }
    )


def truth(signals: Signals) -> Table:
    """What the estimates are scored against."""
    return {
        "epoch_ns": np.round(signals.time_s * 1e9).astype(np.int64),
        "speed_mps": signals.ground_mps,
        "wheel_speed_mps": signals.wheel_mps,
        "slip": signals.slip,
    }
