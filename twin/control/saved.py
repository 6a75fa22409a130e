"""Policies saved by stable-baselines3 as controllers. A policy's file can run any code."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import Controller, Seen
from twin.control.own import ControllerSetup
from twin.control.policy import TASKS, Policy
from twin.errors import BadInput
from twin.plugins.extras import needed

Array = NDArray[np.float64]

SUFFIX = ".zip"
ALGORITHMS = ("PPO", "SAC", "TD3", "A2C", "DDPG")
CONTRIBUTED = ("RecurrentPPO", "TQC", "TRPO", "CrossQ")
"""Those of sb3-contrib, where it is installed."""


class Recalled(NamedTuple):
    """What a policy with a memory of its own keeps between control steps."""

    hidden: Any
    first: NDArray[np.bool_]
    """Whether this is an episode's first step (count,)."""


@dataclass(frozen=True)
class PlainPolicy:
    """A model that sees the environment's own observation and gives its actions."""

    model: Any
    """Of stable-baselines3, with `predict`."""

    def init(self, count: int) -> Recalled:
        """Nothing seen yet."""
        return Recalled(None, np.ones(count, dtype=np.bool_))

    def act(self, state: Recalled, seen: Seen, period_s: float) -> tuple[Recalled, Array]:
        """One decision in each control step, without exploration."""
        observation = np.stack(list(seen.values()), axis=-1).astype(np.float32)
        actions, hidden = self.model.predict(
            observation, state=state.hidden, episode_start=state.first, deterministic=True
        )
        return Recalled(hidden, np.zeros_like(state.first)), np.asarray(actions, dtype=np.float64)


def load(file: Path, setup: ControllerSetup) -> Controller:
    """The policy in a file: one of the environment's own observation, or one that adds to a PI.

    Args:
        file: saved by `model.save` of stable-baselines3. Loading it can run any code in it.
        setup: of where it drives.

    Raises:
        BadInput: stable-baselines3 is not installed, the file is no policy, or it sees or does
            something else.
    """
    if not file.is_file():
        raise BadInput(f"controller {file}: there is no such file")
    model = _model(file)
    seen, acts = model.observation_space.shape, model.action_space
    count, task = len(setup.observed), TASKS.get(setup.environment)
    if acts.shape != (len(setup.actions),) or not _unit(acts):
        raise BadInput(
            f"controller {file} acts in {acts}, not in {len(setup.actions)} numbers in [-1, 1] as "
            f"{setup.environment} does"
        )
    if seen == (count,):
        return PlainPolicy(model)
    if task is not None and seen == (task.size,):
        return Policy(model, task)
    raise BadInput(
        f"controller {file} sees an observation of shape {seen}, and this one of "
        f"{setup.environment} has {count} entries; train it on this environment and observation"
    )


def _unit(space: Any) -> bool:
    """Whether a box is [-1, 1]."""
    if not hasattr(space, "low"):
        return False
    return bool(np.all(space.low == -1.0) and np.all(space.high == 1.0))


def _model(file: Path) -> Any:
    """The model in a file, whatever the algorithm that saved it."""
    if not zipfile.is_zipfile(file):
        raise BadInput(f"controller {file} is no zip file, as stable-baselines3 saves a policy")
    algorithms = _algorithms(file)
    for algorithm in algorithms.values():
        try:
            return algorithm.load(file, device="cpu")
        except Exception:  # a file of another algorithm fails in a way of its own
            continue
    raise BadInput(f"controller {file} holds no policy of {', '.join(algorithms)}")


def _algorithms(file: Path) -> Mapping[str, Any]:
    """Algorithms of stable-baselines3 by name, in the order in which they are tried."""
    plain = needed("stable_baselines3", "rl", f"saved policies ({file})", "stable-baselines3")
    found = {name: getattr(plain, name) for name in ALGORITHMS}
    try:
        more = import_module("sb3_contrib")
    except ImportError:
        return found
    return found | {name: getattr(more, name) for name in CONTRIBUTED}
