"""The smallest errors that a run's sensors and its motion allow, for its table of scores."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from estimators.bounds import bound
from twin.streams import Setup, Streams, Table


def limits(
    setup: Setup, streams: Streams, truth: Table, window_s: tuple[float, float]
) -> dict[str, float] | None:
    """Bounds of `estimators.bounds`, by name; None where the window is too short for them."""
    try:
        found: dict[str, Any] = asdict(bound(setup, streams, truth, window_s))
    except ValueError:
        return None
    return {name: float(value) for name, value in found.items() if value == value}
