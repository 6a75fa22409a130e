"""Tune the baselines on training grounds by random search: `python -m twin.control.tune`.

The same budget for each baseline of an environment, by the mean reward: rounds of candidates,
uniform in a box, first of stated ranges, then half as wide around the best so far. Plough-v0: true
slip and depth, so that a second is enough for a tractor's minute. WheelSlip-v0: estimated ones,
since gains that do well on the truth are unstable behind the estimator's lag.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from twin.control.trials import ENVIRONMENTS, TRAINING, drive
from twin.env.many import ManyEnv

Array = NDArray[np.float64]

BUDGETS = {
    "Plough-v0": (3, 12, 6, 12.0, "truth"),
    "WheelSlip-v0": (3, 12, 3, 8.0, "estimate"),
    "Plough-v1": (4, 32, 16, 20.0, "truth"),
    "WheelSlip-v1": (3, 24, 12, 20.0, "truth"),
}
"""Rounds, candidates of each, training grounds, length of an episode [s], what is seen."""
RANGES: dict[str, tuple[float, float]] = {
    "throttle": (-0.4, 1.0),
    "trim_m": (-0.10, 0.02),
    "kp_m": (0.0, 4.0),
    "ki_mps": (0.0, 0.4),
    "rate": (0.0, 20.0),
    "reach_m": (0.02, 0.15),
    "surface_radps": (0.0, 1.0),
    "layer": (0.02, 0.4),
    "mix": (0.0, 1.0),
    "held_n": (1.5e4, 5e4),
    "sensitivity_m": (0.02, 0.3),
    "dither_m": (0.002, 0.02),
    "dither_radps": (0.8, 6.0),
    "seek_mps": (0.0, 2.0),
    "slip_weight": (0.1, 4.0),
    "move_weight": (0.05, 4.0),
    "learn_s": (0.1, 3.0),
    "feed": (0.3, 0.9),
    "kp": (0.0, 2.0),
    "ki_ps": (0.0, 20.0),
    "gear": (-0.3, 1.0),
    "slip_set": (0.04, 0.25),
    "line_pm": (-0.2, 3.0),
    "reach": (0.1, 0.6),
}
"""Ranges of the gains that are searched."""


def tune(
    env: ManyEnv, baseline: Any, candidates: int, duration_s: float, rounds: int, seed: int = 0
) -> tuple[dict[str, float], float]:
    """The best of the candidates for a baseline, and its mean reward.

    Args:
        env: as many tractors as candidates times training grounds.
        baseline: whose gains are searched.
        candidates: how many are tried in a round.
        duration_s: length of an episode.
        rounds: how often, each in a box half as wide around the best so far.
        seed: of the search.
    """
    count = env.num_envs // candidates
    seeds = [TRAINING + i for i in range(count)] * candidates
    generator = np.random.default_rng(seed)
    boxes = {gain: box for gain, box in RANGES.items() if hasattr(baseline, gain)}
    best, most = {gain: float(np.mean(box)) for gain, box in boxes.items()}, -np.inf
    for turn in range(rounds):
        gains = {
            gain: _around(generator, best[gain], box, 0.5**turn, candidates)
            for gain, box in boxes.items()
        }
        spread = {gain: np.repeat(values, count) for gain, values in gains.items()}
        rewards = drive(env, replace(baseline, **spread), seeds, duration_s)["reward"]
        mean: Array = rewards.reshape(candidates, count).mean(axis=1)
        i = int(np.argmax(mean))
        if mean[i] > most:
            best, most = {gain: float(values[i]) for gain, values in gains.items()}, mean[i]
    return best, float(most)


def _around(
    generator: Generator, middle: float, box: tuple[float, float], share: float, count: int
) -> Array:
    """Uniform in a share of a box's width around a place, moved to lie in the box."""
    low, high = box
    half = 0.5 * share * (high - low)
    start = min(max(middle, low + half), high - half)
    return generator.uniform(start - half, start + half, count)


def main() -> int:
    """Tune each baseline and print what was found."""
    for chosen in sys.argv[1:] or ENVIRONMENTS:
        kind, baselines = ENVIRONMENTS[chosen]
        rounds, candidates, count, duration_s, observation = BUDGETS[chosen]
        env = kind(candidates * count, observation=observation)
        for name, baseline in baselines.items():
            gains, reward = tune(env, baseline, candidates, duration_s, rounds)
            found = ", ".join(f"{gain}={value:.3g}" for gain, value in gains.items())
            print(f"{chosen} {name}: {found}: mean reward {reward:.4f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
