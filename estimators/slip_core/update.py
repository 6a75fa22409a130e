"""The scalar update that every source shares, and how the covariance grows by surprises."""

from __future__ import annotations

import numpy as np

from estimators.kalman import Array
from estimators.slip_core.layout import RADIUS, SIZE
from twin.compute.compiled import law


@law
def variance(p: Array, h: Array, r: float) -> float:
    """S = H P H^T + r."""
    total = r
    for i in range(SIZE):
        if h[i] != 0.0:
            for j in range(SIZE):
                total += h[i] * p[i, j] * h[j]
    return float(total)


@law
def take(x: Array, p: Array, h: Array, error: float, r: float, learns: int) -> None:
    """K = P H^T / S,  x <- x + K e,  P <- P - K S K^T, in place; P stays symmetric to the bit.

    The radius is learnt only where `learns` is 1. Elsewhere nothing tells it from slip but the
    linearisation, which changes with the slip and would feign it: its gain is zero and its
    variance stays (Schmidt's consider state).
    """
    ph = np.zeros(SIZE)
    for j in range(SIZE):
        if h[j] != 0.0:
            for i in range(SIZE):
                ph[i] += p[i, j] * h[j]
    total = r
    for i in range(SIZE):
        total += h[i] * ph[i]
    if not total > 0.0:
        return
    kept = p[RADIUS, RADIUS]
    for i in range(SIZE):
        gain = ph[i] / total
        if i != RADIUS or learns:
            x[i] += gain * error
        for j in range(i, SIZE):
            p[i, j] -= gain * ph[j]
            p[j, i] = p[i, j]
    if not learns:
        p[RADIUS, RADIUS] = kept


@law
def grow(p: Array, way: Array, by: float) -> None:
    """One unknown of variance `by` that moves several states at once: P <- P + by way way^T."""
    for i in range(SIZE):
        if way[i] != 0.0:
            for j in range(SIZE):
                p[i, j] += by * way[i] * way[j]


@law
def restart(x: Array, p: Array, state: int, var: float) -> None:
    """A state that begins anew at zero."""
    x[state] = 0.0
    for i in range(SIZE):
        p[state, i] = p[i, state] = 0.0
    p[state, state] = var
