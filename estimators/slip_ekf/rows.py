"""Scalar updates that know an outlier from a motion."""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled
from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import RADIUS, V


@compiled
def innovation_var(p: Array, h: Array, r: float) -> float:
    """h P h^T + r."""
    n = len(h)
    total = r
    for i in range(n):
        if h[i] != 0.0:
            for j in range(n):
                total += h[i] * p[i, j] * h[j]
    return float(total)


@compiled
def take(x: Array, p: Array, h: Array, error: float, r: float, learns: int) -> None:
    """K = P h^T / S,  x <- x + K e,  P <- P - K S K^T, in place; P stays symmetric to the bit.

    The radius is learnt only where `learns` is 1. Elsewhere nothing tells it from slip but the
    linearisation, which changes with the slip and would feign it: its gain is zero and its
    variance stays (Schmidt's consider state).
    """
    n = len(x)
    ph = np.zeros(n)
    variance = r
    for j in range(n):
        if h[j] != 0.0:
            for i in range(n):
                ph[i] += p[i, j] * h[j]
    for i in range(n):
        variance += h[i] * ph[i]
    if not variance > 0.0:
        return
    kept = p[RADIUS, RADIUS]
    for i in range(n):
        gain = ph[i] / variance
        if i != RADIUS or learns:
            x[i] += gain * error
        for j in range(i, n):
            p[i, j] -= gain * ph[j]
            p[j, i] = p[i, j]
    if not learns:
        p[RADIUS, RADIUS] = kept


@compiled
def count(memory: Record, source: int, nis: float) -> None:
    """Keep the normalised innovations squared, so that a filter can be asked if it is honest."""
    memory.nis_sum[source] += nis
    memory.nis_count[source] += 1


@compiled
def grow(memory: Record, i: int, j: int, by: float) -> None:
    """Add to the covariance what the motion, not the model, has brought."""
    memory.cov[i, j] += by
    memory.grown[i, j] += by


@compiled
def gated(
    memory: Record,
    source: int,
    h: Array,
    error: float,
    r: float,
    epoch_ns: int,
    tuning: Record,
) -> int:
    """Take a speed unless it is an outlier; 1 if it was taken.

    Refused while e^2 > gate^2 (h P h^T + r), but not for longer than `patience`: what goes on is
    the truth, and then the speed's variance grows by e^2 first.
    """
    variance = innovation_var(memory.cov, h, r)
    nis = error * error / variance
    if nis > tuning.gate**2:
        memory.refused[source] += 1
        if memory.refused_ns[source] < 0:
            memory.refused_ns[source] = epoch_ns
        if (epoch_ns - memory.refused_ns[source]) * 1e-9 < tuning.patience:
            return 0
        grow(memory, V, V, error * error)
    else:
        count(memory, source, nis)
    memory.refused_ns[source] = -1
    take(memory.x, memory.cov, h, error, r, memory.raised)
    return 1


@compiled
def followed(
    memory: Record,
    source: int,
    state: int,
    below: int,
    dt: float,
    h: Array,
    error: float,
    r: float,
    gate: float,
) -> None:
    """Take a measurement of motion: where it surprises, the motion has changed.

    e^2 > gate^2 S:   P[state, state] grows by d until S = e^2 / gate^2,
                      and as the change came over the last dt, evenly, the state `below`, whose
                      rate it is, by d dt^2 / 4, and their covariance by d dt / 2
    """
    variance = innovation_var(memory.cov, h, r)
    nis = error * error / variance
    count(memory, source, nis)
    if nis > gate**2 and h[state] != 0.0:
        grown = (error * error / gate**2 - variance) / h[state] ** 2
        grow(memory, state, state, grown)
        if below != state:
            grow(memory, below, below, 0.25 * dt * dt * grown)
            grow(memory, state, below, 0.5 * dt * grown)
            grow(memory, below, state, 0.5 * dt * grown)
    take(memory.x, memory.cov, h, error, r, memory.raised)


@compiled
def restart(memory: Record, state: int, variance: float) -> None:
    """Count an axle's travel from here."""
    memory.cut[state] = 1
    memory.x[state] = 0.0
    memory.cov[state, :] = 0.0
    memory.cov[:, state] = 0.0
    memory.cov[state, state] = variance


@compiled
def shift(memory: Record, state: int, by: float) -> None:
    """Move a state's origin."""
    memory.x[state] += by
    memory.shift[state] += by
