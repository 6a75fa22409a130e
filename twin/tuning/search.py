"""The noises under which a log is likeliest, and which of them the log can tell.

    maximise   sum_b l_b(x) - sum_k (x_k / prior_k)^2 / 2

x are logarithms of factors on what is assumed now, l_b the log density of the innovations in block
b. Innovations of a filter whose model is not exact are not independent, so nothing is concluded
from the curvature of l alone:

    cov x = H^-1 J H^-1,   H = -Hessian,   J = n cov_b(dl_b / dx)

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
"""Least change of the log density, over a factor of three either way, for a log to tell a noise."""
SPREAD = float(np.log(3.0))
ENOUGH = 0.05
"""The search ends where a step gains less log density than this."""
MOST_ITERATIONS = 25


@dataclass(frozen=True)
class Found:
    """Logarithms of factors, (k,), and which of them may differ from 0; NaN sd is not known."""

    x: Array
    sd: Array
    flat: NDArray[np.bool_]
    """The likelihood hardly depends on it."""
    starts: tuple[float, ...]
    """Log density that each search reached, with the prior's."""


def search(score: Score, prior_sd: Array, bound: Array, seed: int = 0) -> Found:
    """The likeliest noises, as far as a log tells them; the others stay at 0.

    Args:
        score: log densities by block.
        prior_sd: sd of each logarithm before the log is seen, (k,).
        bound: the most by which each may be off, (k,).
        seed: of the points where searches begin.
    """
    flat = _flat(score, bound)
    free = np.flatnonzero(~flat)
    x, sd = np.zeros(len(bound)), np.full(len(bound), np.nan)
    if not len(free):
        return Found(x, sd, flat, ())
    value = _Posterior(score, prior_sd)
    generator = np.random.default_rng(seed)
    drawn = [
        np.where(flat, 0.0, generator.uniform(-0.5, 0.5, len(x)) * bound) for _ in range(DRAWN)
    ]
    likeliest = sorted(drawn, key=value, reverse=True)[: STARTS - 1]
    ends = [_climb(value, start, free, bound) for start in (x, *likeliest)]
    reached = tuple(value(end) for end in ends)
    x = max(ends, key=value)
    told: set[int] = set()
    while len(free):
        sd = np.full(len(bound), np.nan)
        sd[free] = _sd(score, x, free, prior_sd)
        doubtful = [int(k) for k in free if k not in told and not abs(x[k]) > 2.0 * sd[k]]
        if not doubtful:
            break
        worst = min(doubtful, key=lambda k: abs(x[k]) / sd[k] if sd[k] > 0.0 else 0.0)
        rest = free[free != worst]
        without = np.where(np.arange(len(x)) == worst, 0.0, x)
        without = _climb(value, without, rest, bound) if len(rest) else without
        if mean(score(x) - score(without)).low > 0.0:
            told.add(worst)
        else:
            x, free = without, rest
    return Found(x, np.where(x == 0.0, np.nan, sd), flat, reached)


@dataclass(frozen=True)
class _Posterior:
    score: Score
    prior_sd: Array

    def __call__(self, x: Array) -> float:
        return float(self.score(x).sum() - 0.5 * np.sum((x / self.prior_sd) ** 2))


def _flat(score: Score, bound: Array) -> NDArray[np.bool_]:
    """Which noises hardly change the likelihood when they are a third or three times as large."""
    here = score(np.zeros(len(bound))).sum()
    flat = np.ones(len(bound), bool)
    for k in range(len(bound)):
        for way in (-SPREAD, SPREAD):
            x = np.zeros(len(bound))
            x[k] = np.clip(way, -bound[k], bound[k])
            flat[k] &= abs(score(x).sum() - here) < TELLS
    return flat


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
        spread = np.atleast_2d(np.cov(slope)) * slope.shape[1]
        return np.sqrt(np.diag(inverse @ spread @ inverse))
    level = np.abs(ways[:, 0]).argmax()  # the one that the likelihood tells least
    kept = np.arange(k) != level
    if kept.any():
        sd[kept] = _sd(score, x, free[kept], prior_sd)
    return sd
