"""Covariances of the best filter and the best smoother of a linear Gaussian system.

Source: Rauch, Tung and Striebel 1965, AIAA Journal 3, 1445.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SETTLE_STEPS = 4000
"""No more steps than this until the covariance is steady."""
PAD_STEPS = 200
"""So many steps from a gap all is steady again."""


@dataclass(frozen=True, kw_only=True)
class System:
    """x' = F x + w, w ~ Q;  z = H x + noise of variance r, per step."""

    transition: Array
    process: Array
    rows: Array
    """Shape (measurements, states)."""
    variances: Array
    """Shape (measurements,)."""


def steady(system: System) -> tuple[Array, Array]:
    """Steady covariances of filter and smoother, (states, states); NaN where nothing is measured.

    P- = F P F^T + Q,  K = P- H^T (H P- H^T + R)^-1,  P = (I - K H) P-
    G  = P F^T (P-)^-1,  P_s = P + G (P_s - P-) G^T
    """
    if not len(system.rows):
        unknown = np.full(system.transition.shape, np.nan)
        return unknown, unknown
    after = np.eye(len(system.transition)) * 0.01
    before = after
    for _ in range(SETTLE_STEPS):
        last = after
        before = predicted(system, after)
        after = measured(system, before)
        if _settled(after, last, 0.0):
            break
    back = _back(system, before, after)
    smoothed = after
    for _ in range(SETTLE_STEPS):
        last = smoothed
        smoothed = after + back @ (smoothed - before) @ back.T
        if _settled(smoothed, last, 1e-14):
            break
    return after, smoothed


def _settled(now: Array, last: Array, floor: float) -> bool:
    """Whether no variance changed by more than a millionth; numpy's own test takes ten times it."""
    now, last = now.diagonal(), last.diagonal()
    return bool((np.abs(now - last) <= floor + 1e-6 * np.abs(last)).all())


def through(system: System, seen: NDArray[np.bool_], state: int) -> tuple[Array, Array]:
    """Variances of one state by filter and smoother, step for step, where rows come and go.

    Steady, except from where a row is missing to PAD_STEPS later, and for the smoother before.

    Args:
        system: all rows there are.
        seen: which of them are measured at each step, (n, measurements).
        state: the index of the state.

    Returns:
        Filter's and smoother's variances, (n,) each.
    """
    after, smoothed = steady(system)
    causal = np.full(len(seen), after[state, state])
    offline = np.full(len(seen), smoothed[state, state])
    missing = np.flatnonzero(~seen.all(axis=1))
    if not len(missing) or not len(system.rows):
        return causal, offline
    for some in np.split(missing, np.flatnonzero(np.diff(missing) > 2 * PAD_STEPS) + 1):
        first, last = max(some[0] - PAD_STEPS, 0), some[-1] + PAD_STEPS + 1
        within = slice(first, last)
        causal[within], offline[within] = _gap(system, seen[within], state, after, smoothed)
    return causal, offline


def _gap(
    system: System, seen: NDArray[np.bool_], state: int, after: Array, smoothed: Array
) -> tuple[Array, Array]:
    """The same from a steady filter to a steady smoother."""
    n = len(seen)
    befores, afters = np.empty((n, *after.shape)), np.empty((n, *after.shape))
    for k in range(n):
        befores[k] = predicted(system, after)
        after = afters[k] = measured(system, befores[k], seen[k])
    offline = np.empty(n)
    for k in range(n - 1, -1, -1):
        if k < n - 1:
            back = _back(system, befores[k + 1], afters[k])
            smoothed = afters[k] + back @ (smoothed - befores[k + 1]) @ back.T
        offline[k] = smoothed[state, state]
    return afters[:, state, state], offline


def predicted(system: System, after: Array) -> Array:
    """F P F^T + Q."""
    return np.asarray(system.transition @ after @ system.transition.T + system.process)


def measured(system: System, before: Array, seen: NDArray[np.bool_] | None = None) -> Array:
    """(I - K H) P- (I - K H)^T + K R K^T, with the rows that are seen."""
    rows, variances = system.rows, system.variances
    if seen is not None:
        rows, variances = rows[seen], variances[seen]
    if not len(rows):
        return before
    r = np.diag(variances)
    gain = np.linalg.solve(rows @ before @ rows.T + r, rows @ before).T
    shrink = np.eye(len(before)) - gain @ rows
    after = shrink @ before @ shrink.T + gain @ r @ gain.T
    return np.asarray(0.5 * (after + after.T))


def _back(system: System, before: Array, after: Array) -> Array:
    """P F^T (P-)^-1."""
    small = 1e-15 * np.eye(len(before))
    return np.asarray(np.linalg.solve(before + small, system.transition @ after).T)
