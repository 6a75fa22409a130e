"""Trials of the IMA-PKF paper's simulation as streams, and the errors estimators make in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from scenarios.ima_pkf import RATE_HZ, SD, Signals, Trial, simulate
from twin.streams import GnssSetup, ImuSetup, Setup, Streams, WheelsSetup

Array = NDArray[np.float64]

SETTLED_S = 1.0
"""Errors are told from the start, and from here on beside it."""
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
        accel_bias_sd_mps2=0.1,
    ),
)
"""What the estimators are told; the paper's simulation has no geometry."""


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


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Errors of slip in one trial."""

    mae: float
    rmse: float
    largest: float
    rmse_settled: float
    """From 1 s on."""


def errors(estimate: Array, truth: Array, time_s: Array) -> Errors:
    """Errors over a trial. Shapes (n,); a NaN anywhere is a NaN in all."""
    off = np.abs(estimate - truth)
    late = off[time_s > SETTLED_S]
    return Errors(
        mae=float(np.mean(off)),
        rmse=float(np.sqrt(np.mean(off**2))),
        largest=float(np.max(off)),
        rmse_settled=float(np.sqrt(np.mean(late**2))),
    )


def try_all(trial: Trial, estimators: Mapping[str, Any]) -> dict[str, Errors]:
    """Errors of each estimator in one trial; who has a seed takes the trial's."""
    signals = simulate(trial)
    measured, out = streams(signals), {}
    for name, estimator in estimators.items():
        if hasattr(estimator, "seed"):
            estimator = replace(estimator, seed=trial.seed)
        _, table = estimator.run(estimator.init(SETUP), measured)
        out[name] = errors(table["slip"], signals.slip, signals.time_s)
    return out


def study(
    trials: list[Trial], estimators: Mapping[str, Any], jobs: int = 1
) -> dict[str, list[Errors]]:
    """Errors of each estimator in each trial."""
    tried = Parallel(n_jobs=jobs)(delayed(try_all)(trial, estimators) for trial in trials)
    return {name: [each[name] for each in tried] for name in estimators}


def mean_and_interval(values: list[float]) -> tuple[float, float, float]:
    """Mean over seeds and its 95 % interval by Student's t; the mean thrice for a single seed."""
    from scipy.stats import t  # late: slow to import

    mean, n = float(np.mean(values)), len(values)
    if n < 2:
        return mean, mean, mean
    half = float(t.ppf(0.975, n - 1) * np.std(values, ddof=1) / np.sqrt(n))
    return mean, mean - half, mean + half
