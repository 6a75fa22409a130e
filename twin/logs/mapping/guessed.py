"""A signal as numbers on its times, and what it is taken for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Guess:
    """What a signal is taken to be."""

    signal: str
    section: str
    key: str
    unit: str
    why: str
    sure: bool
    convention: str = ""
    sign: int = 1
    unit_told: bool = False
    """The name says the unit, and physics does not change it."""
    own: bool = False
    """Named as a column of a stream, which has one unit and sense."""


@dataclass(frozen=True, kw_only=True)
class Seen:
    """A signal as numbers on its times."""

    name: str
    values: NDArray[np.float64]
    time_s: NDArray[np.float64]

    @property
    def rate_hz(self) -> float:
        """Values in a second, at the median; NaN for fewer than two."""
        known = self.time_s[np.isfinite(self.values)]
        step = np.diff(known)
        return float(1.0 / np.median(step)) if len(step) and np.median(step) > 0 else math.nan

    @property
    def holes(self) -> float:
        """Share of rows without a value."""
        return float(np.mean(~np.isfinite(self.values))) if len(self.values) else 1.0
