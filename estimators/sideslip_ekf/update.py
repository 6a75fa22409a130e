"""The scalar update that every source shares, and what grows or cuts a covariance."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array
from estimators.sideslip_ekf.layout import SIZE
from twin.compute.compiled import array_law


@array_law
def take(x: Array, p: Array, h: Array, error: float, r: float, gate: float) -> float:
    """K = P H^T / S,  x <- x + K e,  P <- P - K S K^T, in place; P stays symmetric to the bit.

    An error beyond the gate moves the state no further than one at it: its variance r grows until
    e^2 = gate^2 S (Huber 1964). So nothing wrong moves much, and nothing right is shut out.

    Returns:
        e^2 / S with the variance that was given.
    """
    ph = np.zeros(SIZE)
    for j in range(SIZE):
        if h[j] != 0.0:
            by = h[j]
            for i in range(SIZE):
                ph[i] += p[i, j] * by
    total = r
    for i in range(SIZE):
        total += h[i] * ph[i]
    if not (total > 0.0 and math.isfinite(error)):
        return 0.0
    nis = error**2 / total
    if nis > gate**2:
        total = error**2 / gate**2
    for i in range(SIZE):
        gain = ph[i] / total
        x[i] += gain * error
        for j in range(i, SIZE):
            p[i, j] -= gain * ph[j]
            p[j, i] = p[i, j]
    return nis


@array_law
def variance(p: Array, h: Array) -> float:
    """H P H^T."""
    total = 0.0
    for i in range(SIZE):
        if h[i] != 0.0:
            for j in range(SIZE):
                total += h[i] * p[i, j] * h[j]
    return float(total)


@array_law
def restart(x: Array, p: Array, state: int, mean: float, var: float) -> None:
    """A state that begins anew and knows nothing of the others."""
    x[state] = mean
    for i in range(SIZE):
        p[state, i] = p[i, state] = 0.0
    p[state, state] = var
