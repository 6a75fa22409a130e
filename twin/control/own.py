"""Controllers that users write for one tractor, driven over many; what they give is checked.

init(setup) -> state          act(state, observation) -> (state, action)
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from twin import sensors
from twin.control.controllers import Controller, Seen, State
from twin.env.episodes import Episodes, wanted
from twin.env.observations import Entry
from twin.errors import BadInput
from twin.machine.geometry import geometry
from twin.plugins.failing import failing
from twin.plugins.lookup import Thing
from twin.streams import Setup, read_only

Array = NDArray[np.float64]

MUST_HAVE = (
    "it needs init(setup) -> state and act(state, observation) -> (state, action), or for many "
    "tractors at once init(count) and act(state, seen, period_s)"
)


@dataclass(frozen=True, kw_only=True)
class ControllerSetup:
    """What a controller of one tractor gets before it starts."""

    environment: str
    """Id of the environment that the controller drives in, for example `Plough-v0`."""
    period_s: float
    """Time between two calls of `act` [s]."""
    observed: tuple[Entry, ...]
    """Entries of the observation, in order: each with `name`, `low` and `high`."""
    actions: tuple[str, ...]
    """Names of the actions, in order; each lies in [-1, 1]."""
    streams: Setup
    """Set-up of the estimators: nominal wheel radii, wheelbase, rates and noise of the sensors."""


class OwnController(Protocol):
    """A controller of one tractor: `observation` maps the name of each entry to its value."""

    def init(self, setup: ControllerSetup) -> State:
        """State before the first observation."""

    def act(self, state: State, observation: Mapping[str, float]) -> tuple[State, Sequence[float]]:
        """New state, and a number in [-1, 1] for each action."""


AnyController: TypeAlias = Controller | OwnController
"""A controller of many tractors at once, or a controller of one tractor."""


def setup_of(episodes: Episodes) -> ControllerSetup:
    """Set-up of an environment's controllers."""
    machine = episodes.fleet.machine
    return ControllerSetup(
        environment=machine.scenario.name,
        period_s=episodes.fleet.period_s,
        observed=episodes.entries,
        actions=episodes.actions_named,
        streams=sensors.setup(machine.scenario.sensors, geometry(machine)),
    )


@dataclass(frozen=True)
class OneByOne:
    """Drives many tractors with a one-tractor controller: one separate state per tractor."""

    controller: OwnController
    setup: ControllerSetup
    name: str

    def init(self, count: int) -> list[State]:
        """Initial states, one per tractor."""
        return [self.controller.init(self.setup) for _ in range(count)]

    def act(self, state: list[State], seen: Seen, period_s: float) -> tuple[list[State], Array]:
        """One control step of each tractor. Raises BadInput unless `act` gives (state, action)."""
        states, actions = list[State](), []
        for own, *values in zip(state, *(column.tolist() for column in seen.values()), strict=True):
            given = self.controller.act(own, dict(zip(seen, values, strict=True)))
            new, action = pair(given, self.name)
            states.append(new)
            actions.append(numbers(action, (), self.setup.actions, self.name))
        return states, np.stack(actions)


def of_many(controller: AnyController, setup: ControllerSetup, name: str) -> Controller:
    """A controller of many tractors: itself, or one of one tractor driven one by one.

    Raises:
        BadInput: it lacks a method, or `act` takes another number of arguments.
    """
    given: Thing = controller
    return OneByOne(given, setup, name) if drives_one(given, name) else given


def drives_one(controller: Thing, name: str) -> bool:
    """Whether a controller drives one tractor, by the arguments of its `act`.

    Raises:
        BadInput: it lacks a method, or `act` takes another number of arguments.
    """
    lacking = [n for n in ("init", "act") if not callable(getattr(controller, n, None))]
    if lacking:
        raise BadInput(f"controller '{name}' has no {' and no '.join(lacking)}; {MUST_HAVE}")
    try:
        signature = inspect.signature(controller.act)
    except (TypeError, ValueError):  # compiled: it does not say
        return True
    for count in (2, 3):
        try:
            signature.bind(*range(count))
        except TypeError:
            continue
        return count == 2
    raise BadInput(f"controller '{name}': act{signature} takes other arguments; {MUST_HAVE}")


def started(controller: Controller, count: int, name: str) -> State:
    """A controller's state before the first observation. Raises BadInput if it fails."""
    with failing(f"controller '{name}'", _written(controller)):
        return controller.init(count)


def acted(
    controller: Controller,
    state: State,
    names: Sequence[str],
    observation: NDArray[np.float32],
    setup: ControllerSetup,
    name: str,
) -> tuple[State, NDArray[np.float32]]:
    """One control step of many tractors, checked.

    Args:
        controller: what drives.
        state: its own.
        names: of the observation's entries.
        observation: what is seen (count, entries).
        setup: given to its `init`.
        name: what messages call it.

    Returns:
        The new state, and the actions (count, 2).

    Raises:
        BadInput: it fails, or gives what is not a state and finite actions.
    """
    columns = read_only(observation.T.astype(np.float64))
    with failing(f"controller '{name}'", _written(controller)):
        given = controller.act(state, dict(zip(names, columns, strict=True)), setup.period_s)
    new, actions = pair(given, name)
    return new, numbers(actions, observation.shape[:1], setup.actions, name).astype(np.float32)


def pair(given: object, name: str) -> tuple[State, object]:
    """A state and an action. Raises BadInput for what is not two things."""
    if not (isinstance(given, tuple) and len(given) == 2):
        raise BadInput(f"controller '{name}': act gives {given!r:.60}, not (state, action)")
    return given


def numbers(action: object, batch: tuple[int, ...], names: Sequence[str], who: str) -> Array:
    """Actions as finite numbers (*batch, len(names)). Raises BadInput that names the controller."""
    shape = (*batch, len(names))
    try:
        taken = np.asarray(action, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput(
            f"controller '{who}': action {action!r:.60} is not {wanted(names)}"
        ) from None
    if taken.shape != shape:
        raise BadInput(
            f"controller '{who}': action has shape {taken.shape}, not {shape}; give {wanted(names)}"
        )
    if not np.isfinite(taken).all():
        place = np.argwhere(~np.isfinite(taken))[0]
        raise BadInput(
            f"controller '{who}': action {names[place[-1]]} = {taken[tuple(place)]} is not finite; "
            f"give {wanted(names)}"
        )
    return taken


def _written(controller: Controller) -> object:
    """Object that a user wrote, of unknown type."""
    return controller.controller if isinstance(controller, OneByOne) else controller
