"""Drive a controller over many grounds and measure its performance on each ground."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from twin.control import own
from twin.control.baselines import BASELINES
from twin.control.controllers import Controller
from twin.control.fieldwork import FIELD_BASELINES
from twin.control.judged import MEASURES
from twin.control.own import AnyController, ControllerSetup
from twin.control.torques import TORQUE_BASELINES
from twin.control.traction import TRACTION_BASELINES
from twin.env.many import ManyEnv
from twin.env.vector import (
    PloughFieldVectorEnv,
    PloughVectorEnv,
    SlipLineVectorEnv,
    WheelSlipVectorEnv,
)
from twin.errors import check_range

Array = NDArray[np.float64]

TRAINING, HELD_OUT = 10_000, 1_000_000
"""First seed of the grounds that may be tuned and trained on, and of those that compare."""
ENTRY_S = 5.0
"""Time in which the plough enters the soil [s]; measures start after this time."""
ENVIRONMENTS: dict[str, tuple[Callable[..., ManyEnv], Mapping[str, Controller]]] = {
    "Plough-v0": (PloughVectorEnv, BASELINES),
    "WheelSlip-v0": (WheelSlipVectorEnv, TORQUE_BASELINES),
    "Plough-v1": (PloughFieldVectorEnv, FIELD_BASELINES),
    "WheelSlip-v1": (SlipLineVectorEnv, TRACTION_BASELINES),
}
"""Where controllers are compared: the environment and its baselines."""


def setup(environment: str, observation: str) -> ControllerSetup:
    """Set-up of an environment's controllers, by its id and its observation."""
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

    A stalled tractor stands still for the rest of the time: it works nothing, and its errors are
    those of standing in the furrow. The reward is the mean of all control steps; the other figures
    begin after the entry.

    Args:
        env: as many tractors as grounds; its observations are what the controller sees.
        controller: what drives: of many tractors, or of one (`OwnController`).
        seeds: of the grounds.
        duration_s: length of an episode, longer than the entry's 5 s.
        progress: called with the share done.
        name: what messages call the controller; its class by default.

    Returns:
        The environment's `quantities`, each of shape (grounds,).

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
    measures = MEASURES[env.episodes.fleet.machine.scenario.name]
    sums: dict[str, Array] = {quantity: np.zeros((1, env.num_envs)) for quantity in measures}
    total = np.zeros(env.num_envs)
    for step in range(steps):
        state, action = own.acted(driver, state, names, observation, told, name)
        observation, reward, stalled, _, info = env.step(action)
        alive &= ~stalled
        total += np.where(alive, reward, 0.0)
        if step >= entry:
            for quantity, measure in measures.items():
                sums[quantity] = sums[quantity] + measure.sums(env.episodes, info, alive)
        progress((step + 1) / steps)
    found = {name: measure.of(sums[name], steps - entry) for name, measure in measures.items()}
    return {"reward": total / steps, **found, "stalled": np.where(alive, 0.0, 1.0)}
