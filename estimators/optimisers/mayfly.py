"""The mayfly algorithm: males dance around the best, females follow the males of their rank."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from estimators.compiled import compiled
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

COUNT = 20
"""Males, and as many females."""
PAIRS = 10
"""Ranks that mate, two offspring each."""
PER_GENERATION = 2 * COUNT + 2 * PAIRS + 2
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
SIZE = COUNT + PAIRS + 1
"""Rows of a sex: the living, and room for offspring and a mutant."""
OVERSHOOT = 0.4
"""Offspring lie up to this much beyond their parents."""


class Sex(NamedTuple):
    """The mayflies of one sex with room for offspring and mutant; arrays changed in place."""

    u: Array
    """Positions in the unit cube, (SIZE, n)."""
    v: Array
    """Velocities, as positions."""
    value: Array
    """Values, (SIZE,)."""
    own: Array
    """Best position of each so far."""
    own_value: Array
    """Its value."""
    order: NDArray[np.int64]
    """Row of each rank: COUNT living ones by rising value, then rows that are free."""


class Task(NamedTuple):
    """What is minimised, where, and room for one vector."""

    low: Array
    high: Array
    given: Any
    x: Array


@compiled
def minimise(
    function: Function, low: Array, high: Array, budget: int, rng: Generator, given: Any = ()
) -> Result:
    """Minimise by the mayfly algorithm from uniform random positions.

    Args:
        function: compiled function(x, given) -> value.
        low: lower corner of the box, (n,).
        high: upper corner, (n,).
        budget: most evaluations; at least 40.
        rng: source of chance.
        given: handed on to the function.

    Source: Zervoudakis and Tsafarakis (2020), Comput. Ind. Eng. 145, 106559; constants, distance
    per coordinate and overshooting offspring as in the first author's Python code. The leader is
    the best of either sex; everything happens in the unit cube, where exp(-beta r^2) has a meaning.
    """
    n = len(low)
    task, best = Task(low, high, given, np.empty(n)), nowhere(n)
    males, females = hatch(function, random_points(2 * COUNT, n, rng), task, best)
    generations = max((budget - 2 * COUNT) // PER_GENERATION, 0)
    history = np.empty(generations + 1)
    history[0] = best.value[0]
    for generation in range(generations):
        live(function, males, females, generation, task, best, rng)
        history[generation + 1] = best.value[0]
    return result(best, low, high, 2 * COUNT + PER_GENERATION * generations, history)


@compiled
def hatch(function: Function, start: Array, task: Task, best: Best) -> tuple[Sex, Sex]:
    """Males from the first half of the starting positions, (2 COUNT, n), females from the rest."""
    return (
        _hatch(function, start[:COUNT], task, best),
        _hatch(function, start[COUNT:], task, best),
    )


@compiled
def live(
    function: Function,
    males: Sex,
    females: Sex,
    generation: int,
    task: Task,
    best: Best,
    rng: Generator,
) -> None:
    """One generation: fly, mate by rank, mutate, keep the best COUNT of each sex.

    Everything is changed in place; takes PER_GENERATION evaluations.
    """
    flight, dance = FLIGHT * FLIGHT_DAMPING**generation, DANCE * DANCE_DAMPING**generation
    for i in range(COUNT):
        _fly_female(females, males, i, flight, rng)
        _settle(function, females, i, task, best)
    for i in range(COUNT):
        _fly_male(males, i, dance, best, rng)
        _settle(function, males, i, task, best)
    rank(males.value, males.order, COUNT)
    rank(females.value, females.order, COUNT)
    for pair in range(PAIRS):
        _mate(males, females, pair, rng)
    _mutate(males, rng)
    _mutate(females, rng)
    for i in range(COUNT, SIZE):
        _settle(function, males, i, task, best)
        _settle(function, females, i, task, best)
    rank(males.value, males.order, SIZE)
    rank(females.value, females.order, SIZE)


@compiled
def _hatch(function: Function, start: Array, task: Task, best: Best) -> Sex:
    n = start.shape[1]
    u, v, own = np.zeros((SIZE, n)), np.zeros((SIZE, n)), np.zeros((SIZE, n))
    sex = Sex(u, v, np.full(SIZE, np.inf), own, np.full(SIZE, np.inf), np.arange(SIZE))
    for i in range(COUNT):
        sex.u[i] = start[i]
        _settle(function, sex, i, task, best)
    rank(sex.value, sex.order, COUNT)
    return sex


@compiled
def _settle(function: Function, sex: Sex, i: int, task: Task, best: Best) -> None:
    """Evaluate the mayfly of a rank where it is and remember its best."""
    row = sex.order[i]
    value = evaluate(function, sex.u[row], task.low, task.high, task.given, task.x, best)
    sex.value[row] = value
    if value < sex.own_value[row]:
        sex.own_value[row] = value
        for k in range(sex.u.shape[1]):
            sex.own[row, k] = sex.u[row, k]


@compiled
def _fly_female(females: Sex, males: Sex, i: int, flight: float, rng: Generator) -> None:
    """To a better male of her rank, else at random.

    v <- g v + a3 exp(-beta (x - y)^2) (x - y)   if f(y) > f(x)
    v <- g v + fl r,  r in [-1, 1]^n             else
    """
    row, mate = females.order[i], males.order[i]
    x, y, v = males.u[mate], females.u[row], females.v[row]
    if females.value[row] > males.value[mate]:
        for k in range(len(y)):
            v[k] = GRAVITY * v[k] + MATE * _pull(x[k] - y[k])
    else:
        _wander(v, flight, rng)
    move(y, v, LIMIT)


@compiled
def _fly_male(males: Sex, i: int, dance: float, best: Best, rng: Generator) -> None:
    """To his own best and to the best of all; who is the best dances.

    v <- g v + a1 exp(-beta (p - x)^2) (p - x) + a2 exp(-beta (b - x)^2) (b - x)   if f(x) > f(b)
    v <- g v + d r,  r in [-1, 1]^n                                                else
    """
    row = males.order[i]
    x, v, own = males.u[row], males.v[row], males.own[row]
    if males.value[row] > best.value[0]:
        for k in range(len(x)):
            pull = OWN * _pull(own[k] - x[k]) + LEADER * _pull(best.u[k] - x[k])
            v[k] = GRAVITY * v[k] + pull
    else:
        _wander(v, dance, rng)
    move(x, v, LIMIT)


@compiled
def _pull(r: float) -> float:
    """exp(-beta r^2) r for |r| <= 1 to 1e-13, four times as fast as the library's exponential.

    exp(-y) = (sum_j (-y/8)^j / j!)^8, y = beta r^2 <= 2
    """
    z = -0.125 * SIGHT * r * r
    series = 1.0 / 40320.0 + z / 362880.0
    for coefficient in (1 / 5040, 1 / 720, 1 / 120, 1 / 24, 1 / 6, 1 / 2, 1.0, 1.0):
        series = coefficient + series * z
    series *= series
    series *= series
    return series * series * r


@compiled
def _wander(v: Array, step: float, rng: Generator) -> None:
    """v <- g v + step r, r in [-1, 1]^n"""
    for k in range(len(v)):
        v[k] = GRAVITY * v[k] + step * (2.0 * rng.random() - 1.0)


@compiled
def _mate(males: Sex, females: Sex, pair: int, rng: Generator) -> None:
    """Two offspring of a rank, one of each sex, in free rows.

    c1 = L x + (1 - L) y,  c2 = L y + (1 - L) x,  L in [-0.4, 1.4] per coordinate
    """
    x, y = males.u[males.order[pair]], females.u[females.order[pair]]
    son, daughter = _newborn(males, COUNT + pair), _newborn(females, COUNT + pair)
    for k in range(len(x)):
        share = (1.0 + 2.0 * OVERSHOOT) * rng.random() - OVERSHOOT
        son[k] = min(max(share * x[k] + (1.0 - share) * y[k], 0.0), 1.0)
        daughter[k] = min(max(share * y[k] + (1.0 - share) * x[k], 0.0), 1.0)


@compiled
def _mutate(sex: Sex, rng: Generator) -> None:
    """A copy of a random mayfly, moved by up to LIMIT in each coordinate."""
    parent, mutant = sex.u[sex.order[int(COUNT * rng.random())]], _newborn(sex, SIZE - 1)
    for k in range(len(mutant)):
        step = LIMIT * (2.0 * rng.random() - 1.0)
        mutant[k] = min(max(parent[k] + step, 0.0), 1.0)


@compiled
def _newborn(sex: Sex, i: int) -> Array:
    """Position of a rank that is free, at rest and without a past."""
    row = sex.order[i]
    sex.v[row, :] = 0.0
    sex.own_value[row] = np.inf
    return sex.u[row]
