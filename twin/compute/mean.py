"""The mean of a sample with its 95 % interval by Student's t."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Mean:
    """Mean of `n` values and its 95 % interval: NaN from one value, the mean too from none."""

    mean: float
    low: float
    high: float
    n: int

    @property
    def half(self) -> float:
        """Half the width of the interval about the mean."""
        return self.high - self.mean

    @property
    def bounds(self) -> dict[str, float]:
        """The interval as `low` and `high` of a row of results; empty where there is none."""
        return {"low": self.low, "high": self.high} if self.n > 1 else {}


def mean(values: Iterable[float]) -> Mean:
    """Mean and interval of independent values: mean -+ t(0.975, n - 1) sd / sqrt(n)."""
    from scipy.stats import t  # late: slow to import

    sample = np.fromiter(values, np.float64)
    n = len(sample)
    if n == 0:
        return Mean(math.nan, math.nan, math.nan, 0)
    centre = float(np.mean(sample))
    if n == 1:
        return Mean(centre, math.nan, math.nan, 1)
    half = float(t.ppf(0.975, n - 1) * np.std(sample, ddof=1) / np.sqrt(n))
    return Mean(centre, centre - half, centre + half, n)
