"""Covariances of the best filter and the best smoother of a linear Gaussian system.

Source: Rauch, Tung and Striebel 1965, AIAA Journal 3, 1445.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEPS = 4000
"""Steps from `FIRST_VAR` after which a covariance counts as steady. The variance of a constant that
is seen only together with others goes on falling, as 1 over the steps."""
FIRST_VAR = 0.01
"""Variance of every state before the first step."""
PAD_STEPS = 200
"""Steps after a gap in which the covariance becomes steady again."""


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
    before = _predicted_late(system)
    after = measured(system, before)
    return after, _smoothed_early(_back(system, before, after), before, after)


def _predicted_late(system: System) -> Array:
    """P- after `STEPS`, by the composition of steps: the map of n steps is (A, G, H) in

        P-_n = H + A^T P- (I + G P-)^-1 A

    and that of one step has A = F^T, G = H^T R^-1 H, H = Q.

    Source: Anderson 1978, International Journal of Control 28, 295 (doubling).
    """
    information = system.rows.T @ (system.rows / system.variances[:, None])
    first = predicted(system, FIRST_VAR * np.eye(len(system.transition)))
    one = system.transition.T, information, system.process
    a, g, h = _repeated(_joined, one, STEPS - 1)
    late = h + a.T @ first @ np.linalg.solve(np.eye(len(first)) + g @ first, a)
    return np.asarray(0.5 * (late + late.T))


def _joined(late: tuple[Array, ...], early: tuple[Array, ...]) -> tuple[Array, ...]:
    """The map of two stretches of steps, one after the other (Redheffer's star product)."""
    (a, g, h), (a0, g0, h0) = late, early
    inner = np.linalg.solve(np.eye(len(a)) + g @ h0, np.hstack([a, g]))
    pass_, gain = inner[:, : len(a)], inner[:, len(a) :]
    return a0 @ pass_, g0 + a0 @ gain @ a0.T, h + a.T @ h0 @ pass_


def _smoothed_early(back: Array, before: Array, after: Array) -> Array:
    """P_s after `STEPS` of P_s <- P + G (P_s - P-) G^T from P_s = P, by the same composition."""
    one = back, after - back @ before @ back.T

    def joined(late: tuple[Array, ...], early: tuple[Array, ...]) -> tuple[Array, ...]:
        return late[0] @ early[0], late[1] + late[0] @ early[1] @ late[0].T

    g, c = _repeated(joined, one, STEPS)
    return np.asarray(g @ after @ g.T + c)


def _repeated(
    join: Callable[[tuple[Array, ...], tuple[Array, ...]], tuple[Array, ...]],
    one: tuple[Array, ...],
    count: int,
) -> tuple[Array, ...]:
    """A map repeated so often, by squaring."""
    whole: tuple[Array, ...] | None = None
    while count:
        if count & 1:
            whole = one if whole is None else join(whole, one)
        one, count = join(one, one), count >> 1
    assert whole is not None, "repeated at least once"
    return whole


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
