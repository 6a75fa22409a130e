"""What of the ground an environment's constructor gives: fixed, scheduled, one for each tractor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from numpy.random import Generator

from twin.env.grounds import Options, Recipe, check_options
from twin.errors import BadInput
from twin.plugins.failing import failing

Schedule: TypeAlias = Mapping[str, Any] | Callable[[int, Generator], Mapping[str, Any]]
"""Options of the ground, for every episode; or what gives those of an episode, by its number from 0
and the generator from which the rest of the ground is drawn."""
Grounds: TypeAlias = Schedule | list[Schedule] | tuple[Schedule, ...] | None
"""Of the argument `grounds`: one schedule for all tractors, one for each, or nothing."""


def schedules(grounds: Grounds, count: int, recipe: Recipe) -> list[Schedule]:
    """A schedule for each tractor; what is fixed is checked here.

    Args:
        grounds: as the constructor is given it.
        count: how many tractors.
        recipe: which options there are.

    Raises:
        BadInput: it is no schedule, or there is not one for each tractor.
        UnknownName, OutOfRange: an option that cannot be.
    """
    if grounds is None:
        return [{}] * count
    if callable(grounds) or isinstance(grounds, Mapping):
        found: list[Schedule] = [grounds] * count
    elif isinstance(grounds, list | tuple):
        found = list(grounds)
    else:
        raise BadInput(
            f"grounds = {grounds!r:.60} is not options by name, nor (episode, generator) -> "
            "options, nor a list of one of these for each tractor"
        )
    if len(found) != count:
        raise BadInput(f"{len(found)} grounds for {count} tractors; give one for each, or one")
    return [each if callable(each) else check_options(_options(each), recipe) for each in found]


def of_episode(schedule: Schedule, episode: int, generator: Generator, recipe: Recipe) -> Options:
    """The options of an episode. Raises as `schedules` does, and BadInput where a function fails.

    Args:
        schedule: of the tractor.
        episode: how many it has begun before.
        generator: of the tractor.
        recipe: which options there are.
    """
    if not callable(schedule):
        return dict(schedule)
    with failing("grounds", schedule):
        given = schedule(episode, generator)
    return check_options(_options(given), recipe)


def _options(given: object) -> Options:
    if not isinstance(given, Mapping):
        raise BadInput(f"grounds gives {given!r:.60}, not options by name")
    return dict(given)
