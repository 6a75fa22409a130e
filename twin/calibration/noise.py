"""Noise of measurements: each channel's sd, their correlation, and the correlation time.

A residual r_i of c channels at time t_i is whitened in two steps:

    w_i = L_i^-1 r_i                         L_i L_i' = C_i, covariance of the channels
    e_i = (w_i - a_i w_(i-1)) / sqrt(1 - a_i**2)    a_i = exp(-(t_i - t_(i-1)) / tau)

tau is the correlation time of the noise [s]. e_0 = w_0; with tau = 0, e_i = w_i. Samples within one
tau carry little more information than one sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TAUS_S = (0.0, 2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0)
"""Correlation times that are compared [s]."""
MAD_SD = 1.4826
"""Standard deviation of a normal variable over its median absolute deviation."""
HUBER = 2.0
"""Whitened residuals beyond this many sd pull no harder than one at it."""


@dataclass(frozen=True)
class Noise:
    """What is taken for the noise of measurements."""

    cholesky: Array
    """Lower factor of the channels' covariance in each row. Shape (n, c, c)."""
    tau_s: float
    """Correlation time [s]; 0 where rows are independent."""

    def sd(self) -> Array:
        """Standard deviations. Shape (n, c)."""
        return np.asarray(np.sqrt(np.sum(self.cholesky**2, axis=2)))

    def scaled(self, by: float) -> Noise:
        """Noise whose standard deviations are `by` times as large."""
        return Noise(self.cholesky * by, self.tau_s)


def known(covariance: Array) -> Noise:
    """Independent rows of known covariance (n, c, c)."""
    return Noise(np.asarray(np.linalg.cholesky(covariance), np.float64), 0.0)


def whitened(noise: Noise, residual: Array, time_s: Array) -> Array:
    """Residuals with unit covariance where the noise is right. Shape (..., n, c)."""
    inverse = np.linalg.inv(noise.cholesky)
    white = np.einsum("nij,...nj->...ni", inverse, residual)
    if noise.tau_s <= 0.0 or len(time_s) < 2:
        return np.asarray(white)
    kept = np.exp(-np.diff(time_s) / noise.tau_s)[:, None]
    fresh = (white[..., 1:, :] - kept * white[..., :-1, :]) / np.sqrt(1.0 - kept**2)
    return np.concatenate([white[..., :1, :], fresh], axis=-2)


def huber_weights(white: Array) -> Array:
    """Square roots of Huber's weights: 1 up to HUBER sd, then sqrt(HUBER / |e|)."""
    return np.asarray(np.sqrt(HUBER / np.maximum(np.abs(white), HUBER)))


def estimated(residual: Array, time_s: Array, floor: Array) -> Noise:
    """The noise of residuals (n, c): robust sd of each channel, and the likeliest duration.

    sd**2 = mean(min(r**2, 2 |r| sd)) / 0.954, Huber's; tau minimises, with that sd and Huber's rho,

        sum log(1 - a_i**2) / 2 + rho(e_i)

    Channels are taken as independent of each other; `floor` is the least sd of each.
    """
    sd = np.maximum(MAD_SD * np.median(np.abs(residual), axis=0), floor)
    for _ in range(10):
        weight = huber_weights(residual / sd)
        square = np.mean((weight * residual) ** 2, axis=0) / HUBER_SHARE
        sd = np.maximum(np.sqrt(square), floor)
    tried = [Noise(_diagonal(sd, len(residual)), tau_s) for tau_s in TAUS_S]
    return min(tried, key=lambda noise: _cost(noise, residual, time_s))


HUBER_SHARE = 0.954
"""Mean of (w e)**2 of a normal e with Huber's weights at 2 sd: E min(e**2, 2 |e|)."""


def _diagonal(sd: Array, count: int) -> Array:
    return np.repeat(np.diag(sd)[None], count, axis=0)


def _cost(noise: Noise, residual: Array, time_s: Array) -> float:
    """Minus the logarithm of the likelihood, robust."""
    white = whitened(noise, residual, time_s)
    size = np.abs(white)
    rho = np.where(size <= HUBER, 0.5 * white**2, HUBER * size - 0.5 * HUBER**2)
    cost = float(rho.sum() + np.log(noise.sd()).sum())
    if noise.tau_s > 0.0:
        kept = np.exp(-np.diff(time_s) / noise.tau_s)
        cost += 0.5 * residual.shape[1] * float(np.log1p(-(kept**2)).sum())
    return cost
