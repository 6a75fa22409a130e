"""Particle swarm with constriction."""

from __future__ import annotations

from typing import Any

import numpy as np

from estimators.optimisers.chance import State, uniform
from estimators.optimisers.population import (
    Array,
    Function,
    Result,
    evaluate,
    move,
    nowhere,
    random_points,
    result,
)
from twin.compute.compiled import inlined

PARTICLES = 40
INERTIA, COGNITIVE, SOCIAL = 0.7298, 1.49618, 1.49618
"""Constriction 0.7298 with c1 = c2 = 2.05 (Clerc and Kennedy 2002), multiplied out."""
LIMIT = 0.5
"""Largest velocity, of the box's width: half of it (Eberhart and Shi 2000 limit to its whole)."""


@inlined
def minimise(
    function: Function, low: Array, high: Array, budget: int, rng: State, given: Any = ()
) -> Result:
    """Minimise by a particle swarm with a global best.

    v <- w v + c1 r1 (p - u) + c2 r2 (g - u),   u <- clip(u + v, 0, 1)

    r1, r2 uniform in [0, 1] per coordinate; p the particle's own best, g the swarm's. Everything
    in the unit cube.

    Args:
        function: compiled function(x, given) -> value.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        budget: most evaluations; at least 40.
        rng: source of chance.
        given: handed on to the function.

    Source: Clerc and Kennedy (2002), IEEE Trans. Evol. Comput. 6, 58.
    """
    n = len(low)
    best, x = nowhere(n), np.empty(n)
    u, v = random_points(PARTICLES, n, rng), np.zeros((PARTICLES, n))
    own, own_value = u.copy(), np.empty(PARTICLES)
    for i in range(PARTICLES):
        own_value[i] = evaluate(function, u[i], low, high, given, x, best)
    iterations = max(budget // PARTICLES - 1, 0)
    history = np.empty(iterations + 1)
    history[0] = best.value[0]
    for iteration in range(iterations):
        for i in range(PARTICLES):
            for k in range(n):
                v[i, k] = (
                    INERTIA * v[i, k]
                    + COGNITIVE * uniform(rng) * (own[i, k] - u[i, k])
                    + SOCIAL * uniform(rng) * (best.u[k] - u[i, k])
                )
            move(u[i], v[i], LIMIT)
            value = evaluate(function, u[i], low, high, given, x, best)
            if value < own_value[i]:
                own_value[i] = value
                own[i] = u[i]
        history[iteration + 1] = best.value[0]
    return result(best, low, high, PARTICLES * (iterations + 1), history)
