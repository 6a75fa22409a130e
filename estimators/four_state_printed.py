"""The filter of Zhang (2018) as its paper prints it, for comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.estimate import State, advance, begin, each_sample, write_axle
from estimators.kalman import Record, predict, update
from estimators.layout import GNSS, NO_GROUND_SPEED, RESTARTED, STALE_S, WHEELS
from estimators.wheel_speed import driven_mean, mean_variance
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

STEP_S = 0.1
"""The paper's sampling period."""
JITTER_S = 0.005
"""A sample this much before a step belongs to it."""

TUNING = np.dtype([("q", "f8", 4)])
MEMORY = np.dtype(
    [
        ("flags", "i8"),
        ("step_ns", "i8"),
        ("measured_ns", "i8"),
        ("v", "f8"),
        ("v_var", "f8"),
        ("wheel", "f8"),
        ("wheel_var", "f8"),
        ("wheel_samples", "i8"),
        ("ground_known", "i8"),
        ("wheel_known", "i8"),
        ("x", "f8", 4),
        ("cov", "f8", (4, 4)),
    ],
    align=True,
)


@dataclass(frozen=True, kw_only=True)
class FourStatePrinted:
    """Kalman filter on x = [v, a, w, a_w] at 10 Hz, without accelerometer, as the paper prints it.

    A = blkdiag([[1, dt], [0, 1]], [[1, dt], [0, 1]]),   H = [[1, 0, 0, 0], [0, 0, 1, 0]]
    dt = 0.1 s,   s = (w - v) / max(|w|, |v|, 0.05 m/s)

    Steps come 0.1 s apart on the wheels' clock (the number that fits, after a gap). A step takes
    the last GNSS velocity, if there is a new one, and the mean driven-wheel speed since the step
    before; both at the time of the step, however old. R is the data sheets'. w is the axle's.

    Source: Zhang, B. (2018), eq. (1)-(7). Q and R are not in the paper.
    """

    process_var: tuple[float, float, float, float] = (4e-3, 1e-2, 4e-3, 1e-2)
    """Diagonal of Q per step, of v, a, w, a_w [m2/s2, m2/s4]. Not printed: large beside the
    0.03 m/s of a GNSS velocity, so that v follows it, as the paper's scatter (a constant 0.1 m/s
    in speed) says it did."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        memory = np.zeros(1, MEMORY)
        memory["step_ns"] = memory["measured_ns"] = -1
        memory["v"] = np.nan
        return begin(setup, np.array([(self.process_var,)], TUNING), memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per step of the filter.

        A wheel sample gives a row if a step of 0.1 s is due. An out-of-order one gives none.
        """
        return advance(_loop, state, chunk)


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    return each_sample(_take, signals, nominal, tuning, memory, rows)


@compiled
def _take(signal: Record, nominal: Record, tuning: Record, memory: Record, row: Record) -> bool:
    if signal.sensor == GNSS and math.isfinite(signal.v_x_mps):
        memory.v, memory.v_var = signal.v_x_mps, signal.v_sd_mps**2
        memory.measured_ns = signal.epoch_ns
    if signal.sensor != WHEELS:
        return False
    _collect(signal, nominal, memory)
    steps = _steps_due(signal.epoch_ns, memory)
    if steps > 0:
        _step(steps, tuning, memory)
        _report(row, signal, nominal, memory)
        return True
    return False


@compiled
def _collect(signal: Record, nominal: Record, memory: Record) -> None:
    """Add a wheel sample to the mean since the last step, and to its variance.

    Errors of tick differences telescope, var = r / n^2 for n of them; of speeds var = r / n.
    """
    speed = driven_mean(signal.wheel_mps, nominal)
    variance = mean_variance(signal.wheel_sd_mps, nominal, 1.0, signal.one_driven_speed)
    if not (math.isfinite(speed) and math.isfinite(variance)):
        return
    n = memory.wheel_samples + 1
    memory.wheel = speed if n == 1 else memory.wheel + (speed - memory.wheel) / n
    memory.wheel_var = variance / n**2 if signal.wheel_age_s.max() > 0.0 else variance / n
    memory.wheel_samples = n


@compiled
def _steps_due(epoch_ns: int, memory: Record) -> int:
    """How many steps end at or before an epoch; begins at the first."""
    if memory.step_ns < 0 or (epoch_ns - memory.step_ns) * 1e-9 > STALE_S:
        if memory.step_ns >= 0:
            memory.flags |= RESTARTED
        memory.step_ns = epoch_ns
        memory.ground_known = memory.wheel_known = 0
        return 1
    steps = int(((epoch_ns - memory.step_ns) * 1e-9 + JITTER_S) / STEP_S)
    memory.step_ns += steps * int(STEP_S * 1e9)
    return steps


@compiled
def _step(steps: int, tuning: Record, memory: Record) -> None:
    """Predict over the steps, then measure; a speed seen for the first time begins its half."""
    f, q = np.eye(4), np.diag(tuning.q)
    f[0, 1] = f[2, 3] = STEP_S
    for _ in range(steps):
        predict(memory.x, memory.cov, f, q)
    new_wheel = memory.wheel if memory.wheel_samples > 0 else np.nan
    memory.ground_known = _measure(0, memory.ground_known, memory.v, memory.v_var, memory)
    memory.wheel_known = _measure(2, memory.wheel_known, new_wheel, memory.wheel_var, memory)
    memory.v = np.nan
    memory.wheel_samples = 0


@compiled
def _measure(index: int, known: int, z: float, variance: float, memory: Record) -> int:
    """Measure x[index]; if it is not known yet, start it. Returns whether it is known."""
    if not math.isfinite(z):
        return known
    if not known:
        memory.x[index], memory.x[index + 1] = z, 0.0
        memory.cov[index : index + 2, :] = 0.0
        memory.cov[:, index : index + 2] = 0.0
        memory.cov[index, index], memory.cov[index + 1, index + 1] = variance, 1.0
        return 1
    h = np.zeros(4)
    h[index] = 1.0
    update(memory.x, memory.cov, h, z, variance)
    return 1


@compiled
def _report(row: Record, signal: Record, nominal: Record, memory: Record) -> None:
    """Write the estimate of a step."""
    ground, ground_var, wheel, wheel_var = np.nan, np.nan, np.nan, np.nan
    if memory.ground_known:
        ground, ground_var = memory.x[0], memory.cov[0, 0]
    if not memory.ground_known or (signal.epoch_ns - memory.measured_ns) * 1e-9 > STALE_S:
        memory.flags |= NO_GROUND_SPEED
    if memory.wheel_known:
        wheel, wheel_var = memory.x[2], memory.cov[2, 2]
    write_axle(row, signal, nominal, ground, ground_var, wheel, wheel_var)
    row.epoch_ns, row.flags = signal.epoch_ns, memory.flags
    memory.flags = 0
