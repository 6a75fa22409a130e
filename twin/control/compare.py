"""Controllers and saved policies on the same held-out grounds, with 95 % intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.compute.mean import mean
from twin.control.judged import UNITS
from twin.control.own import AnyController
from twin.control.plans import DURATION_S, shipped
from twin.control.regret import TIERS, regret_rows
from twin.control.trials import ENVIRONMENTS, HELD_OUT, drive
from twin.env.many import ManyEnv
from twin.errors import TwinError
from twin.io.result_rows import Row, Rows, row

Array = NDArray[np.float64]

PAIRED = " less that of {}, paired"
"""What a quantity's row is called that holds a difference, ground by ground."""


@dataclass(frozen=True)
class Compared:
    """What controllers reached, and what became of those that failed."""

    measured: dict[str, dict[str, Array]]
    """By controller, then by quantity, arrays of shape (episodes,)."""
    failed: dict[str, str]
    """Controller -> why it failed."""
    tiers: NDArray[np.str_] | None = None
    """Difficulty of each ground, where the environment has tiers."""


def compare(
    controllers: Mapping[str, AnyController],
    episodes: int,
    duration_s: float,
    observation: str,
    progress: Callable[[float], None] = lambda share: None,
    environment: str = "Plough-v0",
) -> Compared:
    """What each controller reached on each ground; the same grounds for all.

    One that fails is left out and named, and the others go on.

    Args:
        controllers: by name.
        episodes: grounds.
        duration_s: length of an episode.
        observation: what the controllers see; see `PloughEnv`.
        progress: called with the share done.
        environment: one of `ENVIRONMENTS`.
    """
    env = ENVIRONMENTS[environment][0](episodes, observation=observation)
    seeds = [HELD_OUT + i for i in range(episodes)]
    done = Compared({}, {}, tiers_of(env, environment, seeds))
    for i, (name, controller) in enumerate(controllers.items()):
        part = _part(progress, i, len(controllers))
        try:
            done.measured[name] = drive(env, controller, seeds, duration_s, part, name)
        except TwinError as error:
            done.failed[name] = str(error)
    env.close()
    return done


def with_oracle(
    controllers: Mapping[str, AnyController], environment: str, episodes: int, duration_s: float
) -> dict[str, AnyController]:
    """The controllers, and the oracle where a PI is among them and its plans reach so far."""
    plans = shipped(environment)
    fits = plans is not None and episodes <= len(plans.knots) and duration_s <= DURATION_S
    if plans is None or not fits or "pi" not in controllers:
        return dict(controllers)
    return {**controllers, "oracle": plans}


def tiers_of(env: ManyEnv, environment: str, seeds: Sequence[int]) -> NDArray[np.str_] | None:
    """The tier of the ground of each seed; None for an environment without tiers."""
    if environment not in TIERS:
        return None
    _, drawn = env.reset(seed=seeds)
    grounds = [{n: v[i] for n, v in drawn.items() if n[0] != "_"} for i in range(len(seeds))]
    return np.array([TIERS[environment](ground) for ground in grounds])


def _part(progress: Callable[[float], None], i: int, count: int) -> Callable[[float], None]:
    return lambda share: progress((i + share) / count)


def rows(measured: Mapping[str, Mapping[str, Array]], against: Sequence[str] = ("pi",)) -> Rows:
    """Means with 95 % intervals; then each controller's values minus those of some, by ground.

    Each row has the ends of its interval as `low` and `high`.

    Args:
        measured: controller -> quantity -> values (grounds,).
        against: controllers that are subtracted.
    """
    out = []
    for name, quantities in measured.items():
        for quantity in quantities:
            out.append(_row(name, quantity, quantities[quantity], UNITS[quantity]))
    for other in against:
        for name in measured:
            if other in measured and name != other:
                for quantity, values in measured[name].items():
                    difference = values - measured[other][quantity]
                    paired = quantity + PAIRED.format(other)
                    out.append(_row(name, paired, difference, UNITS[quantity]))
    return out


def regrets(done: Compared) -> Rows:
    """Headroom and shares of it by tier; none without an oracle and a PI."""
    rewards = {name: quantities["reward"] for name, quantities in done.measured.items()}
    if done.tiers is None or not {"pi", "oracle"} <= rewards.keys():
        return []
    return regret_rows(rewards, done.tiers)


def _row(case: str, quantity: str, values: Array, unit: str) -> Row:
    found = mean(values)
    return dict(row(case, quantity, found.mean, unit)) | found.bounds
