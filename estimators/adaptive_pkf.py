"""The IMA-PKF paper's parallel Kalman filter, whose Q and R a swarm tunes online.

Two observers of all six states, each with Q and R of its own: one measures the ground speed by the
front wheels, one by GNSS; the body's acceleration, the driven wheels' speed and its acceleration
they share. A, Q, R and the rows of H connect nothing between the ground's three states and the
wheels', so an observer is two blocks of three.

One module, because the search and the filter it drives share one record and one loop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.estimate import State, advance, begin, write_axle
from estimators.fusion import fuse
from estimators.kalman import Record, predict, update
from estimators.layout import RESTARTED, STALE_S
from estimators.noise_adaptation import (
    BUDGET,
    DEVIATION,
    IMPROVED_MAYFLY,
    LOGARITHM,
    MAYFLY,
    PSO,
    ROWS,
    SOUGHT,
    VARIANCE,
    accumulate,
    mean_of,
    mean_square,
    problem,
    search,
)
from estimators.optimisers import chance
from estimators.steps import (
    BODY_ACCEL,
    FRONT_SPEED,
    GNSS_SPEED,
    REAR_ACCEL,
    REAR_SPEED,
    STEP,
    STEP_S,
    clear,
    first_step,
    gather,
)
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

OBSERVERS, BLOCKS, STATES = 2, 2, 3
GROUND, WHEEL = 0, 1
METHODS = {"pso": PSO, "mayfly": MAYFLY, "improved-mayfly": IMPROVED_MAYFLY, "none": -1}
ENCODINGS = {"linear": VARIANCE, "sd": DEVIATION, "log": LOGARITHM}
LONGEST_WINDOW = 256

TUNING = np.dtype(
    [
        ("method", "i8"),
        ("encoding", "i8"),
        ("low", "f8", (OBSERVERS, SOUGHT)),
        ("high", "f8", (OBSERVERS, SOUGHT)),
        ("noise", "f8", (OBSERVERS, SOUGHT)),
        ("every", "i8"),
        ("window", "i8"),
        ("budget", "i8"),
    ],
    align=True,
)
MEMORY = np.dtype(
    [
        ("step", STEP),
        ("steps", "i8"),
        ("known", "i8", (OBSERVERS, BLOCKS)),
        ("x", "f8", (OBSERVERS, BLOCKS, STATES)),
        ("cov", "f8", (OBSERVERS, BLOCKS, STATES, STATES)),
        ("noise", "f8", (OBSERVERS, SOUGHT)),
        ("innovation", "f8", (OBSERVERS, ROWS)),
        ("sums", "f8", (OBSERVERS, ROWS, ROWS)),
        ("counts", "f8", (OBSERVERS, ROWS, ROWS)),
        ("window", "f8", (OBSERVERS, LONGEST_WINDOW, ROWS)),
        ("fitness", "f8", OBSERVERS),
        ("rng", "u8", 4),
    ],
    align=True,
)


@dataclass(frozen=True, kw_only=True)
class AdaptivePkf:
    """A parallel Kalman filter with Q and R of each observer sought every few steps.

    At step k, before the update, e = Z - H A x is the innovation and C the mean of e e^T so far, or
    over a window. The search takes the (Q, R) of the box with the least

        || H (A P A^T + n Q) H^T + R - C ||_2

    that it finds, n the number of 0.02 s steps since the last update. The filter uses them from
    this step on. The next search does not start from them.

    Source: IMA-PKF paper (INMATEH 77-13), eq. (3)-(20). It prints neither box, nor budget, nor P at
    the start, nor how often it adapts.
    """

    optimiser: Literal["pso", "mayfly", "improved-mayfly", "none"] = "improved-mayfly"
    """What searches; "none" keeps Q and R as they start."""
    encoding: Literal["linear", "sd", "log"] = "linear"
    """Whether the box is one of variances, of standard deviations or of logarithms."""
    process_var: tuple[float, float] = (1e-6, 1e-2)
    """Ends of the box for each element of diag(Q), per 0.02 s."""
    measurement_factor: tuple[float, float] = (0.1, 4.0)
    """Ends of the box for each element of diag(R), as multiples of what the paper prints."""
    process_var_start: float = 1e-3
    """Q before the first search; R starts as printed."""
    front_sd_mps: float = 0.10
    """sd of the front wheels' speed, of R1 in the paper."""
    gnss_sd_mps: float = 0.13
    """sd of the GNSS speed, of R2."""
    rear_sd_mps: float = 0.11
    """sd of the driven wheels' speed, of R1 and R2."""
    accel_sd_mps2: float = 0.06
    """sd of both accelerations, of R1 and R2."""
    every: int = 5
    """Steps from one search to the next."""
    window: int = 0
    """Number of steps over which C is averaged, at most 256; 0 for all so far, as printed."""
    budget: int = BUDGET
    """Evaluations of each search."""
    seed: int = 0
    """Seed of the search's random numbers."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        tuning["method"], tuning["encoding"] = METHODS[self.optimiser], ENCODINGS[self.encoding]
        tuning["every"], tuning["window"] = self.every, min(self.window, LONGEST_WINDOW)
        tuning["budget"] = self.budget
        for observer, ground_sd in enumerate((self.front_sd_mps, self.gnss_sd_mps)):
            sd = (ground_sd, self.accel_sd_mps2, self.rear_sd_mps, self.accel_sd_mps2)
            low, high = self._box(np.square(sd))
            tuning["low"][0, observer], tuning["high"][0, observer] = low, high
            tuning["noise"][0, observer, :6] = self.process_var_start
            tuning["noise"][0, observer, 6:] = np.square(sd)
        memory = np.zeros(1, MEMORY)
        memory["step"] = first_step()
        memory["noise"], memory["fitness"] = tuning["noise"], np.nan
        memory["rng"] = chance.start(np.random.default_rng(self.seed))
        return begin(setup, tuning, memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        An out-of-order wheel sample gives no row.
        """
        return advance(_loop, state, chunk)

    def _box(self, variance: Array) -> tuple[Array, Array]:
        ends = [
            np.concatenate([np.full(6, q), factor * variance])
            for q, factor in zip(self.process_var, self.measurement_factor, strict=True)
        ]
        if self.encoding == "linear":
            return ends[0], ends[1]
        encode = np.sqrt if self.encoding == "sd" else np.log
        return encode(ends[0]), encode(ends[1])


PSO_PKF = AdaptivePkf(optimiser="pso")
"""Parallel Kalman filter; a particle swarm searches variances for its Q and R."""
MA_PKF = AdaptivePkf(optimiser="mayfly")
"""Parallel Kalman filter; the mayfly algorithm searches variances for its Q and R."""
IMA_PKF = AdaptivePkf(optimiser="improved-mayfly")
"""Parallel Kalman filter; the improved mayfly algorithm searches variances for its Q and R."""
LOGARITHMIC: Any = {"encoding": "log", "process_var": (1e-8, 1e-2)}
PSO_PKF_LOG = AdaptivePkf(optimiser="pso", **LOGARITHMIC)
"""As pso-pkf, but the search is over logarithms of variances."""
MA_PKF_LOG = AdaptivePkf(optimiser="mayfly", **LOGARITHMIC)
"""As ma-pkf, but the search is over logarithms of variances."""
IMA_PKF_LOG = AdaptivePkf(optimiser="improved-mayfly", **LOGARITHMIC)
"""As ima-pkf, but the search is over logarithms of variances."""


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    count = 0
    for i in range(len(signals)):
        if gather(signals[i], nominal, memory.step):
            _advance(tuning, memory)
            _report(rows[count], signals[i], nominal, memory)
            clear(memory.step)
            count += 1
    return count


@compiled
def _advance(tuning: Record, memory: Record) -> None:
    """One step of both observers: predict, compare, adapt, update."""
    _restart_after_gap(tuning, memory)
    memory.steps += 1
    for observer in range(OBSERVERS):
        for block in range(BLOCKS):
            _predict(observer, block, memory)
        _remember(observer, tuning, memory)
        if memory.steps % tuning.every == 0:
            _adapt(observer, tuning, memory)
        for block in range(BLOCKS):
            _update(observer, block, memory)


@compiled
def _restart_after_gap(tuning: Record, memory: Record) -> None:
    """Begin as at first: states, covariances and what the searches found are of before the gap."""
    if memory.step.dt_s > STALE_S:
        memory.steps = 0
        for observer in range(OBSERVERS):
            memory.noise[observer, :] = tuning.noise[observer]
            memory.known[observer, GROUND] = memory.known[observer, WHEEL] = 0
            for i in range(ROWS):
                for j in range(ROWS):
                    memory.sums[observer, i, j] = memory.counts[observer, i, j] = 0.0
        memory.step.flags |= RESTARTED


@compiled
def _measured(observer: int, block: int) -> tuple[int, int]:
    """Which measurements of a step are this block's speed and acceleration."""
    if block == WHEEL:
        return REAR_SPEED, REAR_ACCEL
    return (FRONT_SPEED if observer == 0 else GNSS_SPEED), BODY_ACCEL


@compiled
def _predict(observer: int, block: int, memory: Record) -> None:
    """x <- A x and P <- A P A^T, Q not yet added; e = z - H x."""
    x, innovation = memory.x[observer, block], memory.innovation[observer]
    innovation[2 * block] = innovation[2 * block + 1] = np.nan
    if not memory.known[observer, block]:
        return
    dt = memory.step.dt_s
    transition = np.eye(STATES)
    transition[0, 1] = transition[1, 2] = dt
    transition[0, 2] = 0.5 * dt * dt
    predict(x, memory.cov[observer, block], transition, np.zeros((STATES, STATES)))
    speed, accel = _measured(observer, block)
    tau = memory.step.age_s[speed]
    seen = x[0] - tau * x[1] + 0.5 * tau * tau * x[2]
    innovation[2 * block] = memory.step.z[speed] - seen
    tau = memory.step.age_s[accel]
    innovation[2 * block + 1] = memory.step.z[accel] - x[1] + tau * x[2]


@compiled
def _remember(observer: int, tuning: Record, memory: Record) -> None:
    """Count this step's innovation in: into the sums, or into the window."""
    if tuning.window == 0:
        accumulate(memory.innovation[observer], memory.sums[observer], memory.counts[observer])
    else:
        for i in range(ROWS):
            at = memory.steps % tuning.window
            memory.window[observer, at, i] = memory.innovation[observer, i]


@compiled
def _adapt(observer: int, tuning: Record, memory: Record) -> None:
    """Seek Q and R of an observer."""
    if tuning.method < 0 or not memory.known[observer, GROUND]:
        return
    if tuning.window == 0:
        tpmse = mean_of(memory.sums[observer], memory.counts[observer])
    else:
        tpmse = mean_square(memory.window[observer, : min(memory.steps, tuning.window)])
    ground, wheel = memory.cov[observer, GROUND], memory.cov[observer, WHEEL]
    given = problem(ground, wheel, tpmse, memory.step.dt_s / STEP_S, tuning.encoding)
    low, high, noise = tuning.low[observer], tuning.high[observer], memory.noise[observer]
    memory.fitness[observer] = search(
        tuning.method, given, low, high, tuning.budget, memory.rng, noise
    )


@compiled
def _update(observer: int, block: int, memory: Record) -> None:
    """P <- P + Q, then take the block's two measurements; begin with the first speed."""
    step, noise = memory.step, memory.noise[observer]
    x, cov = memory.x[observer, block], memory.cov[observer, block]
    speed, accel = _measured(observer, block)
    tau = step.age_s[speed]
    if not memory.known[observer, block]:
        if math.isfinite(step.z[speed]):
            _begin(observer, block, step.z[speed], noise[6 + 2 * block] + tau * tau, memory)
    else:
        for k in range(STATES):
            cov[k, k] += noise[3 * block + k] * step.dt_s / STEP_S
        h = np.array([1.0, -tau, 0.5 * tau * tau])
        update(x, cov, h, step.z[speed], noise[6 + 2 * block])
    if memory.known[observer, block]:
        h = np.array([0.0, 1.0, -step.age_s[accel]])
        update(x, cov, h, step.z[accel], noise[7 + 2 * block])


@compiled
def _begin(observer: int, block: int, speed: float, variance: float, memory: Record) -> None:
    """[z, 0, 0], sd 1 of acceleration and jerk."""
    memory.known[observer, block] = 1
    memory.x[observer, block, :] = 0.0
    memory.cov[observer, block, :, :] = 0.0
    memory.x[observer, block, 0] = speed
    memory.cov[observer, block, 0, 0] = variance
    memory.cov[observer, block, 1, 1] = memory.cov[observer, block, 2, 2] = 1.0


@compiled
def _report(row: Record, signal: Record, nominal: Record, memory: Record) -> None:
    """Fuse what there is of the two observers and write the estimate."""
    ground, ground_var = _fused(GROUND, memory)
    wheel, wheel_var = _fused(WHEEL, memory)
    write_axle(row, signal, nominal, ground, ground_var, wheel, wheel_var)
    row.epoch_ns, row.flags = memory.step.epoch_ns, memory.step.flags


@compiled
def _fused(block: int, memory: Record) -> tuple[float, float]:
    """Speed of a block and its variance; NaN if no observer knows it."""
    if memory.known[0, block] and memory.known[1, block]:
        x, p = fuse(
            memory.x[0, block], memory.cov[0, block], memory.x[1, block], memory.cov[1, block]
        )
        return x[0], p[0, 0]
    for observer in range(OBSERVERS):
        if memory.known[observer, block]:
            return memory.x[observer, block, 0], memory.cov[observer, block, 0, 0]
    return np.nan, np.nan
