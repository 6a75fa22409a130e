"""Fields of nested frozen dataclasses by dotted path: `soil.friction`, `field.patches.0.length_m`.

A hyphen may replace an underscore, as on the command line.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterator, Mapping

from twin.errors import BadInput, UnknownName
from twin.plugins.lookup import Thing


def spelled(path: str) -> str:
    """The path as the fields are called."""
    return path.strip().lstrip("-").replace("-", "_")


def value(thing: Thing, path: str) -> Thing:
    """What stands at a path. Raises as `kind`."""
    for name in path.split("."):
        thing = _part(thing, name, path)
    return thing


def leaves(thing: Thing, before: str = "") -> Iterator[tuple[str, Thing]]:
    """Path and value of every field that is no group of fields, in their order."""
    for field in dataclasses.fields(thing):
        held, path = getattr(thing, field.name), f"{before}{field.name}"
        grouped = held if isinstance(held, tuple) else (held,)
        if not (grouped and all(map(dataclasses.is_dataclass, grouped))):
            yield path, held
        elif held is not grouped:
            yield from leaves(held, f"{path}.")
        else:
            for i, each in enumerate(held):
                yield from leaves(each, f"{path}.{i}.")


def kind(thing: Thing, path: str) -> Thing:
    """The annotation of the field at a path; a union as `typing` has it, which tyro reads faster.

    Raises:
        UnknownName: a part of the path is no field.
        BadInput: the path goes through None, or ends at a group of fields.
    """
    *groups, last = path.split(".")
    owner = value(thing, ".".join(groups)) if groups else thing
    held = _part(owner, last, path)
    if dataclasses.is_dataclass(held):
        names = ", ".join(f"{path}.{field.name}" for field in dataclasses.fields(held))
        raise BadInput(f"{path} is a group of fields; name one of {names}")
    if isinstance(owner, tuple):
        return type(held)
    hint = typing.get_type_hints(type(owner), include_extras=True)[last]
    return typing.Union[*typing.get_args(hint)] if isinstance(hint, types.UnionType) else hint


def replaced(thing: Thing, values: Mapping[str, Thing]) -> Thing:
    """A copy with other values at some paths.

    All of one object are set at once, so that only what comes out is checked.

    Raises:
        UnknownName, BadInput: as `kind`; and what the dataclasses themselves refuse.
    """
    grouped: dict[str, dict[str, Thing]] = {}
    here: dict[str, Thing] = {}
    for path, new in values.items():
        name, _, rest = path.partition(".")
        _part(thing, name, path)
        if rest:
            grouped.setdefault(name, {})[rest] = new
        else:
            here[name] = new
    for name, inner in grouped.items():
        here[name] = replaced(_part(thing, name, name), inner)
    if isinstance(thing, tuple):
        return tuple(here.get(str(i), each) for i, each in enumerate(thing))
    return dataclasses.replace(thing, **here) if here else thing


def _part(thing: Thing, name: str, path: str) -> Thing:
    if isinstance(thing, tuple):
        known = [str(i) for i in range(len(thing))]
    elif dataclasses.is_dataclass(thing):
        known = [field.name for field in dataclasses.fields(thing)]
    elif thing is None:
        raise BadInput(f"{path} cannot be set: what {name} would belong to is None here")
    else:
        raise BadInput(f"{path} goes beyond a plain value, {thing!r}")
    if name not in known:
        raise UnknownName(f"field of {type(thing).__name__}", name, known)
    return thing[int(name)] if isinstance(thing, tuple) else getattr(thing, name)
