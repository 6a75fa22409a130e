"""What the map says of the job beside the machine: the implement and its working width."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange, check_range

WIDEST_M = 60.0
"""No implement is wider [m]; sprayers reach 50 m."""


@dataclass(frozen=True, kw_only=True)
class Implement:
    """The [implement] section of a map."""

    width_m: float
    """Working width: litres and time per hectare follow from it."""
    name: str = ""

    def __post_init__(self) -> None:
        check_range("implement.width_m", self.width_m, 0.1, WIDEST_M)


def implement_from(raw: Mapping[str, object]) -> Implement:
    """The implement from plain values. Raises BadInput that names the value."""
    width, name = raw.get("width_m"), raw.get("name", "")
    if isinstance(width, bool) or not isinstance(width, int | float):
        raise BadInput(f"implement.width_m = {width!r} must be a number of metres")
    if not isinstance(name, str) or len(name) > 200:
        raise BadInput(f"implement.name = {name!r} must be a short text")
    try:
        return Implement(width_m=float(width), name=name)
    except OutOfRange as error:
        raise BadInput(str(error)) from None
