"""The range of valid values of a field, written in the field's type:

`speed_sd_mps: Annotated[float, Range(0, 1)] = 0.05`.
"""

from __future__ import annotations

import typing
from dataclasses import dataclass
from functools import cache

from twin.errors import check_range


@dataclass(frozen=True)
class Range:
    """Least and greatest value of a field, or of each element of a tuple."""

    low: float
    high: float


def check_fields(prefix: str, config: object, *, given_only: bool = False) -> None:
    """Raise OutOfRange unless every field with a Range (each element of a tuple) lies in it.

    Args:
        prefix: name of the table, which messages put before the field's name; may be empty.
        config: a dataclass instance.
        given_only: skip fields that are None.
    """
    kind: type = type(config)
    for name, allowed in _ranges(kind).items():
        value = getattr(config, name)
        if value is None and given_only:
            continue
        for element in value if isinstance(value, tuple) else (value,):
            path = f"{prefix}.{name}" if prefix else name
            check_range(path, element, allowed.low, allowed.high)


@cache
def _ranges(kind: type) -> dict[str, Range]:
    """Range of each field of a class that has one."""
    hints = typing.get_type_hints(kind, include_extras=True)
    found = {name: getattr(hint, "__metadata__", ()) for name, hint in hints.items()}
    return {name: r for name, marks in found.items() for r in marks if isinstance(r, Range)}
