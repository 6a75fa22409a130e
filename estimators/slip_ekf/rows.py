"""Scalar updates that know an outlier from a motion."""

from __future__ import annotations

import math

import numpy as np

from estimators.estimate import SLOW_MPS
from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import ACCEL_BIAS, RADIUS, REAR_TRAVEL, RIM_RATE, SKID, A, V, W
from estimators.slip_ekf.tuning import FROM_GNSS
from twin.compute.compiled import compiled

AGREES, HELD_UP_S = 1.0, 0.2
"""A ground speed within so many variances, so recently [s], speaks for the estimate that another
contradicts."""
SPUN_S = 0.2
"""Time in which a driver changes the speed of the wheels [s]."""
LEAN_SHARE, LEAN_S = 0.05, 1.0
"""Share of an innovation in their mean, and what time that makes for GNSS at 20 Hz [s]."""


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
def grow_evenly(memory: Record, low: int, high: int, by: float, dt: float) -> None:
    """White noise over the last dt that adds `by` to a rate's variance, and to what it is of."""
    grow(memory, high, high, by)
    grow(memory, low, low, dt * dt / 3.0 * by)
    grow(memory, low, high, 0.5 * dt * by)
    grow(memory, high, low, 0.5 * dt * by)


@compiled
def _grow_along(memory: Record, way: tuple[tuple[int, float], ...], by: float) -> None:
    """One unknown of variance `by` that moves several states at once: P <- P + by w w^T."""
    for i, along in way:
        for j, and_along in way:
            grow(memory, i, j, by * along * and_along)


@compiled
def doubt(memory: Record, error: float, since_s: float, towed: float) -> None:
    """A speed has been off by `error` for so long, and who agreed with the estimate is in doubt.

    By as much per time may the accelerometer be off, and, where `towed` is 1 and not 0, by as much
    of the speed the towed wheels.
    """
    skid = -towed * error / max(abs(memory.x[V]), SLOW_MPS)
    _grow_along(memory, ((V, error), (ACCEL_BIAS, -error / since_s), (SKID, skid)), 1.0)


@compiled
def lean(memory: Record, source: int, h: Array, error: float, r: float, gate: float) -> float:
    """How far a speed is off the same way for long, in sd of what white innovations would make.

    lean <- lean + (e / sqrt(S) - lean) / n         of variance 1 / (2 n - 1) for white e

    What is so far off that the gate refuses it does not count.
    """
    normalised = error / math.sqrt(innovation_var(memory.cov, h, r))
    if abs(normalised) < gate:
        memory.lean[source] += LEAN_SHARE * (normalised - memory.lean[source])
    return float(memory.lean[source] / math.sqrt(LEAN_SHARE / (2.0 - LEAN_SHARE)))


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

    Refused while e^2 > gate^2 (h P h^T + r), but not for longer than `patience`, or `trust` where
    another speed holds the estimate up: what goes on is the truth, and then the speed's variance
    grows by e^2 first.
    """
    variance = innovation_var(memory.cov, h, r)
    nis = error * error / variance
    refused_s = (epoch_ns - memory.refused_ns[source]) * 1e-9
    just_now = memory.refused_ns[source] >= 0 and refused_s < tuning.patience
    within = tuning.back * tuning.gate if just_now else tuning.gate
    if nis > within**2:
        memory.refused[source] += 1
        if memory.refused_ns[source] < 0:
            memory.refused_ns[source] = epoch_ns
        held_up = (epoch_ns - memory.agreed_ns) * 1e-9 < HELD_UP_S
        patience = tuning.trust if held_up else tuning.patience
        memory.conflict_mps[source] = 0.0 if held_up else abs(error)
        if (epoch_ns - memory.refused_ns[source]) * 1e-9 < patience:
            return 0
        doubt(
            memory, error, max(refused_s, patience), 1.0 if held_up and source == FROM_GNSS else 0.0
        )
    else:
        count(memory, source, nis)
        if nis < AGREES:
            memory.agreed_ns = epoch_ns
    memory.refused_ns[source] = -1
    memory.conflict_mps[source] = 0.0
    take(memory.x, memory.cov, h, error, r, memory.raised)
    return 1


@compiled
def surprise(
    memory: Record, source: int, h: Array, error: float, r: float, gate: float
) -> tuple[float, float]:
    """What the innovation's variance S lacks of e^2 where e^2 > gate^2 S, else 0; and e^2 / S."""
    variance = innovation_var(memory.cov, h, r)
    nis = error * error / variance
    count(memory, source, nis)
    surprised = error * error > gate**2 * variance
    return (float(error * error - variance) if surprised else 0.0), float(nis)


@compiled
def jolt(memory: Record, grown: float, dt: float, correlation: float) -> None:
    """Let the acceleration's variance grow by `grown`, and that of the wheels' with it.

    A sudden load takes the ground's speed and leaves the governed wheels theirs, as far as
    `correlation` says: dw' = (1 - c) da + noise of variance (1 - c^2) grown. When in the last dt
    the change came is not known: evenly.
    """
    kept, apart = 1.0 - correlation, grown * (1.0 - correlation**2)
    jolted = ((A, 1.0), (V, 0.5 * dt), (RIM_RATE, kept), (W, 0.5 * dt * kept))
    _grow_along(memory, jolted, grown)
    _grow_along(memory, ((V, 1.0), (W, kept)), dt * dt / 12.0 * grown)
    grow_evenly(memory, W, RIM_RATE, apart, dt)


@compiled
def spun(memory: Record, grown: float, dt: float) -> None:
    """The driven wheels turn faster or slower than thought: variance `grown` of the last travel.

    travel = w dt,   w = w' SPUN_S
    """
    gained = ((REAR_TRAVEL, 1.0), (W, 1.0 / dt), (RIM_RATE, 1.0 / (dt * SPUN_S)))
    _grow_along(memory, gained, grown)


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
) -> float:
    """Take a measurement of motion: where it surprises, the motion has changed. Returns e^2 / S.

    e^2 > gate^2 S:   P[state, state] grows by d until S = e^2,
                      and as the change came over the last dt, evenly, the state `below`, whose
                      rate it is, by d dt^2 / 4, and their covariance by d dt / 2
    """
    grown, nis = surprise(memory, source, h, error, r, gate)
    if grown > 0.0 and h[state] != 0.0:
        grown /= h[state] ** 2
        grow(memory, state, state, grown)
        if below != state:
            grow(memory, below, below, 0.25 * dt * dt * grown)
            grow(memory, state, below, 0.5 * dt * grown)
            grow(memory, below, state, 0.5 * dt * grown)
    take(memory.x, memory.cov, h, error, r, memory.raised)
    return nis


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
