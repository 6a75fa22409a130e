"""The state of an environment in the midst of an episode: kept, and put back to the bit."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from twin.env.episodes import Episodes
from twin.env.grounds import Ground
from twin.env.infos import Infos
from twin.env.instruments import Instruments
from twin.errors import BadInput

LOOKED_WITH = ("state", "memory", "latest", "counted", "gnss_ns")
RECORDED_WITH = ("normal", "steps")


@dataclass(frozen=True)
class EnvState:
    """All that changes in an environment. Made by `get_state`; nothing in it is for reading."""

    fleet: Mapping[str, NDArray[Any]]
    """Every array of the tractors, by name."""
    grounds: Mapping[int, Ground]
    instruments: tuple[Mapping[str, object], ...]
    episodes: Mapping[str, NDArray[Any]]
    own: Mapping[str, object]
    """What the environment itself keeps: generators, counts, what was seen last."""


class KeepsState(EzPickle):
    """An environment that can be saved, branched, pickled and copied within an episode."""

    episodes: Episodes
    kept: tuple[str, ...]
    """Names of what changes in it beside its episodes."""

    def get_state(self) -> EnvState:
        """All that changes, copied; `set_state` goes on from it to the bit. It can be pickled."""
        return _state_of(self, self.kept)

    def set_state(self, state: EnvState) -> None:
        """Go back to a state. Raises BadInput for one of other arguments."""
        _put_back(self, state)

    def __getstate__(self) -> Infos:
        """The arguments and the state, so that a copy goes on within the episode."""
        return {**super().__getstate__(), "state": self.get_state()}

    def __setstate__(self, made_of: Infos) -> None:
        """Made anew, and put into the state."""
        super().__setstate__(made_of)
        self.set_state(made_of["state"])


def _state_of(env: KeepsState, kept: tuple[str, ...]) -> EnvState:
    """The state of an environment, copied.

    Args:
        env: with `episodes`.
        kept: names of its own attributes that change.
    """
    episodes: Episodes = env.episodes
    return EnvState(
        fleet={name: a.copy() for name, a in _arrays(episodes.fleet).items()},
        grounds={i: ground for i, (_, ground) in episodes.begun.items()},
        instruments=tuple(_looked(each) for each in episodes.instruments),
        episodes={name: a.copy() for name, a in _arrays(episodes).items()},
        own={name: deepcopy(getattr(env, name)) for name in kept},
    )


def _put_back(env: KeepsState, state: EnvState) -> None:
    """Put an environment of the same arguments into a state.

    Raises:
        BadInput: the state is another environment's.
    """
    episodes: Episodes = env.episodes
    arrays = _arrays(episodes.fleet)
    shapes = {name: array.shape for name, array in arrays.items()}
    if not isinstance(state, EnvState) or shapes != {n: a.shape for n, a in state.fleet.items()}:
        raise BadInput("the state is not of such an environment; its arguments must be the same")
    known = _arrays(episodes)
    if len(state.instruments) != len(episodes.instruments) or any(
        name not in known or values.shape != known[name].shape
        for name, values in state.episodes.items()
    ):
        raise BadInput("the state is of an environment with another observation")
    starts = episodes.starts.of([ground.shape for ground in state.grounds.values()])
    episodes.begun = dict(
        zip(state.grounds, zip(starts, state.grounds.values(), strict=True), strict=True)
    )
    for name, array in arrays.items():
        array[...] = state.fleet[name]
    for name, values in state.episodes.items():
        known[name][...] = values
    for instruments, looked in zip(episodes.instruments, state.instruments, strict=True):
        _look_again(instruments, looked)
    for name, value in state.own.items():
        setattr(env, name, deepcopy(value))


def _arrays(thing: object) -> dict[str, NDArray[Any]]:
    """The arrays that can change; those of a fleet's batch are among them."""
    return {
        name: value
        for name, value in vars(thing).items()
        if isinstance(value, np.ndarray) and value.flags.writeable
    }


def _looked(instruments: Instruments) -> Mapping[str, object]:
    if not hasattr(instruments, "recorder"):  # never switched on
        return {}
    recorder = instruments.recorder
    own = {name: deepcopy(getattr(instruments, name)) for name in LOOKED_WITH}
    return own | {name: deepcopy(getattr(recorder, name)) for name in RECORDED_WITH}


def _look_again(instruments: Instruments, looked: Mapping[str, object]) -> None:
    if not looked:
        return
    instruments.switch_on(0)
    for name in LOOKED_WITH:
        setattr(instruments, name, deepcopy(looked[name]))
    for name in RECORDED_WITH:
        setattr(instruments.recorder, name, deepcopy(looked[name]))
