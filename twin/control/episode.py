"""Drive one environment with a controller and record every control step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twin.control import chosen, own
from twin.control.own import AnyController
from twin.env.grounds import Options
from twin.env.infos import Infos
from twin.env.recording import Recording
from twin.env.single import OneEnv, episodes_of, made
from twin.errors import check_range

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Episode:
    """An episode, a row for each control step. All arrays have the shape (steps,)."""

    observation: dict[str, Array]
    """Observation before the action, by the names of its entries."""
    action: dict[str, Array]
    """Actions of the controller in [-1, 1], by their names."""
    reward: Array
    info: dict[str, Array]
    """`info` after the step: true values, and the terms of the reward."""
    terminated: bool
    """Whether the episode ended because the engine stalled."""


def drive_episode(
    env: OneEnv | str,
    controller: AnyController | str,
    *,
    seed: int | None = None,
    options: Options | None = None,
    duration_s: float | None = None,
    record: Path | None = None,
) -> Episode:
    """Drive one environment with a controller, from a reset to the end of the episode.

    ```
    episode = drive_episode("Plough-v0", "pi", seed=1, duration_s=10.0)
    ```

    Args:
        env: an environment of this package with one tractor, or its id.
        controller: what drives, of one tractor or of many; or its name, as
            `twin compare-controllers` takes it.
        seed: of the ground and of the sensors' errors.
        options: what of the ground is given; see the environment's page.
        duration_s: longest time that is driven [s]; None drives to the environment's own end.
        record: folder for `episode_0.rrd`, which the rerun viewer opens.

    Raises:
        UnknownName, BadInput: there is no such controller, or it fails.
        OutOfRange: a duration that is not positive.
    """
    one = made(env) if isinstance(env, str) else env
    told = own.setup_of(episodes_of(one))
    driven = one if record is None else Recording(one, record)
    if duration_s is not None:
        check_range("duration_s", duration_s, told.period_s, 86400.0)
    name = controller if isinstance(controller, str) else type(controller).__name__
    found = chosen.controller(controller, told) if isinstance(controller, str) else controller
    driver, names = own.of_many(found, told, name), [entry.name for entry in told.observed]
    moments: list[Moment] = []
    observation, _ = driven.reset(seed=seed, options=options)
    state, ended = own.started(driver, 1, name), False
    while not ended and (duration_s is None or len(moments) < round(duration_s / told.period_s)):
        seen = observation
        state, (action,) = own.acted(driver, state, names, seen[None], told, name)
        observation, reward, stalled, late, info = driven.step(action)
        moments.append(Moment(seen, action, float(reward), info))
        ended = stalled or late
    if driven is not env:
        driven.close()
    return Episode(
        observation=_columns(names, [moment.seen for moment in moments]),
        action=_columns(told.actions, [moment.action for moment in moments]),
        reward=np.array([moment.reward for moment in moments]),
        info={n: np.array([m.info[n] for m in moments]) for n in moments[0].info},
        terminated=stalled,
    )


class Moment(NamedTuple):
    """A control step."""

    seen: NDArray[np.float32]
    action: NDArray[np.float32]
    reward: float
    info: Infos


def _columns(names: Sequence[str], rows: Sequence[NDArray[np.float32]]) -> dict[str, Array]:
    """Rows of numbers as named columns."""
    return dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))
