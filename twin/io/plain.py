"""Frozen dataclasses to and from plain JSON values, by their own annotations.

JSON has no NaN: it becomes null, which a field that takes nothing but a float reads as NaN.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Mapping
from typing import Any, TypeAlias, TypeVar

from twin.errors import BadInput

T = TypeVar("T")
Plain: TypeAlias = Any
"""A value of a JSON file, or one that `to_plain` turns into one; also of an untyped library."""


def to_plain(value: Plain) -> Plain:
    """A dataclass, mapping, sequence or scalar as dict, list and scalar.

    A class may say its own way by methods `to_plain()` and `from_plain(value)`.
    """
    if hasattr(value, "to_plain"):
        return to_plain(value.to_plain())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(k): to_plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(v) for v in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def from_plain(kind: type[T], value: Plain) -> T:
    """The dataclass `kind` from what `to_plain` made of it.

    Raises:
        BadInput: a field is unknown, missing or of another shape. What the dataclass itself
            refuses (`OutOfRange`) passes through.
    """
    if not isinstance(value, Mapping):
        raise BadInput(f"{kind.__name__} is {type(value).__name__}, not an object of fields")
    hints = typing.get_type_hints(kind)
    names = [f.name for f in dataclasses.fields(kind) if f.init]  # type: ignore[arg-type]
    for key in value:
        if key not in names:
            raise BadInput(f"{kind.__name__} has no field '{key}'; there are: {', '.join(names)}")
    try:
        return kind(**{key: _shaped(hints[key], item) for key, item in value.items()})
    except TypeError as error:
        raise BadInput(f"{kind.__name__} cannot be made: {error}") from None


def _shaped(hint: object, value: Plain) -> Plain:
    if value is None:
        return math.nan if hint is float else None
    if typing.get_origin(hint) is typing.Annotated:
        return _shaped(typing.get_args(hint)[0], value)
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return _shaped(_member(typing.get_args(hint), value), value)
    own: Plain = getattr(hint, "from_plain", None)
    if own is not None:
        return own(value)
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return from_plain(hint, value)
    if typing.get_origin(hint) is tuple and isinstance(value, list):
        inner = typing.get_args(hint)
        if len(inner) == 2 and inner[1] is Ellipsis:
            return tuple(_shaped(inner[0], v) for v in value)
        return tuple(_shaped(h, v) for h, v in zip(inner, value, strict=False))
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    return value


def _unknown(member: type, names: Mapping[str, Plain]) -> int:
    """How many of the names are no fields of a dataclass."""
    return len(set(names) - {f.name for f in dataclasses.fields(member)})


def _member(members: tuple[object, ...], value: Plain) -> Plain:
    """The member of a union that holds the value: by kind, and objects by their fields.

    Where none has all the fields of an object it is the one that lacks fewest, which says so.
    """
    if isinstance(value, Mapping):
        kinds = [m for m in members if isinstance(m, type) and dataclasses.is_dataclass(m)]
        return min(kinds, key=lambda m: _unknown(m, value), default=dict)
    if isinstance(value, list):
        return next((m for m in members if typing.get_origin(m) is tuple), list)
    return next((m for m in members if m is type(value)), float)
