"""Tune the baselines on training grounds by random search: `python -m twin.control.tune`.

The same budget for each: 32 candidates, uniform in stated ranges, on 8 training grounds of 15 s,
by the mean reward; slip and depth as they are, so that a second is enough for a tractor's minute.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import BASELINES
from twin.control.trials import TRAINING, drive
from twin.env.vector import PloughVectorEnv

CANDIDATES, GROUNDS, DURATION_S = 32, 8, 15.0
RANGES: dict[str, tuple[float, float]] = {
    "throttle": (-0.4, 0.8),
    "trim_m": (-0.10, 0.0),
    "kp_m": (0.0, 0.8),
    "ki_mps": (0.0, 0.4),
    "rate": (0.0, 10.0),
    "reach_m": (0.02, 0.15),
    "surface_radps": (0.0, 1.0),
    "layer": (0.02, 0.3),
}
"""Ranges of the gains that are searched."""


def tune(env: PloughVectorEnv, name: str, seed: int = 0) -> tuple[dict[str, float], float]:
    """The best of the candidates for a baseline, and its mean reward.

    Args:
        env: CANDIDATES times GROUNDS tractors.
        name: of the baseline.
        seed: of the search.
    """
    baseline: Any = BASELINES[name]
    generator = np.random.default_rng(seed)
    gains = {
        gain: generator.uniform(low, high, CANDIDATES)
        for gain, (low, high) in RANGES.items()
        if hasattr(baseline, gain)
    }
    spread = {gain: np.repeat(values, GROUNDS) for gain, values in gains.items()}
    seeds = [TRAINING + i for i in range(GROUNDS)] * CANDIDATES
    rewards = drive(env, replace(baseline, **spread), seeds, DURATION_S)["reward"]
    mean: NDArray[np.float64] = rewards.reshape(CANDIDATES, GROUNDS).mean(axis=1)
    best = int(np.argmax(mean))
    return {gain: float(values[best]) for gain, values in gains.items()}, float(mean[best])


def main() -> int:
    """Tune each baseline and print what was found."""
    env = PloughVectorEnv(CANDIDATES * GROUNDS, observation="truth")
    for name in BASELINES:
        gains, reward = tune(env, name)
        found = ", ".join(f"{gain}={value:.3g}" for gain, value in gains.items())
        print(f"{name}: {found}: mean reward {reward:.4f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
