"""The improved mayfly algorithm: a good point set to start from, and the leader seen in a lens."""

from __future__ import annotations

from math import cos, floor, pi
from typing import Any

import numpy as np
from numpy.random import Generator

from estimators.compiled import compiled
from estimators.optimisers.mayfly import COUNT, PER_GENERATION, Task, hatch, live
from estimators.optimisers.population import Array, Function, Result, evaluate, nowhere, result

ETA_MIN, ETA_MAX = 0.5, 2.0
"""Range of the lens's scale; the paper prints none. 1 mirrors, 2 halves the distance to the middle."""
CHAOS = 4.0
"""r of the logistic map."""


@compiled
def minimise(
    function: Function, low: Array, high: Array, budget: int, rng: Generator, given: Any = ()
) -> Result:
    """Minimise by the mayfly algorithm with a good point set, lens opposition and greedy choice.

    After each generation the leader's image in the lens is evaluated and taken if it is no worse:
    x* where f(x) >= f(x*), else x. The scale is eta_min + (eta_max - eta_min) c_t with the
    logistic map c_t+1 = 4 c_t (1 - c_t).

    Args:
        function: compiled function(x, given) -> value.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        budget: most evaluations; at least 40.
        rng: source of chance.
        given: handed on to the function.

    Source: IMA-PKF paper (INMATEH 77-13), eq. (12)-(16); the rest as `mayfly`.
    """
    n = len(low)
    task, best = Task(low, high, given, np.empty(n)), nowhere(n)
    males, females = hatch(function, good_point_set(2 * COUNT, n), task, best)
    generations = max((budget - 2 * COUNT) // (PER_GENERATION + 1), 0)
    history = np.empty(generations + 1)
    history[0] = best.value[0]
    chaos, image = 0.1 + 0.1 * rng.random(), np.empty(n)  # away from 0, 1/4, 1/2, 3/4, 1
    for generation in range(generations):
        live(function, males, females, generation, task, best, rng)
        lens_image(best.u, ETA_MIN + (ETA_MAX - ETA_MIN) * chaos, image)
        evaluate(function, image, low, high, given, task.x, best)
        chaos = CHAOS * chaos * (1.0 - chaos)
        history[generation + 1] = best.value[0]
    evaluations = 2 * COUNT + (PER_GENERATION + 1) * generations
    return result(best, low, high, evaluations, history)


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
def lens_image(u: Array, eta: float, image: Array) -> None:
    """Write the image of a position of the unit cube in a lens at its middle.

    x* = 1/2 + 1 / (2 eta) - x / eta,   clipped to the cube (eta < 1 leaves it)

    Source: IMA-PKF paper, eq. (14), with lb = 0 and ub = 1.
    """
    for k in range(len(u)):
        image[k] = min(max(0.5 + 0.5 / eta - u[k] / eta, 0.0), 1.0)


@compiled
def _is_prime(number: int) -> bool:
    for divisor in range(2, number):
        if divisor * divisor > number:
            break
        if number % divisor == 0:
            return False
    return number > 1
