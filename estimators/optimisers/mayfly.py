"""The mayfly algorithm: males dance around the best, females follow the males of their rank."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.optimisers.chance import State, uniform
from estimators.optimisers.opposition import lens_image, next_chaos, scale
from estimators.optimisers.population import (
    Array,
    Best,
    Function,
    Result,
    evaluate,
    move,
    nowhere,
    random_points,
    rank,
    result,
)
from twin.compute.compiled import compiled, inlined

MALE, FEMALE = 0, 1
COUNT = 20
"""Males, and as many females."""
PAIRS = 10
"""Ranks that mate, two offspring each."""
SIZE = COUNT + PAIRS + 1
"""Rows of a sex: the living, and room for offspring and a mutant."""
PER_GENERATION = 2 * SIZE
"""Evaluations in a generation: females, males, offspring, one mutant of each sex."""
GRAVITY = 0.8
OWN, LEADER, MATE = 1.0, 1.5, 1.5
"""Attraction to a male's own best (a1), to the best of all (a2), of a female to her male (a3)."""
SIGHT = 2.0
"""beta in exp(-beta r^2)."""
DANCE, DANCE_DAMPING = 5.0, 0.8
FLIGHT, FLIGHT_DAMPING = 1.0, 0.99
LIMIT = 0.1
"""Largest velocity, and largest mutation, of the box's width."""
OVERSHOOT = 0.4
"""Offspring lie up to this much beyond their parents."""


class Swarm(NamedTuple):
    """Males [0] and females [1] with room for their young; arrays changed in place."""

    u: Array
    """Positions in the unit cube, (2, SIZE, n)."""
    v: Array
    """Velocities, as positions."""
    value: Array
    """Values, (2, SIZE)."""
    own: Array
    """Best position of each so far, as positions."""
    own_value: Array
    """Its value."""
    order: NDArray[np.int64]
    """Row of each rank, (2, SIZE): COUNT living ones by rising value, then rows that are free."""


@inlined
def minimise(
    function: Function, low: Array, high: Array, budget: int, rng: State, given: Any = ()
) -> Result:
    """Minimise by the mayfly algorithm from uniform random positions.

    Args:
        function: compiled function(x, given) -> value.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        budget: most evaluations; at least 40.
        rng: state of `chance`, changed in place.
        given: handed on to the function.

    Source: Zervoudakis and Tsafarakis (2020), Comput. Ind. Eng. 145, 106559; constants, distance
    per coordinate and overshooting offspring as in the first author's Python code. The leader is
    the best of either sex; everything happens in the unit cube, where exp(-beta r^2) has a meaning.
    """
    start = random_points(2 * COUNT, len(low), rng)
    return evolve(function, start, False, low, high, budget, rng, given)


@inlined
def evolve(
    function: Function,
    start: Array,
    lens: bool,
    low: Array,
    high: Array,
    budget: int,
    rng: State,
    given: Any,
) -> Result:
    """Let mayflies that start at given positions evolve.

    Args:
        start: males' positions in the unit cube, then females', (2 COUNT, n).
        lens: whether the leader's image in a lens is tried after each generation.
        function: as in `minimise`, like all the others.
    """
    x, best = np.empty(len(low)), nowhere(len(low))
    swarm, chaos = _hatch(start), 0.1 + 0.1 * uniform(rng)  # away from 0, 1/4, 1/2, 3/4, 1
    per_generation = PER_GENERATION + (1 if lens else 0)
    generations = max((budget - 2 * COUNT) // per_generation, 0)
    history = np.empty(generations + 1)
    _settle(function, swarm, 0, COUNT, low, high, given, x, best)
    history[0] = best.value[0]
    for generation in range(generations):
        _fly(swarm, generation, best, rng)
        _settle(function, swarm, 0, COUNT, low, high, given, x, best)
        _breed(swarm, rng)
        _settle(function, swarm, COUNT, SIZE, low, high, given, x, best)
        if lens:
            image = lens_image(best.u, scale(chaos))
            evaluate(function, image, low, high, given, x, best)
            chaos = next_chaos(chaos)
        history[generation + 1] = best.value[0]
    return result(best, low, high, 2 * COUNT + per_generation * generations, history)


@compiled
def _hatch(start: Array) -> Swarm:
    n = start.shape[1]
    u, order = np.zeros((2, SIZE, n)), np.empty((2, SIZE), np.int64)
    value, own_value = np.full((2, SIZE), np.inf), np.full((2, SIZE), np.inf)
    for sex in range(2):
        for row in range(SIZE):
            order[sex, row] = row
        for i in range(COUNT):
            for k in range(n):
                u[sex, i, k] = start[sex * COUNT + i, k]
    return Swarm(u, np.zeros((2, SIZE, n)), value, np.zeros((2, SIZE, n)), own_value, order)


@inlined
def _settle(
    function: Function,
    swarm: Swarm,
    first: int,
    last: int,
    low: Array,
    high: Array,
    given: Any,
    x: Array,
    best: Best,
) -> None:
    """Evaluate the ranks from `first` up to `last` where they are, and sort anew up to there."""
    for sex in range(2):
        for i in range(first, last):
            row = swarm.order[sex, i]
            value = evaluate(function, swarm.u[sex, row], low, high, given, x, best)
            swarm.value[sex, row] = value
            if value < swarm.own_value[sex, row]:
                swarm.own_value[sex, row] = value
                for k in range(len(x)):
                    swarm.own[sex, row, k] = swarm.u[sex, row, k]
        rank(swarm.value[sex], swarm.order[sex], last)


@compiled
def _fly(swarm: Swarm, generation: int, best: Best, rng: State) -> None:
    """All change velocity and move; females look where the males were."""
    flight, dance = FLIGHT * FLIGHT_DAMPING**generation, DANCE * DANCE_DAMPING**generation
    for i in range(COUNT):
        _fly_female(swarm, i, flight, rng)
    for i in range(COUNT):
        _fly_male(swarm, i, dance, best, rng)


@compiled
def _fly_female(swarm: Swarm, i: int, flight: float, rng: State) -> None:
    """To a better male of her rank, else at random.

    v <- g v + a3 exp(-beta (x - y)^2) (x - y)   if f(y) > f(x)
    v <- g v + fl r,  r in [-1, 1]^n             else
    """
    row, mate = swarm.order[FEMALE, i], swarm.order[MALE, i]
    x, y, v = swarm.u[MALE, mate], swarm.u[FEMALE, row], swarm.v[FEMALE, row]
    if swarm.value[FEMALE, row] > swarm.value[MALE, mate]:
        for k in range(len(y)):
            v[k] = GRAVITY * v[k] + MATE * pull(x[k] - y[k])
    else:
        _wander(v, flight, rng)
    move(y, v, LIMIT)


@compiled
def _fly_male(swarm: Swarm, i: int, dance: float, best: Best, rng: State) -> None:
    """To his own best and to the best of all; who is the best dances.

    v <- g v + a1 exp(-beta (p - x)^2) (p - x) + a2 exp(-beta (b - x)^2) (b - x)   if f(x) > f(b)
    v <- g v + d r,  r in [-1, 1]^n                                                else
    """
    row = swarm.order[MALE, i]
    x, v, own = swarm.u[MALE, row], swarm.v[MALE, row], swarm.own[MALE, row]
    if swarm.value[MALE, row] > best.value[0]:
        for k in range(len(x)):
            attraction = OWN * pull(own[k] - x[k]) + LEADER * pull(best.u[k] - x[k])
            v[k] = GRAVITY * v[k] + attraction
    else:
        _wander(v, dance, rng)
    move(x, v, LIMIT)


@compiled
def pull(r: float) -> float:
    """exp(-beta r^2) r for |r| <= 1 to 1e-12, four times as fast as the library's exponential.

    exp(-y) = (sum_j (-y/8)^j / j!)^8,  y = beta r^2 <= 2
    """
    z = -0.125 * SIGHT * r * r
    series = 1.0 / 40320.0 + z / 362880.0
    for coefficient in (1 / 5040, 1 / 720, 1 / 120, 1 / 24, 1 / 6, 1 / 2, 1.0, 1.0):
        series = coefficient + series * z
    series *= series
    series *= series
    return series * series * r


@compiled
def _wander(v: Array, step: float, rng: State) -> None:
    """v <- g v + step r,  r in [-1, 1]^n."""
    for k in range(len(v)):
        v[k] = GRAVITY * v[k] + step * (2.0 * uniform(rng) - 1.0)


@compiled
def _breed(swarm: Swarm, rng: State) -> None:
    """Offspring of equal ranks, one of each sex, and one mutant of each sex, in free rows.

    c1 = L x + (1 - L) y,  c2 = L y + (1 - L) x,  L in [-0.4, 1.4] per coordinate
    """
    for pair in range(PAIRS):
        x = swarm.u[MALE, swarm.order[MALE, pair]]
        y = swarm.u[FEMALE, swarm.order[FEMALE, pair]]
        son = _newborn(swarm, MALE, COUNT + pair)
        daughter = _newborn(swarm, FEMALE, COUNT + pair)
        for k in range(len(x)):
            share = (1.0 + 2.0 * OVERSHOOT) * uniform(rng) - OVERSHOOT
            son[k] = min(max(share * x[k] + (1.0 - share) * y[k], 0.0), 1.0)
            daughter[k] = min(max(share * y[k] + (1.0 - share) * x[k], 0.0), 1.0)
    for sex in range(2):
        parent = swarm.u[sex, swarm.order[sex, int(COUNT * uniform(rng))]]
        mutant = _newborn(swarm, sex, SIZE - 1)
        for k in range(len(mutant)):
            step = LIMIT * (2.0 * uniform(rng) - 1.0)
            mutant[k] = min(max(parent[k] + step, 0.0), 1.0)


@compiled
def _newborn(swarm: Swarm, sex: int, i: int) -> Array:
    """Position of a rank that is free, at rest and without a past."""
    row = swarm.order[sex, i]
    swarm.v[sex, row, :] = 0.0
    swarm.own_value[sex, row] = np.inf
    position: Array = swarm.u[sex, row]
    return position
