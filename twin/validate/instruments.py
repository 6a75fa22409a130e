"""Layer 7: sensors against their data sheets, and a receiver at rest against a real one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.sensors import Gnss, Imu, Outage, gnss, imu
from twin.streams import Table
from twin.trajectory.trajectory import Trajectory
from twin.validate.check import Basis, Check, near

Array = NDArray[np.float64]

GYRO = ("gyro_x_radps", "gyro_y_radps", "gyro_z_radps")
ACCEL = ("accel_x_mps2", "accel_y_mps2", "accel_z_mps2")
STAND_S = 800.0
OUTPUT_HZ = 50.0


def standing(duration_s: float, step_ns: int, speed_mps: float = 0.0) -> Trajectory:
    """A machine that stands level with its engine off; an antenna that reports another speed."""
    n = round(duration_s * 1e9 / step_ns) + 1
    zero = np.zeros((n, 3))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    columns = {
        "gyro_b": zero,
        "imu_accel_b": zero + np.array([0.0, 0.0, 9.81]),
        "world_from_body": level,
        "antenna_main_w": zero + np.array([0.5, 0.5, 2.8]),
        "antenna_main_velocity_w": zero + np.array([speed_mps, 0.0, 0.0]),
        "antenna_aux_w": zero + np.array([0.5, -0.5, 2.8]),
        "engine_radps": np.zeros(n),
    }
    return Trajectory(step_ns * np.arange(n, dtype=np.int64), columns)


def _sampled(
    module: Any, config: Any, duration_s: float, step_ns: int, speed_mps: float = 0.0
) -> Table:
    trajectory = standing(duration_s, step_ns, speed_mps)
    _, table = module.sample(config, module.init(config, 1, 0), trajectory)
    return dict(table)


def allan_deviation(rate: Array, tau_s: float, rate_hz: float) -> float:
    """Overlapping Allan deviation of a rate; IEEE Std 952, annex C."""
    m = round(tau_s * rate_hz)
    angle = np.concatenate([[0.0], np.cumsum(rate)]) / rate_hz
    second = angle[2 * m :] - 2.0 * angle[m:-m] + angle[: -2 * m]
    return float(np.sqrt(np.mean(second**2) / (2.0 * tau_s**2)))


def inertial() -> list[Check]:
    """Allan deviation of gyroscopes and accelerometers, its level at 1 s and its slope."""
    config = Imu()
    table = _sampled(imu, config, STAND_S, 5_000_000)
    out = []
    for name, columns, density, unit, scale in (
        ("gyroscopes", GYRO, config.gyro_noise_radps_rthz, "deg/s/rtHz", 180.0 / np.pi),
        ("accelerometers", ACCEL, config.accel_noise_mps2_rthz, "ug/rtHz", 1e6 / 9.80665),
    ):
        short, one, long = (_pooled(table, columns, tau) for tau in (0.5, 1.0, 4.0))
        out += [
            near(
                f"{name} at rest",
                "Allan deviation at 1 s: white noise density",
                scale * one,
                unit,
                scale * density,
                relative=0.1,
                basis=Basis(
                    grade="published",
                    source="MPU-60xx/92xx class: 0.005 deg/s/rtHz, 300 to 400 ug/rtHz",
                    why="800 s of three axes give 2 to 3 %; the anti-alias filter takes some",
                ),
            ),
            near(
                f"{name} at rest",
                "slope of the Allan deviation, 0.5 to 4 s",
                float(np.log(long / short) / np.log(8.0)),
                "1",
                -0.5,
                absolute=0.05,
                basis=Basis(
                    source="IEEE Std 952: N / sqrt(tau)",
                    why="the same statistics",
                    grade="published",
                ),
            ),
        ]
    return out


def _pooled(table: Table, columns: tuple[str, ...], tau_s: float) -> float:
    """Allan deviation of three axes together."""
    of_axes = [allan_deviation(table[c], tau_s, OUTPUT_HZ) ** 2 for c in columns]
    return float(np.sqrt(np.mean(of_axes)))


def receiver() -> list[Check]:
    """Doppler velocity, position and heading of the receiver, in motion and at rest."""
    config = Gnss()
    table = _sampled(gnss, config, 600.0, 50_000_000)
    long = _sampled(gnss, Gnss(rate_hz=1.0), 60_000.0, 1_000_000_000)
    moving = _sampled(gnss, config, 600.0, 50_000_000, speed_mps=1.5)
    velocity = np.concatenate([moving["v_east_mps"] - 1.5, moving["v_north_mps"]])
    place = np.concatenate([long[axis] - long[axis].mean() for axis in ("east_m", "north_m")])
    return [
        near(
            "GNSS receiver in motion",
            "sd of the Doppler velocity",
            velocity.std(),
            "m/s",
            config.velocity_sd_mps,
            relative=0.05,
            basis=Basis(
                grade="published",
                source="receivers of this class: 0.02 to 0.04 m/s",
                why="24 000 samples give half a per cent",
            ),
        ),
        near(
            "GNSS receiver at rest",
            "sd of the fixed position",
            1e3 * place.std(),
            "mm",
            8.0,
            absolute=1.5,
            basis=Basis(
                source="UM980 user manual: 8 mm + 1 ppm horizontal, RMS",
                why="1000 correlation times of 60 s; our white and coloured parts are split by "
                "assumption",
                grade="published",
            ),
        ),
        near(
            "GNSS receiver at rest",
            "sd of the heading on 1 m",
            np.degrees(table["heading_rad"].std()),
            "deg",
            0.2,
            relative=0.05,
            basis=Basis(
                source="dual antenna receivers: 0.1 to 0.2 deg per metre",
                why="12 000 samples give one per cent",
                grade="published",
            ),
        ),
    ]


STOOD = "u-blox M8U on a New Holland T7.165S that stands, 92 min of a drive"


def stopped() -> list[Check]:
    """Errors of a receiver at rest, beside a real one."""
    without = Gnss(rate_hz=1.0, outages=(Outage(start_s=0.0, duration_s=1e6),))
    table = _sampled(gnss, without, 60_000.0, 1_000_000_000)
    speed = np.hypot(table["v_east_mps"], table["v_north_mps"])
    place = np.stack([table["east_m"], table["north_m"]])[:, 60:]
    speeds = [
        near(
            "GNSS receiver at rest",
            f"{share} % of its Doppler speeds are below",
            1e3 * float(np.percentile(speed, share)),
            "mm/s",
            measured,
            relative=0.1,
            basis=Basis(
                grade="measured",
                source=STOOD,
                why="60 000 samples give one per cent; the measured ones are of one receiver",
            ),
        )
        for share, measured in ((50, 3.7), (99, 9.0))
    ]
    wander = [
        near(
            "GNSS receiver at rest without corrections",
            f"change of the position in {lag_s} s, each axis, rms",
            float(np.sqrt(np.mean((place[:, lag_s:] - place[:, :-lag_s]) ** 2))),
            "m",
            measured,
            relative=0.5,
            basis=Basis(
                grade="measured",
                source=STOOD,
                why="its five stops of 2 to 71 min differ among themselves by a factor of two",
            ),
        )
        for lag_s, measured in ((10, 0.155), (60, 0.58))
    ]
    return [*speeds, *wander]
