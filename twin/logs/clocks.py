"""How far the clocks of a log's files are apart, found from the speeds that they hold.

The coarse offset is where two speeds correlate best over all shifts at which they overlap (Padfield
2012, IEEE Trans. Image Proc. 21, 2706, masked normalised correlation in one dimension). The fine
one is the lag of `estimators.lag`; in a log too short for it, the shift of least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.lag import gnss_lag
from twin.errors import BadInput
from twin.streams import Array

LEAST_CORRELATION = 0.6
MARGIN = 0.03
"""How far the best correlation must be above any other that is not beside it."""
CLEARLY, ROUNDING = 0.5, 1e-3
"""Or what it leaves unexplained must be less than this share of what the other leaves."""
LEAST_OVERLAP = 0.25
"""Share of the shorter speed that must overlap."""
GRID = 1 << 18
"""Most samples of a grid."""
FINE_S = 2.0
AGREE_SD = 3.0
"""Offsets of less than this many standard deviations count as zero."""
_NORMAL_95 = 1.96


@dataclass(frozen=True, kw_only=True)
class Speed:
    """Absolute speed that one file contains."""

    epoch_ns: NDArray[np.int64]
    mps: Array


@dataclass(frozen=True, kw_only=True)
class Offset:
    """Time by which one clock is ahead of another."""

    offset_s: float
    sd_s: float


def offset(reference: Speed, other: Speed) -> Offset:
    """Offset: clock of `other` minus clock of `reference`. Raises BadInput if it is not found."""
    ref_s, ref = _seconds(reference)
    own_s, own = _seconds(other)
    if len(ref) < 10 or len(own) < 10 or np.ptp(ref) < 0.2 or np.ptp(own) < 0.2:
        raise BadInput("the speeds hardly change, so they do not say how far the clocks are apart")
    start_s, begin_s = ref_s[0], own_s[0]
    ref_s, own_s = ref_s - start_s, own_s - begin_s
    coarse_s = _coarse(ref_s, ref, own_s, own)
    fine_s, sd_s = _fine(ref_s, ref, own_s - coarse_s, own)
    return Offset(offset_s=float(begin_s - start_s) + coarse_s + fine_s, sd_s=sd_s)


def _seconds(speed: Speed) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    known = np.isfinite(speed.mps)
    return np.asarray(speed.epoch_ns[known] * 1e-9), np.abs(speed.mps[known])


def _coarse(
    ref_s: NDArray[np.float64], ref: Array, own_s: NDArray[np.float64], own: Array
) -> float:
    """Shift of best correlation to the step of the grid [s]."""
    step_s = float(max(np.median(np.diff(ref_s)), np.median(np.diff(own_s)), 0.1))
    step_s = max(step_s, (ref_s[-1] + own_s[-1]) / GRID)
    a, b = _gridded(ref_s, ref, step_s), _gridded(own_s, own, step_s)
    shift, score = _correlations(a, b, LEAST_OVERLAP * min(len(a), len(b)))
    best = int(np.argmax(score))
    beside = np.abs(shift - shift[best]) * step_s < 30.0
    rival = float(score[~beside].max()) if (~beside).any() else -1.0
    least_left = 1.0 - float(score[best]) + ROUNDING < CLEARLY * (1.0 - rival + ROUNDING)
    if score[best] < LEAST_CORRELATION or not (least_left or score[best] > rival + MARGIN):
        raise BadInput(
            f"the speeds of two files do not say how far their clocks are apart (best correlation"
            f" {score[best]:.2f}, next {rival:.2f}); say it: offset_s in [log], or --offset"
        )
    return float(shift[best] * step_s)


def _gridded(time_s: NDArray[np.float64], values: Array, step_s: float) -> NDArray[np.float64]:
    """Means of the samples about each point of a grid, NaN where there is none near."""
    at = np.round(time_s / step_s).astype(np.int64)
    count = np.bincount(at)
    total = np.bincount(at, values)
    with np.errstate(invalid="ignore"):
        return np.asarray(total / np.where(count, count, np.nan))


def _correlations(
    a: NDArray[np.float64], b: NDArray[np.float64], least: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Normalised correlation of a(i) and b(i + shift) for every shift; -1 with too few pairs."""
    size = 1 << (len(a) + len(b)).bit_length()
    here, there = np.isfinite(a), np.isfinite(b)
    x, y = np.where(here, a - np.nanmean(a), 0.0), np.where(there, b - np.nanmean(b), 0.0)

    def across(p: Array, q: Array) -> NDArray[np.float64]:
        spectrum = np.conj(np.fft.rfft(p, size)) * np.fft.rfft(q, size)
        return np.asarray(np.fft.irfft(spectrum, size))

    pairs = np.maximum(across(here.astype(float), there.astype(float)), 1e-9)
    sum_x, sum_y = across(x, there.astype(float)), across(here.astype(float), y)
    var_x = across(x * x, there.astype(float)) - sum_x**2 / pairs
    var_y = across(here.astype(float), y * y) - sum_y**2 / pairs
    cross = across(x, y) - sum_x * sum_y / pairs
    floor = 1e-4 * pairs
    score = cross / np.sqrt(np.maximum(var_x, floor) * np.maximum(var_y, floor))
    # what few pairs agree in by chance counts less
    score = score * np.minimum(1.0, np.sqrt(pairs / (2.0 * least)))
    score[pairs < max(least, 8.0)] = -1.0
    shift = np.arange(size)
    shift[shift >= len(b)] -= size
    return shift, score


def _fine(
    ref_s: NDArray[np.float64], ref: Array, own_s: NDArray[np.float64], own: Array
) -> tuple[float, float]:
    """What is left of the shift [s], and its sd."""
    low_s = min(ref_s[0], own_s[0])
    ref_ns, own_ns = (np.round((t - low_s) * 1e9).astype(np.int64) for t in (ref_s, own_s))
    lag = gnss_lag(own_ns, own, ref_ns, ref, max_lag_s=FINE_S)
    if np.isfinite(lag.lag_s):
        return lag.lag_s, (lag.high_s - lag.low_s) / (2.0 * _NORMAL_95)
    return _least_squares(ref_s, ref, own_s, own)


def _least_squares(
    ref_s: NDArray[np.float64], ref: Array, own_s: NDArray[np.float64], own: Array
) -> tuple[float, float]:
    """Shift of least squares of own(t) - k ref(t - shift), sd by the slope of the speed.

    sd^2 = 2 r^2 / sum (k dv/dt)^2, r the residual; the 2 because neighbours are not independent.
    """
    shifts = np.arange(-FINE_S, FINE_S + 0.01, 0.02)
    inside = (own_s > ref_s[0] + FINE_S) & (own_s < ref_s[-1] - FINE_S)
    if inside.sum() < 5:
        raise BadInput("the speeds overlap too little to say how far the clocks are apart")
    at, v = own_s[inside], own[inside]
    moved = np.stack([np.interp(at - shift, ref_s, ref) for shift in shifts])
    scale = (moved @ v) / np.maximum(np.einsum("ij,ij->i", moved, moved), 1e-12)
    misfit = np.mean((v - scale[:, None] * moved) ** 2, axis=1)
    best = int(np.argmin(misfit))
    slope = np.gradient(scale[best] * moved[best], at)
    sd_s = float(np.sqrt(2.0 * misfit[best] / max(float(np.sum(slope**2)), 1e-12)))
    return float(shifts[best]), max(sd_s, 0.01)
