"""The oracle, whose plans ship with the package: open-loop plans found by the cross-entropy method.

A plan holds every action at knots `KNOT_S` apart, linear in between, and reads no observation. It
begins as the actions of the tuned PI on that ground. Triangular functions h_k of time change it,
first one constant, then more and narrower ones:

    plan = clip(base + sum of w_k h_k(t), -1, 1)        w_k ~ N(mean, sd)

`base` is the best plan of the stage before, and each action has its own w_k. The next mean and sd
are those of the best plans of a round, with a share `KEPT` of the last ones. The search drives the
simulator itself, so it knows all of the ground. It gives no bound, only what it has found.

`python -m twin.control.oracle [ENV]` plans the held-out grounds, 25 at a time, and writes the
environment's file; it goes on where that file ends. Delete the file to search anew.

Source of the method: Rubinstein and Kroese 2004, The cross-entropy method.
"""

from __future__ import annotations

import gzip
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import Controller
from twin.control.plans import DURATION_S, FOLDER, KNOT_S, Plans, shipped
from twin.control.trials import ENVIRONMENTS, HELD_OUT
from twin.env import grounds
from twin.env.episodes import REWARD, Episodes
from twin.env.grounds import Ground
from twin.io.atomic import write_bytes

Array = NDArray[np.float64]

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
    stages: tuple[tuple[int, int, float], ...]
    """Hats over the episode, rounds with them, and their deviation over the first."""


SEARCHES = {
    "Plough-v1": Search((0.4, 0.4, 0.15, 0.3), 10, 4, ((1, 3, 1.0), (3, 2, 0.6))),
    "WheelSlip-v1": Search((0.2, 0.2), 10, 4, ((1, 3, 1.0), (3, 2, 0.6), (6, 2, 0.4))),
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
        total += np.where(alive, episodes.told([REWARD])[REWARD], 0.0)
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


def plan(
    episodes: Episodes,
    on: Sequence[Ground],
    base: Array,
    search: Search,
    seed: int = 0,
) -> tuple[Array, Array]:
    """The best plans found for some grounds.

    Args:
        episodes: as many tractors as grounds times the population.
        on: the grounds.
        base: plans to begin with (grounds, knots, actions).
        search: how much is searched.
        seed: of the search.

    Returns:
        mean rewards (grounds,), plans (grounds, knots, actions).
    """
    generator = np.random.default_rng(seed)
    count, many = len(on), search.population
    best, most = np.round(np.clip(base, -1.0, 1.0), DECIMALS), np.full(count, -np.inf)
    for number, rounds, scale in search.stages:
        shape = hats(number, base.shape[1])
        middle = np.zeros((count, number, base.shape[2]))
        sd = np.broadcast_to(scale * np.asarray(search.spread), middle.shape).copy()
        start = best.copy()
        for _ in range(rounds):
            weights = middle + sd * generator.standard_normal((many, *middle.shape))
            weights[0] = middle
            tried = np.clip(start + shape @ weights, -1.0, 1.0).round(DECIMALS)
            flat = tried.reshape(many * count, *base.shape[1:])
            rewards = reached(episodes, list(on) * many, Plans(flat))[0].reshape(many, count)
            chosen = np.argsort(-rewards, axis=0)[: search.elite]
            for g in range(count):
                kept = weights[chosen[:, g], g]
                middle[g] = KEPT * middle[g] + (1.0 - KEPT) * kept.mean(axis=0)
                sd[g] = KEPT * sd[g] + (1.0 - KEPT) * kept.std(axis=0)
                first = chosen[0, g]
                if rewards[first, g] > most[g]:
                    most[g], best[g] = rewards[first, g], tried[first, g]
    found: tuple[Array, Array] = most, np.asarray(best, dtype=np.float64)
    return found


def written(environment: str, knots: Array, search: Search) -> bytes:
    """The file of some plans, the same bytes for the same plans."""
    held = {
        "schema": 1,
        "environment": environment,
        "first_seed": HELD_OUT,
        "knot_s": KNOT_S,
        "population": search.population,
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
            on = held_out(episodes, first, TOGETHER)
            rewards, knots = reached(episodes, on * search.population, baselines["pi"])
            most, best = plan(episodes, on, knots[:TOGETHER], search)
            plans.append(best)
            pi = rewards[:TOGETHER].mean()
            print(f"{environment} from {first}: PI {pi:.4f}, plans {most.mean():.4f}", flush=True)
            content = written(environment, np.concatenate(plans), search)
            write_bytes(FOLDER / f"{environment}.json.gz", content)
    return 0


def held_out(episodes: Episodes, first: int, count: int) -> list[Ground]:
    """Grounds as a reset with the held-out seeds draws them."""
    generators = [np.random.default_rng(HELD_OUT + first + i) for i in range(count)]
    return [grounds.draw(g, {}, episodes.shapes, episodes.recipe) for g in generators]


if __name__ == "__main__":
    sys.exit(main())
