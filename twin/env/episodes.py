"""What a single environment and a vector of them share: tractors, observations, rewards, stalls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from twin.env import observations
from twin.env.control_step import bounded, pack
from twin.env.fleet import Fleet, Start
from twin.env.grounds import Ground, GroundShape, Recipe
from twin.env.instruments import Instruments
from twin.env.observations import Entry
from twin.env.quantities import TRUE, Ids
from twin.env.starts import Starts
from twin.errors import BadInput, UnknownName, check_range
from twin.pipeline import named as registry
from twin.pipeline.estimating import Estimator

Array = NDArray[np.float64]
STALL_S = 1.0
"""Standing for this long is a stall."""
REWARD = "reward"


def asked(observation: str, estimator: str, slip_target: float = 0.1) -> Estimator | None:
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

    A subclass gives machine, observations, reward and infos.
    """

    actions_named: tuple[str, ...]
    recipe: Recipe
    terms: tuple[str, ...]
    """The terms of the reward."""
    derived: tuple[str, ...] = ()
    """What else is known, beside what is true."""
    known: tuple[str, ...]
    """Names of the infos: true and derived values."""
    task: tuple[str, ...]
    """What every observation ends with."""

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
        self.fleet, self.shapes, self.every = fleet, shapes, np.arange(nsim)
        nthread = fleet.batch.nthread
        self.starts = Starts(machine, shapes, seen=seen, nthread=nthread, kind=type(fleet))
        self.instruments: list[Instruments] = []
        if seen:
            self.instruments = [Instruments(machine, estimator) for _ in range(nsim)]
        self.rewarded = tuple(f"{REWARD}_{name}" for name in self.terms)
        named = (*TRUE, *self.derived, *self.rewarded, REWARD, *self.task)
        self.place = {name: row for row, name in enumerate(named)}
        self.entries = entries
        seen_names = [entry.name for entry in entries if entry.name not in self.task]
        if seen:
            self.seen = {name: len(named) + row for row, name in enumerate(seen_names)}
        else:
            self.seen = {name: self.place[name] for name in seen_names}
        self.values = np.zeros((len(named) + (len(seen_names) if seen else 0), nsim))
        """All that is known of the tractors, a row each (rows, nsim)."""
        of_entry = self.place | self.seen
        self.packed = np.array([of_entry[entry.name] for entry in entries])
        self.observation_space = observations.space(entries)
        self.action_space = Box(-1.0, 1.0, (len(self.actions_named),), np.float32)
        self.actions = np.zeros((nsim, len(self.actions_named)))
        self.begun: dict[int, tuple[Start, Ground]] = {}

    def judge(self, ids: Ids) -> None:
        """Write what is derived, the reward with its terms, and the task, of some tractors."""
        raise NotImplementedError

    def begin(self, ids: Sequence[int], grounds: Sequence[Ground]) -> None:
        """Start new episodes of the tractors `ids`, each on its own ground."""
        starts = self.starts.of([ground.shape for ground in grounds])
        self.fleet.restore(ids, starts, grounds)
        self.begun |= zip(ids, zip(starts, grounds, strict=True), strict=True)
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
                instruments.advance({k: v[i : i + 1] for k, v in records.items()})
        stalled: NDArray[np.bool_] = self.fleet.standing_s >= STALL_S
        return stalled

    def look(self, ids: Ids | None = None) -> NDArray[np.float32]:
        """Bring what is known up to date; what the controller of each sees (nsim, entries).

        Args:
            ids: of which tractors; None for all.
        """
        ids = self.every if ids is None else ids
        self.fleet.look(ids, self.values)
        self.judge(ids)
        if self.instruments:
            for i in ids.tolist():
                values = self.instruments[i].values()
                for name, row in self.seen.items():
                    self.values[row, i] = values[name]
        out = np.empty((len(ids), len(self.packed)), dtype=np.float32)
        box = self.observation_space
        pack(self.values, self.packed, box.low, box.high, ids, out)
        return out

    def values_of(self, names: Sequence[str]) -> dict[str, Array]:
        """Current values by name of quantity, each of shape (nsim,), one value per tractor."""
        return {name: self.values[self.place[name]] for name in names}


def checked(action: Any, batch: tuple[int, ...], names: Sequence[str]) -> Array:
    """Actions of these names as numbers within [-1, 1], (nsim, 2).

    Raises:
        BadInput: one that cannot be meant.
    """
    shape = (*batch, len(names))
    try:
        taken = np.array(action, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput(f"action {action!r} is not {wanted(names)}") from None
    if taken.shape != shape:
        raise BadInput(f"action has shape {taken.shape}, not {shape}; give {wanted(names)}")
    flat = taken.reshape(-1, len(names))
    if not bounded(flat):
        raise BadInput(_not_finite(np.array(action, dtype=np.float64), names))
    return flat


def wanted(names: Sequence[str]) -> str:
    """What an action has to be."""
    return f"{len(names)} numbers in [-1, 1]: {', '.join(names)}"


def _not_finite(taken: Array, names: Sequence[str]) -> str:
    """Which of the actions is not finite."""
    place = tuple(np.argwhere(~np.isfinite(taken))[0].tolist())
    where, name = ", ".join(map(str, place)), names[place[-1]]
    return f"action[{where}] ({name}) = {taken[place]} is not finite; give {wanted(names)}"
