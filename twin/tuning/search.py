"""The noises under which a log is likeliest, and which of them it determines.

    maximise   sum_b l_b(x) - sum_k (x_k / prior_k)^2 / 2

x are logarithms of factors on what is assumed now, l_b the log density of the innovations in block
b. Innovations of a filter whose model is not exact are not independent, so nothing is concluded
from the curvature of l alone. A noise is moved if it is more than two sd away by

    cov x = H^-1 J H^-1,   H = -Hessian,   J = n cov_b(dl_b / dx) + diag(1 / prior^2)

and, where that is asked for, if the blocks, paired, are likelier with what is moved than without.

Source: Schweppe (1965), IEEE Trans. Inf. Theory 11, 61 (likelihood of innovations); White (1982),
Econometrica 50, 1, eq. (3.2) (covariance where the model is wrong).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.compute.mean import mean
from twin.tuning.likelihood import Score

Array = NDArray[np.float64]

STARTS, DRAWN = 3, 8
"""Searches, and random points of which the likeliest are where all but the first begin."""
STEP = 0.1
"""Step of finite differences in the logarithm: a tenth of the value."""
TELLS = 2.0
"""Least change of the log density, over a factor of three either way, for a noise to count."""
SPREAD = float(np.log(3.0))
SURE_SD = 2.0
"""A noise is changed only if its value is this many sd away from the present one."""
LEAST = float(np.log(1.1))
"""A noise that is right within a tenth stays."""
ENOUGH = 0.05
"""The search ends where a step gains less log density than this."""
MOST_ITERATIONS = 25


@dataclass(frozen=True, kw_only=True)
class Prior:
    """What is known of each noise before the log is seen: its logarithm is N(0, sd^2), bounded."""

    sd: Array
    bound: Array


@dataclass(frozen=True, kw_only=True)
class Found:
    """Logarithms of factors, (k,), and what is known of each."""

    x: Array
    sd: Array
    """NaN where it was not moved, or the likelihood is not curved there."""
    flat: NDArray[np.bool_]
    """The likelihood hardly depends on it, or it was not asked for."""
    starts: tuple[float, ...] = ()
    """Log density that each search reached, with the prior's."""


def search(
    score: Score, prior: Prior, asked: NDArray[np.bool_], before: Array, *, paired: bool, seed: int
) -> Found:
    """The likeliest noises; those that the log does not determine keep their values.

    Args:
        score: log densities by block.
        prior: of all noises.
        asked: which may be moved, (k,).
        before: where they are, (k,).
        paired: whether the blocks, as pairs, have to be likelier.
        seed: of the points where searches begin.
    """
    flat = ~asked | ~changes(score, prior, asked, before, TELLS)
    free = np.flatnonzero(~flat)
    unknown = np.full(len(before), np.nan)
    if not len(free):
        return Found(x=before, sd=unknown, flat=flat)
    value = _Posterior(score, prior.sd)
    x, starts = _highest(value, prior, before, free, seed)
    while len(free):
        sd = unknown.copy()
        sd[free] = _sd(score, x, free, prior.sd)
        moved = np.abs(x - before)
        away = np.where(moved > LEAST, moved, 0.0) / np.where(sd > 0.0, sd, np.inf)
        weakest = int(min(free, key=lambda k: away[k]))
        # where the likelihood is not curved, as beside a bound, the blocks alone tell
        sure = away[weakest] > SURE_SD or (
            paired and moved[weakest] > LEAST and np.isnan(sd[weakest])
        )
        if sure and not (paired and mean(score(x) - score(before)).low <= 0.0):
            return Found(x=x, sd=sd, flat=flat, starts=starts)
        free = free[free != weakest]
        rest = np.where(np.arange(len(x)) == weakest, before, x)
        x = _climb(value, rest, free, prior.bound) if len(free) else before
    return Found(x=before, sd=unknown, flat=flat, starts=starts)


def _highest(
    value: Callable[[Array], float], prior: Prior, before: Array, free: NDArray[np.int64], seed: int
) -> tuple[Array, tuple[float, ...]]:
    """The best end of several searches, and what each of them reached."""
    generator = np.random.default_rng(seed)
    drawn = np.tile(before, (DRAWN, 1))
    drawn[:, free] = generator.uniform(-0.5, 0.5, (DRAWN, len(free))) * prior.bound[free]
    likeliest = sorted(drawn, key=value, reverse=True)[: STARTS - 1]
    ends = [_climb(value, start, free, prior.bound) for start in (before, *likeliest)]
    return max(ends, key=value), tuple(value(end) for end in ends)


@dataclass(frozen=True)
class _Posterior:
    score: Score
    prior_sd: Array

    def __call__(self, x: Array) -> float:
        return float(self.score(x).sum() - 0.5 * np.sum((x / self.prior_sd) ** 2))


def changes(
    score: Score, prior: Prior, asked: NDArray[np.bool_], before: Array, tells: float
) -> NDArray[np.bool_]:
    """Which noises, a third or three times as large, change the log density by `tells` or more."""
    here = score(before).sum()
    found = np.zeros(len(before), bool)
    for k in np.flatnonzero(asked):
        for way in (-SPREAD, SPREAD):
            x = before.copy()
            x[k] = np.clip(x[k] + way, -prior.bound[k], prior.bound[k])
            found[k] |= abs(score(x).sum() - here) >= tells
    return found


def _climb(
    value: Callable[[Array], float], start: Array, free: NDArray[np.int64], bound: Array
) -> Array:
    """Uphill from a start, in the coordinates `free`."""
    from scipy.optimize import minimize  # late: slow to import

    def whole(part: Array) -> Array:
        x = start.copy()
        x[free] = part
        return x

    def downhill(part: Array) -> tuple[float, Array]:
        x = whole(part)
        steps = [STEP * np.eye(len(x))[k] for k in free]
        slope = np.array([(value(x + s) - value(x - s)) / (2.0 * STEP) for s in steps])
        here = value(x)
        return (-here, -slope) if np.isfinite(here) else (1e300, 0.0 * slope)

    scale = max(abs(value(start)), 1.0)
    found = minimize(
        downhill, start[free], jac=True, method="L-BFGS-B",
        bounds=[(-bound[k], bound[k]) for k in free],
        options={"maxiter": MOST_ITERATIONS, "ftol": ENOUGH / scale},
    )  # fmt: skip
    end = whole(found.x)
    return end if value(end) >= value(start) else start


def _sd(score: Score, x: Array, free: NDArray[np.int64], prior_sd: Array) -> Array:
    """sd of each free logarithm by the covariance above; NaN where the likelihood is not curved."""
    step = 1.5 * STEP
    unit = step * np.eye(len(x))[free]
    here = score(x)
    up, down = [score(x + u) for u in unit], [score(x - u) for u in unit]
    slope = np.array([(a - b) / (2.0 * step) for a, b in zip(up, down, strict=True)])  # (k, n)
    k = len(free)
    hessian = np.diag(1.0 / prior_sd[free] ** 2)
    for i in range(k):
        hessian[i, i] -= (up[i] + down[i] - 2.0 * here).sum() / step**2
        for j in range(i):
            both = score(x + unit[i] + unit[j]) + score(x - unit[i] - unit[j]) + 2.0 * here
            mixed = (both - up[i] - up[j] - down[i] - down[j]).sum() / (2.0 * step**2)
            hessian[i, j] -= mixed
            hessian[j, i] -= mixed
    curved, ways = np.linalg.eigh(hessian)
    sd = np.full(k, np.nan)
    if curved[0] > 0.0:
        inverse = ways / curved @ ways.T
        spread = np.atleast_2d(np.cov(slope)) * slope.shape[1] + np.diag(1.0 / prior_sd[free] ** 2)
        return np.sqrt(np.diag(inverse @ spread @ inverse))
    level = np.abs(ways[:, 0]).argmax()  # the one that the likelihood tells least
    kept = np.arange(k) != level
    if kept.any():
        sd[kept] = _sd(score, x, free[kept], prior_sd)
    return sd
