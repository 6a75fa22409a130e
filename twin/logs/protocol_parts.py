"""The parts of the recording protocol, and when the map says that they were driven."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from twin.errors import BadInput


class Part(StrEnum):
    """What is driven, as the documentation names it."""

    STANDING = "standing"
    CLOCK_CHECK = "clock check"
    ZERO_PULL = "zero-pull passes"
    COAST_DOWN = "coast-down"
    TOWED = "towed-wheel run"


KEYS = {part.value.replace("-", "_").replace(" ", "_") + "_s": part for part in Part}
"""Key of the map's [protocol] -> the part."""

Times = tuple[tuple[float, float], ...]
"""Start and end of each drive of a part, in seconds from the start of the log."""


def written_from(raw: Mapping[str, object]) -> dict[Part, Times]:
    """The times of the map's [protocol], in seconds from the start. Raises BadInput."""
    return {KEYS[key]: _pairs(f"protocol.{key}", value) for key, value in raw.items()}


def _pairs(where: str, value: object) -> Times:
    pairs = value if isinstance(value, list) else []
    if not pairs or not all(_is_pair(pair) for pair in pairs):
        raise BadInput(
            f"{where} = {value!r} must be a list of [start, end] in seconds from the start"
        )
    return tuple((float(first), float(last)) for first, last in pairs)


def _is_pair(pair: object) -> bool:
    if not isinstance(pair, list) or len(pair) != 2:
        return False
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in pair)
    return numbers and 0.0 <= pair[0] < pair[1] <= 1e7
