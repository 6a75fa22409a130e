"""What a single environment and a vector of them share: tractors, observations, rewards, stalls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from twin.env import observations
from twin.env.fleet import Fleet, Start
from twin.env.grounds import Ground, GroundShape, Recipe
from twin.env.instruments import Instruments
from twin.env.observations import Entry
from twin.env.quantities import Ids
from twin.env.starts import Starts
from twin.errors import BadInput, UnknownName, check_range
from twin.pipeline import named as registry
from twin.pipeline.estimating import Estimator

Array = NDArray[np.float64]
Some: TypeAlias = Ids | slice
"""Which tractors."""
EVERY = slice(None)

STALL_MPS, STALL_S = 0.05, 1.0
"""Slower than this for this long is a stall."""


def asked(observation: str, estimator: str, slip_target: float) -> Estimator | None:
    """The estimator that an environment's arguments name, if they need one.

    Raises:
        UnknownName, OutOfRange: an argument that cannot be.
    """
    if observation not in observations.MODES:
        raise UnknownName("observation", observation, observations.MODES)
    check_range("slip_target", slip_target, 0.02, 0.4)
    return registry.load("estimator", estimator) if observation == "estimate" else None


class Episodes:
    """Tractors, each in an episode of its own; nothing here knows of time limits.

    What is asked of them stands in a subclass: machine, observations, reward, what is known.
    """

    actions_named: tuple[str, str]
    recipe: Recipe
    slip_target: float

    def __init__(
        self,
        fleet: Fleet,
        shapes: Sequence[GroundShape],
        entries: tuple[Entry, ...],
        estimator: Estimator | None,
        *,
        seen: bool,
    ) -> None:
        nsim, machine = len(fleet.state), fleet.machine
        self.fleet, self.shapes = fleet, shapes
        nthread = fleet.batch.nthread
        self.starts = Starts(machine, shapes, seen=seen, nthread=nthread, kind=type(fleet))
        self.instruments: list[Instruments] = []
        if seen:
            self.instruments = [Instruments(machine, estimator) for _ in range(nsim)]
        self.entries = entries
        self.observation_space = observations.space(entries)
        self.action_space = Box(-1.0, 1.0, (len(self.actions_named),), np.float32)
        self.actions = np.zeros((nsim, len(self.actions_named)))
        self.standing_s = np.zeros(nsim)
        self.begun: dict[int, tuple[Start, Ground]] = {}

    def terms(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """The terms of the reward by name, each of shape (nsim,)."""
        raise NotImplementedError

    def task(self, ids: Some) -> dict[str, ArrayLike]:
        """What every observation ends with, of some tractors."""
        raise NotImplementedError

    def info(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """What is true now and worth knowing of each tractor, each of shape (nsim,)."""
        raise NotImplementedError

    def begin(self, ids: Sequence[int], grounds: Sequence[Ground]) -> None:
        """Begin the episodes of some tractors."""
        starts = self.starts.of([ground.shape for ground in grounds])
        self.fleet.restore(ids, starts, grounds)
        self.begun |= zip(ids, zip(starts, grounds, strict=True), strict=True)
        self.standing_s[ids] = 0.0
        self.actions[ids] = [start.action for start in starts]
        if self.instruments:
            for i, start, ground in zip(ids, starts, grounds, strict=True):
                if start.approach is not None:
                    self.instruments[i].begin(ground.noise_seed, start.approach)

    def advance(self, actions: Array) -> NDArray[np.bool_]:
        """Drive all for one control step, actions (nsim, 2) in [-1, 1]; which have stalled."""
        self.actions = actions
        records = self.fleet.drive(actions, record=bool(self.instruments))
        for i, instruments in enumerate(self.instruments):
            if records is not None:
                instruments.advance([{k: v[i : i + 1] for k, v in records.items()}])
        slow = self.fleet.speed_mps() < STALL_MPS
        self.standing_s = np.where(slow, self.standing_s + self.fleet.period_s, 0.0)
        stalled: NDArray[np.bool_] = self.standing_s >= STALL_S
        return stalled

    def rewards(self, true: Mapping[str, Array]) -> tuple[Array, dict[str, Array]]:
        """Rewards of the control step (nsim,), and their terms as `reward_<term>`."""
        terms, total = self.terms(true), np.zeros(len(self.actions))
        for value in terms.values():
            total = total + value
        return total, {f"reward_{name}": value for name, value in terms.items()}

    def observe(self, true: Mapping[str, Array], ids: Some = EVERY) -> NDArray[np.float32]:
        """What the controller of each tractor, or of some, sees now, (nsim, entries)."""
        values: Mapping[str, ArrayLike] = true
        if self.instruments:
            chosen = np.arange(len(self.instruments))[ids]
            each = [self.instruments[i].values() for i in chosen]
            values = {name: np.array([one[name] for one in each]) for name in each[0]}
        count = len(self.actions[ids])
        seen = {**values, **self.task(ids)}
        return observations.pack(seen, self.entries, self.observation_space, count)


def checked(action: Any, batch: tuple[int, ...], names: Sequence[str]) -> Array:
    """Actions of these names as numbers within [-1, 1], (*batch, 2).

    Raises:
        BadInput: one that cannot be meant.
    """
    shape = (*batch, len(names))
    wanted = f"{len(names)} numbers in [-1, 1]: {', '.join(names)}"
    try:
        taken = np.asarray(action, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput(f"action {action!r} is not {wanted}") from None
    if taken.shape != shape:
        raise BadInput(f"action has shape {taken.shape}, not {shape}; give {wanted}")
    if not np.isfinite(taken).all():
        place = tuple(np.argwhere(~np.isfinite(taken))[0].tolist())
        where, name = ", ".join(map(str, place)), names[place[-1]]
        raise BadInput(f"action[{where}] ({name}) = {taken[place]} is not finite; give {wanted}")
    return np.minimum(np.maximum(taken, -1.0), 1.0)
