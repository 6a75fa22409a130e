"""The improved mayfly algorithm: a good point set to start from, and the leader seen in a lens."""

from __future__ import annotations

from math import cos, floor, pi
from typing import Any

import numpy as np

from estimators.optimisers.chance import State
from estimators.optimisers.mayfly import COUNT, evolve
from estimators.optimisers.population import Array, Function, Result
from twin.compute.compiled import compiled, inlined


@inlined
def minimise(
    function: Function, low: Array, high: Array, budget: int, rng: State, given: Any = ()
) -> Result:
    """Minimise by the mayfly algorithm with a good point set, lens opposition and greedy choice.

    After each generation the leader's image in the lens is evaluated and taken if it is no worse:
    x* where f(x) >= f(x*), else x.

    Args:
        function: compiled function(x, given) -> value.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        budget: most evaluations; at least 40.
        rng: state of `chance`, changed in place.
        given: handed on to the function.

    Source: IMA-PKF paper (INMATEH 77-13), eq. (12)-(16); the rest as `mayfly`.
    """
    start = good_point_set(2 * COUNT, len(low))
    return evolve(function, start, True, low, high, budget, rng, given)


@compiled
def good_point_set(count: int, n: int) -> Array:
    """Points of low discrepancy in the unit cube.

    u_ik = frac(i r_k),  r_k = 2 cos(2 pi k / p),  p the smallest prime >= 2 n + 3

    Returns:
        Points i = 1 .. count, (count, n).

    Source: Hua and Wang (1981), Applications of Number Theory to Numerical Analysis; the cyclotomic
    field's good point.
    """
    prime = 2 * n + 3
    while not _is_prime(prime):
        prime += 1
    points = np.empty((count, n))
    for k in range(n):
        step = 2.0 * cos(2.0 * pi * (k + 1) / prime)
        for i in range(count):
            points[i, k] = (i + 1) * step - floor((i + 1) * step)
    return points


@compiled
def _is_prime(number: int) -> bool:
    for divisor in range(2, number):
        if divisor * divisor > number:
            break
        if number % divisor == 0:
            return False
    return number > 1
