"""The zero-slip scale: how far the ground moves for each metre the wheels claim, without slip.

A bus's wheel speed, or encoders with a nominal radius, are off by a constant factor: the rolling
radius is what the tyre has today. Rows in which the wheels hardly slip (on the move, nothing in the
ground) give the factor; every slip computed with the raw speed is wrong by its departure from 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

REPLICATES = 1000
"""Bootstrap replicates: the ends of a 95 % interval are then known within about 5 % of it."""


@dataclass(frozen=True, kw_only=True)
class Scale:
    """A zero-slip scale; wheel speed times `scale` is the theoretical speed w R."""

    scale: float
    low: float
    """2.5 % end of the interval."""
    high: float
    """97.5 % end of the interval."""
    n: int
    """Rows it was found from."""
    rule: str
    """How those rows were chosen, in words."""


def zero_slip_scale(
    gnss_speed_mps: NDArray[Any],
    wheel_speed_mps: NDArray[Any],
    moving: NDArray[np.bool_],
    *,
    rule: str = "rows given",
    seed: int = 0,
) -> Scale:
    """The median of gnss speed / wheel speed over the rows `moving`, with its 95 % interval.

    The few rows that do slip hardly move the median. Shapes (n,), speeds at the same epochs; rows
    in which either was not measured do not count. With no row left, scale and interval are NaN.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.asarray(gnss_speed_mps) / np.asarray(wheel_speed_mps)
    ratio = ratio[moving & np.isfinite(ratio)]
    medians = bootstrap_medians(ratio, seed=seed)
    low, high = np.quantile(medians, (0.025, 0.975)) if len(ratio) else (np.nan, np.nan)
    centre = float(np.median(ratio)) if len(ratio) else np.nan
    return Scale(scale=centre, low=float(low), high=float(high), n=len(ratio), rule=rule)


def bootstrap_medians(
    values: NDArray[Any], *, seed: int, replicates: int = REPLICATES
) -> NDArray[np.float64]:
    """Medians of circular-block bootstrap replicates of a serially correlated series.

    Blocks keep neighbours together, so that the spread is that of the correlated series
    (Politis and Romano 1992, "A circular block-resampling procedure for stationary data").
    Shape (replicates,); NaN for an empty series.
    """
    n = len(values)
    if n == 0:
        return np.full(replicates, np.nan)
    length = block_length(values)
    blocks = -(-n // length)
    generator = np.random.default_rng(seed)
    medians = np.empty(replicates)
    for i in range(replicates):
        starts = generator.integers(0, n, blocks)
        rows = (starts[:, None] + np.arange(length)).ravel()[:n] % n
        medians[i] = np.median(values[rows])
    return medians


def block_length(values: NDArray[Any]) -> int:
    """Rows of a bootstrap block: long against the memory of the series, at most a quarter of it.

    l = (2 G^2 / D)^(1/3) n^(1/3),  G = sum_k L(k/M) |k| R(k),  D = 4/3 (sum_k L(k/M) R(k))^2

    R is the autocovariance, L the flat-top window, M twice the lag after which the correlation
    stays within chance (Politis and White 2004, Econom. Rev. 23, 53, circular block bootstrap).
    """
    n = len(values)
    deviation = values - np.mean(values)
    power = float(np.sum(deviation**2)) / n
    if n < 8 or power == 0.0:
        return 1
    window_lags = min(2 * _memory(deviation, power), n - 1)
    lags = np.arange(1, window_lags + 1)
    taper = np.clip(2.0 * (1.0 - lags / (window_lags + 1)), 0.0, 1.0)
    covariance = taper * _autocovariance(deviation, window_lags)
    spread = 2.0 * float(np.sum(lags * covariance))
    density = power + 2.0 * float(np.sum(covariance))
    longest = max(n // 4, 1)
    if density <= 0.0:
        return 1
    length = (2.0 * spread**2 / (4.0 / 3.0 * density**2)) ** (1 / 3) * n ** (1 / 3)
    return int(min(max(round(length), 1), longest))


def _autocovariance(deviation: NDArray[Any], lags: int) -> NDArray[np.float64]:
    n = len(deviation)
    return np.array([np.dot(deviation[k:], deviation[: n - k]) / n for k in range(1, lags + 1)])


def _memory(deviation: NDArray[Any], power: float) -> int:
    """The lag after which five correlations in a row are below 2 sqrt(log10(n) / n)."""
    n = len(deviation)
    run = max(5, int(np.sqrt(np.log10(n))))
    lags = min(int(np.sqrt(n)) + run, n - 1)
    small = np.abs(_autocovariance(deviation, lags) / power) < 2.0 * np.sqrt(np.log10(n) / n)
    for start in range(lags - run + 1):
        if small[start : start + run].all():
            return max(start, 1)
    return lags
