"""What the population methods share: the unit cube, evaluation, the best so far, order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.optimisers.chance import State, uniform
from twin.compute.compiled import compiled, inlined

Array = NDArray[np.float64]
Function = Callable[[Array, Any], float]
"""function(x, given) -> value."""


class Result(NamedTuple):
    """What a minimiser found."""

    x: Array
    """The best vector evaluated, (n,)."""
    value: float
    """Its value."""
    evaluations: int
    """How often the function was called."""
    history: Array
    """The best value after the first population and after each iteration."""


class Best(NamedTuple):
    """The best position so far, in the unit cube; changed in place."""

    u: Array
    """Position, (n,)."""
    value: Array
    """Its value, (1,)."""


@compiled
def nowhere(n: int) -> Best:
    """The best before anything was evaluated."""
    return Best(np.full(n, 0.5), np.full(1, np.inf))


@inlined
def evaluate(
    function: Function, u: Array, low: Array, high: Array, given: Any, x: Array, best: Best
) -> float:
    """Value at a position of the unit cube, remembered if none was better.

    x = low + u (high - low)

    Args:
        function: what is minimised.
        u: position in [0, 1]^n.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        given: handed on to the function.
        x: room for the vector, (n,).
        best: the best so far, changed in place.
    """
    in_box(u, low, high, x)
    value = function(x, given)
    if value <= best.value[0]:
        best.value[0] = value
        for k in range(len(u)):
            best.u[k] = u[k]
    return value


@compiled
def in_box(u: Array, low: Array, high: Array, x: Array) -> None:
    """Write into x the vector of the box that stands at u in the unit cube, never beyond a face."""
    for k in range(len(u)):
        x[k] = min(max(low[k] + u[k] * (high[k] - low[k]), low[k]), high[k])


@compiled
def move(u: Array, velocity: Array, limit: float) -> None:
    """Limit a velocity, and step by it inside the unit cube; both changed in place, (n,)."""
    for k in range(len(u)):
        velocity[k] = min(max(velocity[k], -limit), limit)
        u[k] = min(max(u[k] + velocity[k], 0.0), 1.0)


@compiled
def random_points(count: int, n: int, rng: State) -> Array:
    """Uniform random points of the unit cube, (count, n)."""
    points = np.empty((count, n))
    for i in range(count):
        for k in range(n):
            points[i, k] = uniform(rng)
    return points


@compiled
def rank(values: Array, order: NDArray[np.int64], count: int) -> None:
    """Sort the first `count` rows that `order` names by rising value; ties keep their order."""
    for i in range(1, count):
        row, at = order[i], i
        while at > 0 and values[order[at - 1]] > values[row]:
            order[at] = order[at - 1]
            at -= 1
        order[at] = row


@compiled
def result(best: Best, low: Array, high: Array, evaluations: int, history: Array) -> Result:
    """The best so far as a vector of the box."""
    x = np.empty(len(low))
    in_box(best.u, low, high, x)
    return Result(x, best.value[0], evaluations, history)
