"""Statistics in which drives differ: how speeds change, how often the machine stops.

Both a log and a simulated day are taken at one sample a second, as a logger of a machine's bus
writes them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from twin.streams import Array

STANDS_MPS = 0.05
"""Slower than this a machine stands."""
MOVES_MPS = 0.5
"""Slip is looked at where wheels or ground move faster than this."""
RUNS_RPM = 100.0
"""Faster than this an engine runs."""
STEPS_S = (1, 20)


def drive_statistics(
    wheel_mps: Array, ground_mps: Array, engine_rpm: Array, *, engine_on: bool = False
) -> dict[str, float]:
    """Changes of wheel speed, engine speed and slip over 1 s and 20 s; standing, stops.

        rms = sqrt(mean d**2)      mad = median |d - median d|      d = x(t + n) - x(t)

    A stop is a second below 0.05 m/s after one above.

    Args:
        wheel_mps: w R of the driven axle without a sign, R so that slip is zero without load.
        ground_mps: speed over the ground without a sign.
        engine_rpm: engine speed. All of them at 1 Hz, shape (n,).
        engine_on: look only at the time when the engine runs.
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
    stands = (wheel_mps < STANDS_MPS) & looked_at
    hours = looked_at.sum() / 3600.0
    found["standing"] = float(stands.sum() / looked_at.sum())
    found["stops_per_h"] = float(np.sum(np.diff(stands.astype(int)) == 1) / hours)
    return found


def ratios(ours: Mapping[str, float], theirs: Mapping[str, float]) -> dict[str, float]:
    """Each of ours over theirs; 1 where both are nothing."""
    return {
        name: 1.0 if ours[name] == theirs[name] else ours[name] / theirs[name]
        for name in theirs
        if theirs[name] or ours[name] == theirs[name]
    }
