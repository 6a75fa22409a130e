"""Range checks of a sensor's configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from twin.errors import check_range


def check_fields(prefix: str, config: Any, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Raise OutOfRange unless every named field (each element of a tuple) lies in its range."""
    for name, (low, high) in ranges.items():
        value = getattr(config, name)
        for element in value if isinstance(value, tuple) else (value,):
            check_range(f"{prefix}.{name}", element, low, high)
