"""Statistics by which two drives are compared: how speeds and slip change, how often it stops.

A log and a simulated day are both sampled at 1 Hz, as a logger of a machine's bus writes them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twin.streams import Array

STANDS_MPS = 0.05
"""Slower than this a machine stands."""
MOVES_MPS = 0.5
"""Slip counts only where wheel or ground speed is above this."""
RUNS_RPM = 100.0
"""Faster than this an engine runs."""
STEPS_S = (1, 20)


def drive_statistics(
    wheel_mps: Array, ground_mps: Array, engine_rpm: Array, *, engine_on: bool = False
) -> dict[str, float]:
    """Changes of wheel speed, engine speed and slip over 1 s and 20 s; standing time and stops.

        slip = (wheel - ground) / max(wheel, ground)    only where that maximum is above 0.5 m/s
        rms = sqrt(mean d**2)      mad = median |d - median d|      d = x[i + n] - x[i]

    x is one of the three signals and n is 1 or 20 samples. A stop is a sample with a wheel speed
    below 0.05 m/s that follows a sample at or above it.

    Args:
        wheel_mps: |w| R of the driven axle, with the R that makes slip zero without load. Shape
            (samples,), at 1 Hz, as the other two.
        ground_mps: speed over the ground, without a sign.
        engine_rpm: engine speed.
        engine_on: count only samples with an engine speed above 100 rpm.

    Returns:
        `wheel_mps_rms_1s` and the like of each signal [m/s, rpm, 1]; `standing`, share of the
        samples with a wheel speed below 0.05 m/s [1]; `stops_per_h` [1/h].
    """
    wheel_mps, ground_mps = np.asarray(wheel_mps, float), np.asarray(ground_mps, float)
    looked_at = engine_rpm > RUNS_RPM if engine_on else np.ones(len(wheel_mps), bool)
    faster = np.maximum(wheel_mps, ground_mps)
    slip = (wheel_mps - ground_mps) / np.maximum(faster, STANDS_MPS)
    slip = np.where(faster > MOVES_MPS, slip, np.nan)
    found: dict[str, float] = {}
    named = {"wheel_mps": wheel_mps, "engine_rpm": np.asarray(engine_rpm, float), "slip": slip}
    for name, values in named.items():
        values = np.where(looked_at, values, np.nan)
        for step in STEPS_S:
            change = values[step:] - values[:-step]
            change = change[np.isfinite(change)]
            found[f"{name}_rms_{step}s"] = float(np.sqrt(np.mean(change**2)))
            found[f"{name}_mad_{step}s"] = float(np.median(np.abs(change - np.median(change))))
    stands = wheel_mps < STANDS_MPS
    hours = looked_at.sum() / 3600.0
    found["standing"] = float((stands & looked_at).sum() / looked_at.sum())
    found["stops_per_h"] = float(np.sum(stands[1:] & ~stands[:-1] & looked_at[1:]) / hours)
    return found


def ratios(ours: Mapping[str, float], theirs: Mapping[str, float]) -> dict[str, float]:
    """Ratio of each value of `ours` to the same value of `theirs`; 1 if both are zero."""
    return {
        name: 1.0 if ours[name] == theirs[name] else ours[name] / theirs[name]
        for name in theirs
        if theirs[name] or ours[name] == theirs[name]
    }
