"""Drive a controller over grounds, and what came of it on each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.control import own
from twin.control.baselines import BASELINES
from twin.control.own import AnyController, ControllerSetup
from twin.control.torques import TORQUE_BASELINES
from twin.env.many import ManyEnv
from twin.env.ploughing import Ploughing
from twin.env.vector import PloughVectorEnv, WheelSlipVectorEnv
from twin.errors import check_range

Array = NDArray[np.float64]

TRAINING, HELD_OUT = 10_000, 1_000_000
"""First seed of the grounds that may be tuned and trained on, and of those that compare."""
ENTRY_S = 5.0
"""Time in which the plough enters; judged is what follows [s]."""
QUANTITIES = {
    "reward": "1", "traction_efficiency": "1", "work_rate": "ha/h", "fuel": "L/ha",
    "slip_rms_error": "1", "depth_rms_error": "m", "stalled": "1",
}  # fmt: skip
"""What is measured on each ground of Plough-v0, with its unit."""
PULL_QUANTITIES = {
    "reward": "1", "traction_efficiency": "1", "speed": "m/s", "slip_rms_error": "1",
    "sideslip_rms": "m/s", "stalled": "1",
}  # fmt: skip
"""The same of WheelSlip-v0; the slip error is that of both rear wheels."""
ENVIRONMENTS: dict[str, tuple[type[PloughVectorEnv | WheelSlipVectorEnv], Any]] = {
    "Plough-v0": (PloughVectorEnv, BASELINES),
    "WheelSlip-v0": (WheelSlipVectorEnv, TORQUE_BASELINES),
}
"""Where controllers are compared: the environment and its baselines."""


def setup(environment: str, observation: str) -> ControllerSetup:
    """What controllers of an environment are told, by its id and what they observe."""
    with closing(ENVIRONMENTS[environment][0](1, observation=observation)) as env:
        return own.setup_of(env.episodes)


def drive(
    env: ManyEnv,
    controller: AnyController,
    seeds: Sequence[int],
    duration_s: float,
    progress: Callable[[float], None] = lambda share: None,
    name: str | None = None,
) -> dict[str, Array]:
    """One episode of a controller on each ground.

    A stalled tractor stands for the rest of the time: it works nothing, and its errors are those
    of standing in the furrow. Reward is the mean of all control steps, the rest after the entry.

    Args:
        env: as many tractors as grounds; its observations are what the controller sees.
        controller: what drives: of many tractors, or of one (`OwnController`).
        seeds: of the grounds.
        duration_s: length of an episode, longer than the entry's 5 s.
        progress: called with the share done.
        name: what messages call the controller; its class by default.

    Returns:
        The `QUANTITIES`, or the `PULL_QUANTITIES`, each of shape (grounds,).

    Raises:
        BadInput: the controller fails, or gives what is not a state and finite actions.
        OutOfRange: an episode that ends before the plough is in.
    """
    check_range("duration_s", duration_s, ENTRY_S + env.episodes.fleet.period_s, 3600.0)
    told, name = own.setup_of(env.episodes), name or type(controller).__name__
    driver = own.of_many(controller, told, name)
    period_s = env.episodes.fleet.period_s
    steps, entry = round(duration_s / period_s), round(ENTRY_S / period_s)
    observation, _ = env.reset(seed=list(seeds))
    state, alive = own.started(driver, env.num_envs, name), np.ones(env.num_envs, dtype=np.bool_)
    names = [entry_.name for entry_ in env.entries]
    sums = {name: np.zeros(env.num_envs) for name in ("reward", *_judged(env, {}))}
    for step in range(steps):
        state, action = own.acted(driver, state, names, observation, told, name)
        observation, reward, stalled, _, info = env.step(action)
        alive &= ~stalled
        sums["reward"] += np.where(alive, reward, 0.0)
        if step >= entry:
            for name, value in _judged(env, info).items():
                sums[name] += np.where(alive, value, 1.0 if name == "slip_sq" else 0.0)
        progress((step + 1) / steps)
    rest = {"reward": sums["reward"] / steps, "stalled": np.where(alive, 0.0, 1.0)}
    found = (_ploughed if "work" in sums else _pulled)(sums, steps - entry)
    return found | rest


def _judged(env: ManyEnv, info: Mapping[str, Any]) -> dict[str, Array]:
    """What is summed over the control steps after the entry."""
    none = np.zeros(env.num_envs)
    if not isinstance(env.episodes, Ploughing):
        target = env.episodes.slip_target
        left, right = (info.get(f"slip_{wheel}", none) - target for wheel in ("rl", "rr"))
        return {
            "efficiency": info.get("traction_efficiency", none),
            "speed": info.get("speed_mps", none),
            "slip_sq": 0.5 * (left * left + right * right),
            "sideslip_sq": info.get("v_y_rear_mps", none) ** 2,
        }
    value = {
        name: info.get(name, none)
        for name in ("traction_efficiency", "work_rate_haph", "fuel_lph", "slip", "depth_m")
    }
    return {
        "efficiency": value["traction_efficiency"],
        "work": value["work_rate_haph"],
        "fuel": value["fuel_lph"],
        "slip_sq": (value["slip"] - env.episodes.slip_target) ** 2,
        "depth_sq": (value["depth_m"] - env.episodes.depth_m) ** 2,
    }


def _pulled(sums: Mapping[str, Array], judged: int) -> dict[str, Array]:
    return {
        "traction_efficiency": sums["efficiency"] / judged,
        "speed": sums["speed"] / judged,
        "slip_rms_error": np.sqrt(sums["slip_sq"] / judged),
        "sideslip_rms": np.sqrt(sums["sideslip_sq"] / judged),
    }


def _ploughed(sums: Mapping[str, Array], judged: int) -> dict[str, Array]:
    return {
        "traction_efficiency": sums["efficiency"] / judged,
        "work_rate": sums["work"] / judged,
        "fuel": sums["fuel"] / np.maximum(sums["work"], 1e-3 * judged),
        "slip_rms_error": np.sqrt(sums["slip_sq"] / judged),
        "depth_rms_error": np.sqrt(sums["depth_sq"] / judged),
    }
