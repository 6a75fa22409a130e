"""What `twin bench` measures of the environments: their own share of a control step's time."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np

from twin.env.plough import PloughEnv
from twin.env.vector import PloughVectorEnv
from twin.io.result_rows import Row, Rows, row

ACTION = np.array([0.3, 0.5], dtype=np.float32)
SETTLE_STEPS, REPEATS = 100, 40


def rows() -> Rows:
    """Rates of the environments over the physics' own; a reset, a start, and an estimate's cost."""
    return [_vector(256), _single(), _reset(1024), _made(), _estimated(1), _estimated(64)]


def _vector(count: int) -> Row:
    env = PloughVectorEnv(count, observation="truth")
    env.reset(seed=0)
    actions = np.tile(ACTION, (count, 1))
    for _ in range(SETTLE_STEPS):
        env.step(actions)
    fleet = env.episodes.fleet
    own_s, raw_s = _best(lambda: env.step(actions), lambda: fleet.batch.step(nstep=fleet.steps))
    return row(
        f"Plough-v0, {count} tractors", "rate over Batch.step's", raw_s / own_s, "1", low=0.6
    )


def _single() -> Row:
    env = PloughEnv("truth")
    env.reset(seed=0)
    for _ in range(SETTLE_STEPS):
        env.step(ACTION)
    fleet = env.episodes.fleet
    model, state = fleet.batch.get_model(0), fleet.batch.get_data(0)
    own_s, raw_s = _best(
        lambda: env.step(ACTION), lambda: mujoco.mj_step(model, state, fleet.steps), repeats=400
    )
    return row("Plough-v0, one tractor", "rate over mj_step's", raw_s / own_s, "1", low=0.5)


def _reset(count: int) -> Row:
    env = PloughVectorEnv(count, observation="truth")
    env.reset(seed=0)
    actions, mask = np.tile(ACTION, (count, 1)), np.arange(count) == 5
    step_s, reset_s = _best(
        lambda: env.step(actions), lambda: env.reset(options={"reset_mask": mask}), repeats=20
    )
    case = f"Plough-v0, {count} tractors"
    return row(case, "reset of one over a control step of all", reset_s / step_s, "1", high=0.01)


def _made() -> Row:
    """Time to make one whose starts were settled before, everything compiled."""
    PloughEnv("estimate")
    (made_s,) = _best(lambda: PloughEnv("estimate"), repeats=3)
    return row("Plough-v0, one tractor", "time to make it again", made_s, "s", high=0.3)


def _estimated(count: int) -> Row:
    actions = np.tile(ACTION, (count, 1))
    envs = [PloughVectorEnv(count, observation=seen) for seen in ("estimate", "truth")]
    for env in envs:
        env.reset(seed=0)
    for _ in range(SETTLE_STEPS):
        envs[1].step(actions)
    seen_s, true_s = _best(*(partial(env.step, actions) for env in envs))
    case = f"Plough-v0, {count} tractors" if count > 1 else "Plough-v0, one tractor"
    return row(case, "rate with an estimate over that on the truth", true_s / seen_s, "1")


def _best(*actions: Callable[[], object], repeats: int = REPEATS) -> list[float]:
    """Shortest time of each action [s], the actions taken in turn."""
    best = [float("inf")] * len(actions)
    for _ in range(repeats):
        for i, action in enumerate(actions):
            start = time.perf_counter()
            action()
            best[i] = min(best[i], time.perf_counter() - start)
    return best
