"""The part of a log that was never fitted, predicted and scored beside a line and a constant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from twin.calibration.fitting import STEP
from twin.calibration.steady_rows import SteadyRows

Array = NDArray[np.float64]
BLOCK_S, FEWEST_BLOCKS = 300.0, 4
"""Blocks of the paired interval; shorter ones where the part held back has fewer than four."""
REPLICATES = 2000
NORMAL_95 = 1.96
HUBER_SLIP = 0.01


@dataclass(frozen=True)
class Holdout:
    """Rows that were held back, predicted; and their scores."""

    rows: SteadyRows
    slip: Array
    """Predicted."""
    slip_sd: Array
    measured: Array
    """By the scale of the wheels that was found; NaN where GNSS is not known."""
    line: Array
    constant: float
    scores: dict[str, float | None]
    block_s: float


def held_out(
    rows: SteadyRows, fitted: SteadyRows, ratios: Array, cov: Array, noise_sd: float, scale: float,
    seed: int = 0,
) -> Holdout:  # fmt: skip
    """Score rows that were never fitted.

    The sd of the predicted slip has the parameters' uncertainty and the noise. It is compared with
    a straight line of slip in engine torque x engine speed / wheel speed by Huber's loss, and with
    the median, both of the fitted rows.

    Args:
        rows: held back.
        fitted: the others.
        ratios: ground over logged wheel speed of `rows`, predicted at the parameters' mean and
            beside it, as `fitting.beside` has them. Shape (1 + p, n).
        cov: of the parameters' logarithms.
        noise_sd: of a measured ratio about a predicted one.
        scale: true over logged wheel speed at zero slip.
        seed: of the blocks that are drawn.
    """
    slopes = (ratios[1:] - ratios[0]).T / STEP
    spread = np.sqrt(np.einsum("np,pq,nq->n", slopes, cov, slopes) + noise_sd**2)
    slip, slip_sd = 1.0 - ratios[0] / scale, spread / scale
    measured = 1.0 - rows.ratio / scale
    size = float(np.median(fitted.force))
    found = 1.0 - fitted.ratio / scale

    def left(p: Array) -> Array:
        return np.asarray(p[0] + p[1] * fitted.force / size - found)

    line = least_squares(left, [0.0, 0.1], loss="huber", f_scale=HUBER_SLIP).x
    straight, constant = line[0] + line[1] * rows.force / size, float(np.median(found))
    known = np.isfinite(measured)
    lasts_s = float(np.ptp(rows.time_s[known])) if known.any() else 0.0
    block_s = BLOCK_S if lasts_s >= FEWEST_BLOCKS * BLOCK_S else max(lasts_s / 5.0, 5.0)
    scores = _scores(rows.time_s[known], measured[known], slip[known], slip_sd[known],
                     straight[known], constant, block_s, seed)  # fmt: skip
    return Holdout(rows, slip, slip_sd, measured, straight, constant, scores, block_s)


def _scores(
    time_s: Array, measured: Array, slip: Array, slip_sd: Array, line: Array, constant: float,
    block_s: float, seed: int,
) -> dict[str, float | None]:  # fmt: skip
    names = ("slip_rms", "slip_mae", "coverage", "line_rms", "constant_rms", "gain_low",
             "gain_high")  # fmt: skip
    if not len(measured):
        return dict.fromkeys(names)
    own, straight = measured - slip, measured - line
    inside = np.abs(own) <= NORMAL_95 * slip_sd
    low, high = _gain(time_s, own, straight, block_s, seed)
    values = (_rms(own), float(np.mean(np.abs(own))), float(np.mean(inside)), _rms(straight),
              _rms(measured - constant), low, high)  # fmt: skip
    return dict(zip(names, values, strict=True))


def _gain(
    time_s: Array, own: Array, straight: Array, block_s: float, seed: int
) -> tuple[float, float]:
    """95 % interval of the line's rms less ours, the same blocks drawn for both."""
    blocks = (time_s / block_s).astype(np.int64)
    _, place = np.unique(blocks, return_inverse=True)
    sums = np.array([np.bincount(place, v) for v in (own**2, straight**2, np.ones(len(own)))])
    generator = np.random.default_rng(seed)
    chosen = generator.integers(0, sums.shape[1], (REPLICATES, sums.shape[1]))
    ours, lines, count = sums[:, chosen].sum(axis=2)
    gains = np.sqrt(lines / count) - np.sqrt(ours / count)
    low, high = np.quantile(gains, (0.025, 0.975))
    return float(low), float(high)


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))
