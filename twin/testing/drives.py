"""Streams of a straight drive whose speed and slip are known functions of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.streams import GnssSetup, ImuSetup, Setup, Streams, Table, WheelsSetup

Array = NDArray[np.float64]
Of = Callable[[Array], Array]
"""A quantity over time [s]."""
Noise = Callable[[float, tuple[int, ...]], Array]

RADIUS_M = {"fl": 0.6, "fr": 0.6, "rl": 0.8, "rr": 0.8}
GRAVITY_MPS2 = 9.81


def setup(**overrides: Any) -> Setup:
    """A tractor's set-up with data-sheet noise; `overrides` are fields of `Setup`."""
    fields: dict[str, Any] = {
        "machine": "synthetic",
        "wheelbase_m": 2.55,
        "track_front_m": 1.7,
        "track_rear_m": 1.7,
        "cg_x_m": 0.9,
        "wheels": WheelsSetup(rate_hz=50.0, radius_m=RADIUS_M, counts_per_turn=4000),
        "gnss": GnssSetup(
            rate_hz=20.0,
            lever_arm_m=(0.5, 0.0, 2.9),
            position_sd_m=0.01,
            velocity_sd_mps=0.03,
            heading_sd_rad=0.003,
        ),
        "imu": ImuSetup(
            rate_hz=50.0,
            lever_arm_m=(0.4, 0.0, 0.0),
            gyro_noise_radps_rthz=1e-4,
            accel_noise_mps2_rthz=4e-3,
            gyro_bias_sd_radps=0.002,
            accel_bias_sd_mps2=0.1,
        ),
    }
    return Setup(**(fields | overrides))


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A straight drive along a heading; speed [m/s] and slip of the rear wheels over time."""

    speed: Of = lambda t: 1.6 + 0.2 * np.sin(0.9 * t)
    slip: Of = lambda t: 0.12 + 0.05 * np.sin(0.5 * t)
    duration_s: float = 10.0
    heading_rad: float = 0.7
    gnss_hz: float = 20.0
    imu_hz: float = 50.0
    wheels_hz: float = 50.0
    gnss_delay_s: float = 0.0
    ticks: bool = True
    noise: float = 1.0
    """Scale of all noise; 0 for none (ticks are then not rounded)."""
    pitch: Of = lambda t: 0.0 * t
    """Pitch, nose up [rad]: gravity's leak into the accelerometer, and the antenna's motion."""


def times(drive: Drive, hz: float) -> Array:
    """Sample times at a rate [s]."""
    return np.arange(1, int(drive.duration_s * hz) + 1) / hz


def stamps(t: Array, delay_s: float = 0.0) -> Table:
    """Epochs and arrivals of samples [ns]; the drive begins at 1 s."""
    epoch = np.round(t * 1e9).astype(np.int64) + 1_000_000_000
    return {"epoch_ns": epoch, "arrival_ns": epoch + round(delay_s * 1e9)}


def seconds(epoch_ns: NDArray[np.int64]) -> Array:
    """Time since the drive began [s]."""
    return np.asarray((epoch_ns - 1_000_000_000) * 1e-9, np.float64)


def derivative(f: Of, t: Array) -> Array:
    """Central difference of a function of time."""
    return (f(t + 1e-4) - f(t - 1e-4)) / 2e-4


def streams(drive: Drive, of: Setup, seed: int = 1) -> Streams:
    """Synthetic samples of GNSS without positions, IMU and wheels for a straight drive.

    Args:
        drive: speed, slip and rates. Its `noise` multiplies the sd of the set-up.
        of: lever arms and sd of GNSS and IMU. Wheels have radii and counts of this module.
        seed: of the noise. Encoder counts are rounded and have no other noise.

    Raises:
        ValueError: the set-up has no gnss or no imu.
    """
    if of.gnss is None or of.imu is None:
        raise ValueError("a drive needs a set-up with gnss and imu")
    rng = np.random.default_rng(seed)

    def noise(sd: float, shape: tuple[int, ...]) -> Array:
        return drive.noise * sd * rng.standard_normal(shape)

    t = times(drive, drive.gnss_hz)
    pitch_rate = -derivative(drive.pitch, t)
    v = drive.speed(t) + pitch_rate * of.gnss.lever_arm_m[2]
    c, s = np.cos(drive.heading_rad), np.sin(drive.heading_rad)
    sd = of.gnss.velocity_sd_mps
    gnss = stamps(t, drive.gnss_delay_s) | {
        "v_east_mps": v * c + noise(sd, t.shape),
        "v_north_mps": v * s + noise(sd, t.shape),
        "v_up_mps": pitch_rate * -of.gnss.lever_arm_m[0] + noise(sd, t.shape),
        "heading_rad": drive.heading_rad + noise(of.gnss.heading_sd_rad, t.shape),
        "quality": np.full(t.shape, 4),
    }
    t = times(drive, drive.imu_hz)
    root = np.sqrt(drive.imu_hz)
    swung = -derivative(lambda at: derivative(drive.pitch, at), t) * of.imu.lever_arm_m[2]
    accel_x = derivative(drive.speed, t) + GRAVITY_MPS2 * np.sin(drive.pitch(t)) + swung
    accel_sd, gyro_sd = of.imu.accel_noise_mps2_rthz * root, of.imu.gyro_noise_radps_rthz * root
    imu = stamps(t) | {
        "gyro_x_radps": noise(gyro_sd, t.shape),
        "gyro_y_radps": -derivative(drive.pitch, t) + noise(gyro_sd, t.shape),
        "gyro_z_radps": noise(gyro_sd, t.shape),
        "accel_x_mps2": accel_x + noise(accel_sd, t.shape),
        "accel_y_mps2": noise(accel_sd, t.shape),
        "accel_z_mps2": GRAVITY_MPS2 + noise(accel_sd, t.shape),
    }
    return Streams({"gnss": gnss, "imu": imu, "wheels": _wheels(drive, noise)})


def _wheels(drive: Drive, noise: Noise) -> Table:
    t = times(drive, drive.wheels_hz)
    table = stamps(t)
    fine = np.arange(0, len(t) * 20 + 1) / (20 * drive.wheels_hz)
    for wheel, radius in RADIUS_M.items():
        if not drive.ticks:
            turned = radius * derivative(drive.pitch, t)
            table[f"speed_{wheel}_mps"] = (
                wheel_speed(drive, wheel, t) + turned + noise(0.02, t.shape)
            )
            continue
        w = wheel_speed(drive, wheel, fine)
        path = np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(fine))])
        turned = drive.pitch(fine[20::20]) - drive.pitch(np.zeros(1))  # counters turn with the body
        ticks = (path[20::20] / radius + turned) / (2 * np.pi) * 4000
        table[f"ticks_{wheel}"] = np.floor(ticks).astype(np.int64) if drive.noise else ticks
    if not drive.ticks:
        table["speed_sd_mps"] = np.full(t.shape, 0.02)
    return table


def wheel_speed(drive: Drive, wheel: str, t: Array) -> Array:
    """Rim speed w R of a wheel: `rim_speed` of the driven ones, that of the ground of the rest."""
    return rim_speed(drive.speed(t), drive.slip(t)) if wheel in ("rl", "rr") else drive.speed(t)


def rim_speed(speed: Array, slip: Array) -> Array:
    """The speed w R that has a slip s = (w R - v) / max(|w R|, |v|) over ground speed v [m/s].

    w R = v / (1 - |s|)   where the wheel drives: s and v have one sign
    w R = v (1 - |s|)     where it brakes
    """
    kept = 1.0 - np.abs(slip)
    return np.where(slip * speed >= 0.0, speed / kept, speed * kept)
