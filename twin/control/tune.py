"""Tune the baselines on training grounds by random search: `python -m twin.control.tune`.

The same budget for each baseline of an environment, its candidates uniform in stated ranges, by the
mean reward. Plough-v0: slip and depth as they are, so that a second is enough for a tractor's
minute. WheelSlip-v0: as estimated, since gains that do well on the truth are unstable behind the
estimator's lag.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.control.trials import ENVIRONMENTS, TRAINING, drive
from twin.env.vector import ManyEnv

BUDGETS = {"Plough-v0": (32, 8, 15.0, "truth"), "WheelSlip-v0": (12, 2, 8.0, "estimate")}
"""Candidates, training grounds, length of an episode [s], and what the controllers see."""
RANGES: dict[str, tuple[float, float]] = {
    "throttle": (-0.4, 0.8),
    "trim_m": (-0.10, 0.0),
    "kp_m": (0.0, 0.8),
    "ki_mps": (0.0, 0.4),
    "rate": (0.0, 10.0),
    "reach_m": (0.02, 0.15),
    "surface_radps": (0.0, 1.0),
    "layer": (0.02, 0.3),
    "feed": (0.3, 0.9),
    "kp": (0.0, 2.0),
    "ki_ps": (0.0, 10.0),
    "reach": (0.1, 0.6),
}
"""Ranges of the gains that are searched."""


def tune(
    env: ManyEnv, baseline: Any, candidates: int, duration_s: float, seed: int = 0
) -> tuple[dict[str, float], float]:
    """The best of the candidates for a baseline, and its mean reward.

    Args:
        env: as many tractors as candidates times training grounds.
        baseline: whose gains are searched.
        candidates: how many are tried.
        duration_s: length of an episode.
        seed: of the search.
    """
    count = env.num_envs // candidates
    generator = np.random.default_rng(seed)
    gains = {
        gain: generator.uniform(low, high, candidates)
        for gain, (low, high) in RANGES.items()
        if hasattr(baseline, gain)
    }
    spread = {gain: np.repeat(values, count) for gain, values in gains.items()}
    seeds = [TRAINING + i for i in range(count)] * candidates
    rewards = drive(env, replace(baseline, **spread), seeds, duration_s)["reward"]
    mean: NDArray[np.float64] = rewards.reshape(candidates, count).mean(axis=1)
    best = int(np.argmax(mean))
    return {gain: float(values[best]) for gain, values in gains.items()}, float(mean[best])


def main() -> int:
    """Tune each baseline and print what was found."""
    for chosen in sys.argv[1:] or ENVIRONMENTS:
        kind, baselines = ENVIRONMENTS[chosen]
        candidates, count, duration_s, observation = BUDGETS[chosen]
        env = kind(candidates * count, observation=observation)
        for name, baseline in baselines.items():
            gains, reward = tune(env, baseline, candidates, duration_s)
            found = ", ".join(f"{gain}={value:.3g}" for gain, value in gains.items())
            print(f"{chosen} {name}: {found}: mean reward {reward:.4f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
