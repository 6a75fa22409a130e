"""What a calibration foretells of a part of a log that it never saw, beside a line and a constant.

The line is slip = a + b F with F = engine torque x engine speed / wheel speed, by Huber's loss; the
constant is the median slip. Both are fitted to the rows that the calibration was fitted to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.calibration.fitting import STEP, Fit
from twin.calibration.steady import Steady
from twin.calibration.steady_rows import SteadyRows

Array = NDArray[np.float64]

BLOCK_S = 300.0
"""Rows of five minutes are drawn together: their errors are alike."""
DRAWS = 2000
BAND_SD = 1.96
LOSS_SLIP = 0.01
"""Slip beyond which Huber's loss of the line grows linearly."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """Errors of slip in the held-out rows."""

    slip_rms: float
    slip_mae: float
    coverage: float
    """Share of the rows within the band of 95 %."""
    line_rms: float
    constant_rms: float
    gain_low: float
    """The line's rms less the calibration's: 95 % interval over blocks."""
    gain_high: float
    line_mae: float
    bias: float
    fuel_rms_lph: float
    """NaN without a fuel rate."""
    speed_rms_mps: float
    rows: int
    blocks: int

    @property
    def verdict(self) -> str:
        """Whether it foretells slip better than the line."""
        if self.gain_low <= 0.0 <= self.gain_high or not np.isfinite(self.gain_low):
            return "a tie with the line"
        return "better than the line" if self.gain_low > 0.0 else "worse than the line"


def scored(model: Steady, fit: Fit, fitted: SteadyRows, held: SteadyRows, seed: int) -> Score:
    """The errors of what was foretold.

    Args:
        model: of the fitted rows.
        fit: what was found.
        fitted, held: rows of work with a ground speed.
        seed: of the draws of blocks.
    """
    scale = fit.values.get("log.wheel_scale", 1.0)
    slip, slip_fitted = 1.0 - held.ratio / scale, 1.0 - fitted.ratio / scale
    foretold, slopes = _foretold(model.of(held), fit)
    error = slip - (1.0 - foretold[:, 0] / scale)
    of_parameters = np.einsum("ip,pq,iq->i", slopes[:, 0], fit.cov, slopes[:, 0])
    band = BAND_SD * np.sqrt(of_parameters + fit.noise.sd()[0, 0] ** 2 + _lasting_var(model, fit))
    off_line = slip - line(slip_fitted, fitted.force, held.force)
    off_constant = slip - np.median(slip_fitted)
    low, high = gain(error, off_line, held.time_s, seed)
    fuel = model.measured.shape[1] > 1
    return Score(
        slip_rms=rms(error), slip_mae=float(np.mean(np.abs(error))), bias=float(np.mean(error)),
        coverage=float(np.mean(np.abs(error) * scale <= band)), line_rms=rms(off_line),
        line_mae=float(np.mean(np.abs(off_line))), constant_rms=rms(off_constant),
        gain_low=low, gain_high=high,
        fuel_rms_lph=rms(held.fuel_lph - foretold[:, 1]) if fuel else np.nan,
        speed_rms_mps=rms(held.speed_mps - foretold[:, 0] * held.wheel_mps),
        rows=len(held), blocks=len(np.unique(held.time_s // BLOCK_S)),
    )  # fmt: skip


def _foretold(model: Steady, fit: Fit) -> tuple[Array, Array]:
    """Channels (n, c) and their slopes (n, c, p)."""
    beside = fit.u + np.vstack([np.zeros(len(fit.u)), STEP * np.eye(len(fit.u))])
    found = model.foretold(np.exp(beside))
    return found[0], np.moveaxis((found[1:] - found[0]) / STEP, 0, -1)


def _lasting_var(model: Steady, fit: Fit) -> float:
    """Variance of what lasts for a block: that of the blocks' means above what their rows explain.

    The ground, the tyres' wear of the day and the load differ from place to place; no parameter
    that is the same in all rows tells of it.
    """
    block = (model.time_s // BLOCK_S).astype(int)
    residual, noise_var = fit.residual[:, 0], float(fit.noise.sd()[0, 0] ** 2)
    kinds, counts = np.unique(block, return_counts=True)
    if len(kinds) < 3:
        return 0.0
    means = np.array([np.mean(residual[block == kind]) for kind in kinds])
    left = float(np.mean(means**2 - noise_var / counts))
    return max(left, 0.0)


def line(slip: Array, force: Array, at: Array) -> Array:
    """Slip by the line that fits rows of slip and force, at other forces."""
    from scipy.optimize import least_squares  # lazily: slow to import

    unit = max(float(np.median(np.abs(force))), 1e-9)

    def off(p: Array) -> Array:
        return np.asarray(p[0] + p[1] * force / unit - slip)

    found = least_squares(off, np.array([0.0, 0.05]), loss="huber", f_scale=LOSS_SLIP).x
    return np.asarray(found[0] + found[1] * at / unit)


def gain(error: Array, other: Array, time_s: Array, seed: int) -> tuple[float, float]:
    """95 % interval of the rms of `other` less that of `error`, over pairs of blocks."""
    block = (time_s // BLOCK_S).astype(int)
    kinds = np.unique(block)
    if len(kinds) < 3:
        return np.nan, np.nan
    own = np.array([[np.sum(e[block == k] ** 2) for k in kinds] for e in (error, other)])
    counts = np.array([np.sum(block == k) for k in kinds])
    drawn = np.random.default_rng(seed).integers(len(kinds), size=(DRAWS, len(kinds)))
    by = np.sqrt(own[:, drawn].sum(axis=2) / counts[drawn].sum(axis=1))
    low, high = np.percentile(by[1] - by[0], [2.5, 97.5])
    return float(low), float(high)


def rms(error: Array) -> float:
    """Root of the mean square; NaN of nothing."""
    known = error[np.isfinite(error)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")
