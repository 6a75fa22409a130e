"""The scalar update that every source shares, and how the covariance grows by surprises."""

from __future__ import annotations

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import SIZE
from twin.compute.compiled import array_law


@array_law
def variance(p: Array, h: Array, r: float) -> float:
    """S = H P H^T + r."""
    total = r
    for i in range(SIZE):
        if h[i] != 0.0:
            for j in range(SIZE):
                total += h[i] * p[i, j] * h[j]
    return float(total)


@array_law
def take(memory: Record, h: Array, error: float, r: float) -> None:
    """K = P H^T / S,  x <- x + K e,  P <- P - K S K^T, in place; P stays symmetric to the bit.

    Args:
        memory: record whose `x` and `p` are updated; a smoother has it keep what was gained.
        h: row of the measurement, (SIZE,).
        error: innovation.
        r: variance of the measurement.
    """
    x, p = memory.x, memory.p
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
    for i in range(SIZE):
        gain = ph[i] / total
        x[i] += gain * error
        for j in range(i, SIZE):
            p[i, j] -= gain * ph[j]
            p[j, i] = p[i, j]
    if memory.keeps:
        for i in range(SIZE):
            memory.gained[i] += ph[i] / total * error
            for j in range(SIZE):
                memory.lost[i, j] += ph[i] / total * ph[j]


@array_law
def grow(p: Array, direction: Array, by: float) -> None:
    """One unknown of variance `by` that moves several states at once: P <- P + by d d^T."""
    for i in range(SIZE):
        if direction[i] != 0.0:
            for j in range(SIZE):
                p[i, j] += by * direction[i] * direction[j]


@array_law
def restart(memory: Record, state: int, var: float) -> None:
    """A state that begins anew at zero."""
    memory.x[state] = 0.0
    for i in range(SIZE):
        memory.p[state, i] = memory.p[i, state] = 0.0
    memory.p[state, state] = var
    memory.cut[state] = 1
