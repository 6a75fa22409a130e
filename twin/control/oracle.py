"""The oracle, whose plans ship with the package: open-loop plans found by the cross-entropy method.

A plan holds every action at knots `KNOT_S` apart, linear in between, and reads no observation.
First the gains of the PI are searched on each ground, from the tuned ones; the actions of the best
are the first plan. Triangular functions h_k of time change it, first wide and then narrow:

    plan = clip(base + sum of w_k h_k(t), -1, 1)        w_k ~ N(mean, sd)

`base` is the best plan of the stage before, and each action has its own w_k. The next mean and sd
are those of the best of a round, with a share `KEPT` of the last ones. The search drives the
simulator itself, so it knows all of the ground. It gives no bound, only what it has found.

`python -m twin.control.oracle [ENV]` plans the held-out grounds, 25 at a time, and writes the
environment's file; it goes on where that file ends. Delete the file to search anew.

Source of the method: Rubinstein and Kroese 2004, The cross-entropy method.
"""

from __future__ import annotations

import gzip
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from twin.control.controllers import Controller
from twin.control.plans import DURATION_S, FOLDER, KNOT_S, Plans, shipped
from twin.control.trials import ENVIRONMENTS, HELD_OUT
from twin.control.tune import RANGES
from twin.env import grounds
from twin.env.episodes import REWARD, Episodes
from twin.env.grounds import Ground
from twin.io.atomic import write_bytes

Array = NDArray[np.float64]
Score: TypeAlias = Callable[[Array], tuple[Array, Array]]
"""Of weights (population, grounds, ...): rewards (population, grounds) and the plans behind them
(population, grounds, knots, actions)."""

DECIMALS = 3
"""Of a knot's actions, in the file and in the search alike."""
GROUNDS = 50
TOGETHER = 25
"""Grounds that are planned side by side."""
KEPT = 0.2
"""Share of the last round's mean and sd that is kept in the next."""


@dataclass(frozen=True)
class Search:
    """How much is searched."""

    spread: tuple[float, ...]
    """Deviation of each action's first hats."""
    population: int
    elite: int
    gain_rounds: int
    """Rounds of the PI's gains."""
    stages: tuple[tuple[int, int, float], ...]
    """Hats over the episode, rounds with them, and their deviation over the first."""


GAIN_SPREAD = 0.2
"""Deviation of a gain's first candidates, over its range."""
SEARCHES = {
    "Plough-v1": Search((0.3, 0.3, 0.1, 0.3), 10, 4, 4, ((1, 2, 0.6), (4, 2, 0.6))),
    "WheelSlip-v1": Search((0.2, 0.2), 8, 3, 2, ((4, 2, 0.6),)),
}
"""How the shipped plans were found."""


def reached(
    episodes: Episodes, on: Sequence[Ground], controller: Controller
) -> tuple[Array, Array]:
    """Mean reward of a controller on each ground, and its actions at the knots' times.

    A stalled tractor earns nothing more.

    Returns:
        rewards (grounds,), actions (grounds, knots, actions).
    """
    period_s, count = episodes.fleet.period_s, len(on)
    steps, every = round(DURATION_S / period_s), round(KNOT_S / period_s)
    episodes.begin(list(range(count)), on)
    seen, state = episodes.look(), controller.init(count)
    alive, total = np.ones(count, dtype=np.bool_), np.zeros(count)
    names, knots = [entry.name for entry in episodes.entries], list[Array]()
    for step in range(steps):
        columns = dict(zip(names, seen.T.astype(np.float64), strict=True))
        state, asked = controller.act(state, columns, period_s)
        actions: Array = np.ascontiguousarray(asked, dtype=np.float32).astype(np.float64)
        if step % every == 0:
            knots.append(actions.copy())
        alive &= ~episodes.advance(actions)
        seen = episodes.look()
        total += np.where(alive, episodes.values_of([REWARD])[REWARD], 0.0)
    knots.append(actions.copy())
    plans: Array = np.stack(knots, axis=1)
    return np.asarray(total / steps), plans


def hats(count: int, knots: int) -> Array:
    """Values at the knots of functions that add up to 1, linear between their tops (knots, count).

    One is constant.
    """
    if count == 1:
        return np.ones((knots, 1))
    places = np.linspace(0.0, count - 1.0, knots)
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(places[:, None] - np.arange(count))))


def searched(
    score: Score, middle: Array, sd: Array, rounds: int, search: Search, generator: Generator
) -> tuple[Array, Array]:
    """The best plans that the cross-entropy method finds, on each ground for itself.

    Args:
        score: what weights are worth.
        middle, sd: of the first candidates (grounds, ...); the middle is one of them in each round.
        rounds: how often.
        search: how many are tried in a round, and how many of them give the next.
        generator: of the candidates.

    Returns:
        mean rewards (grounds,), plans (grounds, knots, actions).
    """
    middle, sd, most = middle.copy(), sd.copy(), np.full(len(middle), -np.inf)
    best: Array | None = None
    for _ in range(rounds):
        weights = middle + sd * generator.standard_normal((search.population, *middle.shape))
        weights[0] = middle
        rewards, plans = score(weights)
        best = plans[0].copy() if best is None else best
        chosen = np.argsort(-rewards, axis=0)[: search.elite]
        for g, first in enumerate(chosen[0]):
            kept = weights[chosen[:, g], g]
            middle[g] = KEPT * middle[g] + (1.0 - KEPT) * kept.mean(axis=0)
            sd[g] = KEPT * sd[g] + (1.0 - KEPT) * kept.std(axis=0)
            if rewards[first, g] > most[g]:
                most[g], best[g] = rewards[first, g], plans[first, g]
    if best is None:
        raise ValueError("a search has at least one round")
    return most, best


def tuned(
    episodes: Episodes, on: Sequence[Ground], baseline: Any, search: Search, generator: Generator
) -> tuple[Array, Array]:
    """What a baseline did on each ground with the best gains found there.

    Args:
        episodes: as many tractors as grounds times the population.
        on: the grounds.
        baseline: whose gains are searched, within the ranges of the tuner, from its own.
        search: how much is searched.
        generator: of the candidates.

    Returns:
        mean rewards (grounds,), actions at the knots' times (grounds, knots, actions).
    """
    boxes = {name: box for name, box in RANGES.items() if hasattr(baseline, name)}
    low, high = np.array(list(boxes.values())).T
    own = np.array([getattr(baseline, name) for name in boxes])

    def score(weights: Array) -> tuple[Array, Array]:
        gains = np.clip(weights, low, high).reshape(-1, len(own)).T
        driver = replace(baseline, **dict(zip(boxes, gains, strict=True)))
        return _by_ground(*reached(episodes, list(on) * len(weights), driver), len(on))

    middle = np.tile(own, (len(on), 1))
    sd = np.tile(GAIN_SPREAD * (high - low), (len(on), 1))
    return searched(score, middle, sd, search.gain_rounds, search, generator)


def plan(
    episodes: Episodes,
    on: Sequence[Ground],
    base: Array,
    search: Search,
    generator: Generator,
) -> tuple[Array, Array]:
    """The best plans found for some grounds.

    Args:
        episodes: as many tractors as grounds times the population.
        on: the grounds.
        base: plans to begin with (grounds, knots, actions).
        search: how much is searched.
        generator: of the candidates.

    Returns:
        mean rewards (grounds,), plans (grounds, knots, actions).
    """
    most, best = np.full(len(on), -np.inf), np.clip(base, -1.0, 1.0).round(DECIMALS)
    for number, rounds, scale in search.stages:
        score = partial(_changed, episodes, on, best, hats(number, base.shape[1]))
        middle = np.zeros((len(on), number, base.shape[2]))
        sd = np.broadcast_to(scale * np.asarray(search.spread), middle.shape)
        most, best = searched(score, middle, sd, rounds, search, generator)
    return most, best


def _changed(
    episodes: Episodes, on: Sequence[Ground], start: Array, shape: Array, weights: Array
) -> tuple[Array, Array]:
    """A `Score` of the weights of hats on plans."""
    tried = np.clip(start + shape @ weights, -1.0, 1.0).round(DECIMALS)
    flat = tried.reshape(-1, *start.shape[1:])
    rewards, _ = reached(episodes, list(on) * len(weights), Plans(flat))
    return _by_ground(rewards, flat, len(on))


def _by_ground(rewards: Array, plans: Array, count: int) -> tuple[Array, Array]:
    """Both with the candidates along the first axis and the grounds along the second."""
    return rewards.reshape(-1, count), plans.reshape(-1, count, *plans.shape[1:])


def written(environment: str, knots: Array, search: Search) -> bytes:
    """The file of some plans, the same bytes for the same plans."""
    held = {
        "schema": 1,
        "environment": environment,
        "first_seed": HELD_OUT,
        "knot_s": KNOT_S,
        "population": search.population,
        "gain_rounds": search.gain_rounds,
        "stages": search.stages,
        "knots": knots.round(DECIMALS).tolist(),
    }
    return gzip.compress(json.dumps(held).encode(), mtime=0)


def main() -> int:
    """Plan the held-out grounds of each environment that its file has no plans of yet."""
    for environment in sys.argv[1:] or SEARCHES:
        (kind, baselines), search = ENVIRONMENTS[environment], SEARCHES[environment]
        episodes = kind(TOGETHER * search.population, observation="truth").episodes
        known = shipped(environment)
        plans = [] if known is None else [known.knots]
        for first in range(sum(map(len, plans)), GROUNDS, TOGETHER):
            on, generator = held_out(episodes, first, TOGETHER), np.random.default_rng(first)
            own, base = tuned(episodes, on, baselines["pi"], search, generator)
            most, best = plan(episodes, on, base, search, generator)
            plans.append(best)
            means = f"PI with its own gains {own.mean():.4f}, plans {most.mean():.4f}"
            print(f"{environment} from {first}: {means}", flush=True)
            content = written(environment, np.concatenate(plans), search)
            write_bytes(FOLDER / f"{environment}.json.gz", content)
    return 0


def held_out(episodes: Episodes, first: int, count: int) -> list[Ground]:
    """Grounds as a reset with the held-out seeds draws them."""
    generators = [np.random.default_rng(HELD_OUT + first + i) for i in range(count)]
    return [grounds.draw(g, {}, episodes.shapes, episodes.recipe) for g in generators]


if __name__ == "__main__":
    sys.exit(main())
