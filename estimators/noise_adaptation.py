"""Noise covariances from innovations: predicted against actual mean square, by search in a box.

The search looks for q = diag(Q) of both blocks and r = diag(R) of the four measured rows,

    x = [q_v, q_a, q_j, q_w, q_aw, q_jw, r_v, r_a, r_w, r_aw]

so that the mean square of the innovation which the filter predicts (FPMSE) equals the mean square
of the actual innovations (TPMSE). The fitness depends only on four sums, each of an element of q
and an element of r. It does not depend on q_j and q_jw, nor on the shares of q and r in a sum. The
point of the box at which the search ends decides these.

v, a, j are speed, acceleration and jerk of the ground; w, aw, jw those of the driven wheels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

from estimators.optimisers import mayfly, pso
from estimators.optimisers.chance import State
from estimators.optimisers.improved_mayfly import good_point_set
from estimators.optimisers.population import random_points
from twin.compute.compiled import compiled

Array = NDArray[np.float64]

ROWS = 4
"""Measured rows: speed and acceleration of the ground, speed and acceleration of the wheels."""
SOUGHT = 10
PROCESS = (0, 1, 3, 4)
"""Index in x of each row's process variance; its measurement variance has the index 6 + row."""
PSO, MAYFLY, IMPROVED_MAYFLY = range(3)
VARIANCE, DEVIATION, LOGARITHM = range(3)
"""Encoding of x: variances, standard deviations, natural logarithms of variances."""
BUDGET = 1300
"""Evaluations of a search: 20 + 20 mayflies and 20 generations."""

GAP, COUPLING, STEPS, SEEN, ENCODING = 0, 4, 10, 11, 15
"""Index at which each part of a problem begins: the diagonal of FPMSE - TPMSE without q and r (4),
its elements above the diagonal (6), the number n of 0.02 s steps that q acts for, 1 for each
measured row (4), the encoding of x."""
PROBLEM = 16


@compiled
def mean_square(innovations: Array) -> Array:
    """TPMSE: C_ij = mean of e_i e_j over the steps that measured both, 0 if none did.

    Args:
        innovations: one row per step, (steps, 4), NaN where not measured.

    Source: IMA-PKF paper (INMATEH 77-13), right-hand side of eq. (18).
    """
    sums, counts = np.zeros((ROWS, ROWS)), np.zeros((ROWS, ROWS))
    for step in range(len(innovations)):
        accumulate(innovations[step], sums, counts)
    return mean_of(sums, counts)


@compiled
def accumulate(innovation: Array, sums: Array, counts: Array) -> None:
    """Add e e^T, (4, 4), and 1 to the count of each pair that was measured."""
    for i in range(ROWS):
        for j in range(ROWS):
            product = innovation[i] * innovation[j]
            if math.isfinite(product):
                sums[i, j] += product
                counts[i, j] += 1.0


@compiled
def mean_of(sums: Array, counts: Array) -> Array:
    """Sums over counts, 0 where nothing was counted. Shapes (4, 4)."""
    mean = np.zeros((ROWS, ROWS))
    for i in range(ROWS):
        for j in range(ROWS):
            if counts[i, j] > 0.0:
                mean[i, j] = sums[i, j] / counts[i, j]
    return mean


@compiled
def problem(ground: Array, wheel: Array, tpmse: Array, steps: float, encoding: int) -> Array:
    """What `fitness` needs beside the candidate, shape (16,).

    Args:
        ground: A P A^T of the ground's block, without Q, (3, 3).
        wheel: the same of the wheels' block, (3, 3).
        tpmse: C, (4, 4); a row whose C_ii is 0 was not measured.
        steps: n, the number of 0.02 s steps that Q acts for.
        encoding: VARIANCE, DEVIATION or LOGARITHM.
    """
    given = np.zeros(PROBLEM)
    given[STEPS], given[ENCODING] = steps, encoding
    at = COUPLING
    for i in range(ROWS):
        given[SEEN + i] = 1.0 if tpmse[i, i] > 0.0 else 0.0
        block = ground if i < 2 else wheel
        if given[SEEN + i] > 0.0:
            given[GAP + i] = block[i % 2, i % 2] - tpmse[i, i]
        for j in range(i + 1, ROWS):
            given[at] = -tpmse[i, j]
            if i % 2 == 0 and j == i + 1 and tpmse[i, i] > 0.0 and tpmse[j, j] > 0.0:
                given[at] += block[0, 1]
            at += 1
    return given


@compiled
def fitness(x: Array, given: Array) -> float:
    """The 2-norm of FPMSE - TPMSE for a candidate, over the measured rows.

    f = || H (A P A^T + n Q) H^T + R - C ||_2

    A is the transition matrix over the n steps of 0.02 s since the last update, and P the
    covariance after that update. H has a row per measurement. Q and R are diagonal. C is TPMSE.

    Args:
        x: the candidate, (10,), encoded: variances, their roots or their logarithms.
        given: output of `problem`, (16,).

    Source: IMA-PKF paper (INMATEH 77-13), eq. (18)-(20), with the four rows of H that are not zero.
    """
    above = (given[4], given[5], given[6], given[7], given[8], given[9])
    d = (_gap(x, given, 0), _gap(x, given, 1), _gap(x, given, 2), _gap(x, given, 3))
    return spectral_norm(d, above)


@compiled
def _gap(x: Array, given: Array, row: int) -> float:
    """Diagonal element of FPMSE - TPMSE."""
    if given[SEEN + row] == 0.0:
        return 0.0
    q, r = variance(x[PROCESS[row]], given), variance(x[6 + row], given)
    return float(given[GAP + row] + given[STEPS] * q + r)


@compiled
def variance(x: float, given: Array) -> float:
    """The variance that an element of a candidate encodes."""
    if given[ENCODING] == DEVIATION:
        return x * x
    return exp(x) if given[ENCODING] == LOGARITHM else x


@compiled
def spectral_norm(d: Sequence[float], above: Sequence[float]) -> float:
    """Largest |eigenvalue| of a symmetric 4 x 4 matrix.

    With the mean m of the diagonal taken off, det(l I - M) = l^4 + c2 l^2 - c3 l + c4; its largest
    root, and by l -> -l its smallest, by Newton's method from sqrt(-3/2 c2), which no root exceeds
    and from where it descends without passing (all roots are real).

    Args:
        d: diagonal, (4,).
        above: elements above it, 01 02 03 12 13 23, (6,).
    """
    m = 0.25 * (d[0] + d[1] + d[2] + d[3])
    a, b, c, e = d[0] - m, d[1] - m, d[2] - m, d[3] - m
    p, q, r, s, t, u = above[0], above[1], above[2], above[3], above[4], above[5]
    pp, qq, rr, ss, tt, uu = p * p, q * q, r * r, s * s, t * t, u * u
    c2 = a * b + c * e + (a + b) * (c + e) - pp - qq - rr - ss - tt - uu
    c3 = (
        a * b * (c + e) + c * e * (a + b)
        - a * (ss + tt + uu) - b * (qq + rr + uu) - c * (pp + rr + tt) - e * (pp + qq + ss)
        + 2.0 * (p * q * s + p * r * t + q * r * u + s * t * u)
    )  # fmt: skip
    c4 = (
        (a * b - pp) * (c * e - uu) - a * c * tt - a * e * ss - b * c * rr - b * e * qq
        + rr * ss + qq * tt - 2.0 * q * r * s * t
        + 2.0 * (a * s * t * u + b * q * r * u + c * p * r * t + e * p * q * s)
        - 2.0 * p * u * (q * t + r * s)
    )  # fmt: skip
    bound = sqrt(max(-1.5 * c2, 0.0))
    if m < 0.0:
        m, c3 = -m, -c3  # of -M
    top = _largest(bound, c2, c3, c4)
    if top + 2.0 * m >= bound:
        return m + top
    return max(m + top, _largest(bound, c2, -c3, c4) - m)


@compiled
def _largest(bound: float, c2: float, c3: float, c4: float) -> float:
    root = bound
    for _ in range(60):  # a double root halves its error each time
        slope = (4.0 * root * root + 2.0 * c2) * root - c3
        if slope <= 0.0:
            break
        step = (((root * root + c2) * root - c3) * root + c4) / slope
        root -= step
        if step <= 1e-10 * bound:
            break
    return root


@compiled
def search(
    method: int, given: Array, low: Array, high: Array, budget: int, rng: State, found: Array
) -> float:
    """Search the box for the covariances of one observer. Returns the fitness.

    Args:
        method: PSO, MAYFLY or IMPROVED_MAYFLY.
        given: output of `problem`, (16,).
        low: lower corner of the box, (10,), in the problem's encoding.
        high: upper corner, (10,).
        budget: largest number of evaluations.
        rng: state of `chance`, changed in place.
        found: output, the variances found, (10,).
    """
    if method == PSO:
        best = pso.minimise(fitness, low, high, budget, rng, given)
    else:  # one call for both kinds of mayflies halves the time to compile
        improved, count = method == IMPROVED_MAYFLY, 2 * mayfly.COUNT
        start = good_point_set(count, SOUGHT) if improved else random_points(count, SOUGHT, rng)
        best = mayfly.evolve(fitness, start, improved, low, high, budget, rng, given)
    for k in range(SOUGHT):
        found[k] = variance(best.x[k], given)
    return best.value
