"""Options that replace fields of a named scenario; only those that are given are read.

A scenario has close to two hundred fields. tyro is handed the few that stand on the command line,
and nothing where a name is wrong, so both are answered at once.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, TypeVar

from twin.errors import BadInput
from twin.plugins.lookup import Thing
from twin.scenario import fields

Options = TypeVar("Options")


def named_fields(args: Sequence[str]) -> frozenset[str]:
    """Fields that arguments name: `--soil.cone-index-kpa 800` names soil.cone_index_kpa."""
    return frozenset(option.removeprefix("--").replace("-", "_") for option in _options(args))


def read(
    options: Options, scenario: Thing, args: Sequence[str], *, prog: str
) -> tuple[Options, Thing]:
    """A command's options and a scenario, with the values that arguments give their fields.

    Args:
        options: the command's options with their defaults.
        scenario: the scenario before any override.
        args: what stands after `prog`.
        prog: the command as the user typed it.

    Raises:
        BadInput: there is no such option, or its value cannot be read.
        OutOfRange, UnknownName: a value that the field does not take.
    """
    owners = {_option(p, v): (scenario, p, v) for p, v in fields.leaves(scenario)}
    owners |= {_option(p, v): (options, p, v) for p, v in fields.leaves(options)}
    given = dict.fromkeys(option.replace("_", "-") for option in _options(args))
    if unknown := [option for option in given if option not in owners]:
        near = difflib.get_close_matches(unknown[0], owners, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise BadInput(f"there is no option {', '.join(unknown)}{hint}")
    if not args:
        return options, scenario
    values = _values({option: owners[option] for option in given}, args, prog)
    own = {path: new for (owner, path), new in values if owner is options}
    other = {path: new for (owner, path), new in values if owner is scenario}
    return fields.replaced(options, own), fields.replaced(scenario, other)


def _values(
    places: Mapping[str, tuple[Thing, str, Thing]], args: Sequence[str], prog: str
) -> list[tuple[tuple[Thing, str], Thing]]:
    """What arguments give to the fields of options: owner, path and default each."""
    import tyro

    from twin.commands.parse import parse

    held = [
        (f"given_{i}", Annotated[fields.kind(owner, path), tyro.conf.arg(name=option[2:])],
         dataclasses.field(default=False if default is True else default))
        for i, (option, (owner, path, default)) in enumerate(places.items())
    ]  # fmt: skip
    read: Thing = parse(dataclasses.make_dataclass("Given", held, frozen=True), args, prog=prog)
    values = [getattr(read, name) for name, *_ in held]
    return [
        ((owner, path), not value if default is True else value)  # a flag that turns off is read
        for (owner, path, default), value in zip(places.values(), values, strict=True)
    ]


def _options(args: Sequence[str]) -> Iterator[str]:
    """The words that begin with two hyphens, each without a value after `=`."""
    return (arg.partition("=")[0] for arg in args if arg.startswith("--") and arg != "--")


def _option(path: str, value: Thing) -> str:
    """How a field is called on the command line; a flag that is on is turned off by its option."""
    group, dot, name = path.rpartition(".")
    off = "no-" if value is True else ""
    return f"--{group}{dot}{off}{name}".replace("_", "-")
