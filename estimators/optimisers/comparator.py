"""Differential evolution from scipy: what a well-kept library reaches with the same budget."""

from __future__ import annotations

from typing import Any

import numpy as np

from estimators.optimisers.chance import State
from estimators.optimisers.population import Array, Function, Result

POPULATION = 40


def minimise(
    function: Function, low: Array, high: Array, budget: int, rng: State, given: Any = ()
) -> Result:
    """Minimise by differential evolution, best/1/bin with dither, as scipy has it by default.

    Args:
        function: function(x, given) -> value, compiled or not.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        budget: most evaluations; at least 40.
        rng: source of chance.
        given: handed on to the function.

    Source: Storn and Price (1997), J. Global Optim. 11, 341; `scipy.optimize`.
    """
    from scipy.optimize import Bounds, differential_evolution  # late: slow to import

    generator = np.random.default_rng([int(word) for word in rng])
    rng[:] = generator.integers(1, 2**64, size=4, dtype=np.uint64)
    history: list[float] = []
    best = np.inf

    def value_at(x: Array) -> float:
        nonlocal best
        value = function(x, given)
        if value < best:
            best = value
        history.append(best)
        return value

    found = differential_evolution(
        value_at,
        Bounds(low, high),
        maxiter=max(budget // POPULATION - 1, 0),
        init=low + generator.random((POPULATION, len(low))) * (high - low),
        polish=False,
        tol=0.0,
        rng=generator,
    )
    by_iteration = np.array(history)[POPULATION - 1 :: POPULATION]
    return Result(np.asarray(found.x), float(found.fun), len(history), by_iteration)
