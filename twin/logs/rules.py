"""Rules that choose rows of a log: by label, by wheel speed and by how steady it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twin.logs.gaps import between
from twin.streams import Array, Table

KMH = 3.6
"""Kilometres per hour in one metre per second."""


@dataclass(frozen=True, kw_only=True)
class Rule:
    """Which rows of a log count; speeds are of the driven wheels as logged, before any scale."""

    where: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Label column -> the labels that count."""
    min_speed_kmh: float = 0.0
    """Rows must be faster than this."""
    max_speed_kmh: float = math.inf
    """Rows must be slower than this."""
    max_speed_change_kmhps: float = math.inf
    """Greatest change of speed over the second before the row, by magnitude."""

    def __str__(self) -> str:
        parts = [f"{name} in {{{', '.join(v)}}}" for name, v in self.where.items()]
        if self.min_speed_kmh > 0.0:
            parts.append(f"wheel speed > {self.min_speed_kmh:g} km/h")
        if self.max_speed_kmh < math.inf:
            parts.append(f"wheel speed < {self.max_speed_kmh:g} km/h")
        if self.max_speed_change_kmhps < math.inf:
            parts.append(f"|change of wheel speed| < {self.max_speed_change_kmhps:g} km/h per s")
        return ", ".join(parts) or "all rows"


def choose(
    rule: Rule, rows: Table | None, epoch_ns: NDArray[np.int64], wheel_speed_mps: Array
) -> NDArray[np.bool_]:
    """The rows the rule chooses; one whose speed was not measured is not chosen. Shape (n,)."""
    speed_kmh = np.abs(wheel_speed_mps) * KMH
    chosen: NDArray[np.bool_] = (speed_kmh > rule.min_speed_kmh) & (speed_kmh < rule.max_speed_kmh)
    if rule.max_speed_change_kmhps < math.inf:
        chosen &= np.abs(_change_kmhps(epoch_ns, speed_kmh)) < rule.max_speed_change_kmhps
    for name, labels in rule.where.items():
        chosen &= np.isin((rows or {})[name], labels)
    return chosen


def _change_kmhps(epoch_ns: NDArray[np.int64], speed_kmh: Array) -> Array:
    """Speed now less speed 1 s ago; NaN where no samples are around 1 s ago."""
    if not len(epoch_ns):
        return np.empty(0)
    time_s = (epoch_ns - epoch_ns[0]) * 1e-9
    return np.asarray(speed_kmh - between(time_s - 1.0, time_s, speed_kmh, longest_s=1.5))
