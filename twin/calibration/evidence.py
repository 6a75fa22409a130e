"""What a log measured in each segment, and how well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.calibration.segments import Segment
from twin.streams import Table

Array = NDArray[np.float64]

CHANNELS = (
    "wheel_speed_mps", "front_speed_mps", "speed_mps", "engine_radps", "engine_load",
    "axle_torque_nm", "draft_pin_n", "fuel_lph",
)  # fmt: skip
"""What is compared, where the log has it."""
TOLERANCES = {
    "wheel_speed_mps": (0.0005, 0.0005), "front_speed_mps": (0.0005, 0.0005),
    "speed_mps": (0.0005, 0.001), "engine_radps": (0.0005, 0.02), "engine_load": (0.002, 0.001),
    "axle_torque_nm": (0.002, 15.0), "draft_pin_n": (0.003, 20.0), "fuel_lph": (0.002, 0.02),
}  # fmt: skip
"""Least sd of a channel's mean: share of the value, and in its unit. So much a rough ground does to
a model of an even one, and a bus that rounds; measured on simulated drives."""
MEMORY_S = 10
"""Noise is followed for so long [s]: draft and ground vary over some 4 m."""


@dataclass(frozen=True)
class Evidence:
    """Means of the channels in each segment."""

    channels: tuple[str, ...]
    segments: tuple[Segment, ...]
    measured: Array
    """Shape (n, c)."""
    covariance: Array
    """Of the means. Shape (n, c, c)."""
    time_s: Array
    floor: Array
    """Least sd of each channel. Shape (c,)."""


def evidence(rows: Table, segments: list[Segment]) -> Evidence:
    """The means of segments with their covariance.

    The covariance over long times of rows of a second, over n: of work, and of driving empty. What
    channels share, as the draft that varies from place to place, is in it.
    """
    channels = tuple(
        c for c in CHANNELS
        if c in rows and all(np.isfinite(rows[c][s.rows]).any() for s in segments)
    )  # fmt: skip
    table = np.stack([rows[c] for c in channels], axis=1)
    measured = np.array([np.nanmean(table[s.rows], axis=0) for s in segments])
    long_run = {working: _long_run([table[s.rows] for s in segments if s.working == working])
                for working in {s.working for s in segments}}  # fmt: skip
    shares, least = np.array([TOLERANCES[c] for c in channels]).T
    covariance = []
    for segment, mean in zip(segments, measured, strict=True):
        part = table[segment.rows]
        covariance.append(
            long_run[segment.working] / len(part) + np.diag((shares * np.abs(mean)) ** 2 + least**2)
        )
    time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
    middle = np.array([np.mean(time_s[s.rows]) for s in segments])
    return Evidence(channels, tuple(segments), measured, np.array(covariance), middle, least)


def _long_run(parts: list[Array]) -> Array:
    """Covariance over long times of parts about the mean of all, N rows, with Bartlett's weights:

        sum over lags k of (1 - |k| / (K + 1)) Gamma_k / (1 - (K + 1) / N)

    The divisor makes up for what the mean of so few rows takes with it.
    """
    mean = np.nanmean(np.concatenate(parts), axis=0)
    left = [np.nan_to_num(part - mean) for part in parts]
    total = sum(len(part) for part in left)
    memory = min(MEMORY_S, total // 3)
    out = sum(part.T @ part for part in left) / total
    for lag in range(1, memory + 1):
        gamma = sum(part[lag:].T @ part[:-lag] for part in left if len(part) > lag) / total
        out = out + (1.0 - lag / (memory + 1)) * (gamma + gamma.T)
    return np.asarray(out / (1.0 - (memory + 1) / total))
