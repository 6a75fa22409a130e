"""The few lines of Kalman filtering that the filters here share, compiled.

A channel is a mean `x` (n,) and a covariance `p` (n, n), changed in place. Measurements are scalar
and taken one after another, which for independent noises is the joint update exactly.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import compiled

Array = NDArray[np.float64]
UNSURE = 0.2
"""Above this sd of w - v over the larger speed, slip is no line of the speeds."""
Record = Any
"""One element of a structured array, as compiled code sees it: fields by name."""


@compiled
def predict(x: Array, p: Array, f: Array, q: Array) -> None:
    """Carry a channel through one step.

    x <- F x
    P <- F P F^T + Q

    Args:
        x: mean, (n,), changed in place.
        p: covariance, (n, n), changed in place.
        f: transition over the step, (n, n).
        q: process covariance over the step, (n, n).
    """
    n = len(x)
    fx = np.zeros(n)
    fp = np.zeros((n, n))
    for i in range(n):
        for k in range(n):
            fx[i] += f[i, k] * x[k]
            for j in range(n):
                fp[i, j] += f[i, k] * p[k, j]
    for i in range(n):
        x[i] = fx[i]
        for j in range(n):
            total = q[i, j]
            for k in range(n):
                total += fp[i, k] * f[j, k]
            p[i, j] = total


@compiled
def correct(x: Array, p: Array, h: Array, z: float, r: float) -> tuple[float, float]:
    """Take one scalar measurement; a NaN is skipped.

    e = z - h x,   S = h P h^T + r,   K = P h^T / S
    x <- x + K e,  P <- P - K S K^T

    Args:
        x: mean, (n,), changed in place.
        p: covariance, (n, n), changed in place.
        h: row of the measurement, (n,).
        z: what was measured.
        r: its variance.

    Returns:
        Innovation e and its variance S; NaN if the measurement was skipped.
    """
    n = len(x)
    if not (math.isfinite(z) and math.isfinite(r)):
        return np.nan, np.nan
    ph = np.zeros(n)
    innovation, variance = z, r
    for i in range(n):
        innovation -= h[i] * x[i]
        for j in range(n):
            ph[i] += p[i, j] * h[j]
        variance += h[i] * ph[i]
    if not variance > 0.0:
        return np.nan, np.nan
    for i in range(n):
        x[i] += ph[i] * innovation / variance
        for j in range(n):
            p[i, j] -= ph[i] * ph[j] / variance
    return innovation, variance


@compiled
def update(x: Array, p: Array, h: Array, z: float, r: float) -> float:
    """`correct`, and the normalised innovation squared e^2 / S; NaN if there was none."""
    innovation, variance = correct(x, p, h, z, r)
    return innovation * innovation / variance


@compiled
def slip_and_sd(
    wheel: float, ground: float, wheel_var: float, ground_var: float, covariance: float
) -> tuple[float, float]:
    """Slip and its standard deviation by the delta method.

    s = (w - v) / m,   m = max(|w|, |v|, 0.05 m/s)
    var s = g_w^2 P_ww + 2 g_w g_v P_wv + g_v^2 P_vv,   g = ds/d(w, v)

    Near rest slip saturates: at s = -1, wheels that stand, it does not change with v, however
    little v is known. Where the sd of w - v is above a fifth of m, the variance is therefore at
    least var(w - v) / m^2.

    Args:
        wheel: theoretical speed w [m/s].
        ground: actual speed v [m/s].
        wheel_var: P_ww [m2/s2].
        ground_var: P_vv [m2/s2].
        covariance: P_wv [m2/s2].
    """
    scale = max(abs(wheel), abs(ground), 0.05)
    slip = (wheel - ground) / scale
    by_wheel, by_ground = 1.0 / scale, -1.0 / scale
    if scale == abs(wheel):
        by_wheel -= slip / wheel
    elif scale == abs(ground):
        by_ground -= slip / ground
    variance = (
        by_wheel**2 * wheel_var
        + 2.0 * by_wheel * by_ground * covariance
        + by_ground**2 * ground_var
    )
    apart = (wheel_var - 2.0 * covariance + ground_var) / scale**2
    if apart > UNSURE**2:
        variance = max(variance, apart)
    return slip, math.sqrt(max(variance, 0.0))
