"""The offline smoother: the states at each instant from all measurements, later ones too.

Not causal: the best that a causal filter of the same model can approach.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.estimate import State, advance, begin, write_axle
from estimators.kalman import Record, predict, update
from estimators.steps import (
    BODY_ACCEL,
    FRONT_SPEED,
    MEASURED,
    REAR_ACCEL,
    REAR_SPEED,
    clear,
    first_step,
    gather,
)
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

STATES = 4
TUNING = np.dtype(
    [("jerk_psd", "f8"), ("sd", "f8", MEASURED), ("bias_sd", "f8", 2), ("bias_psd", "f8")],
    align=True,
)


@dataclass(frozen=True, kw_only=True)
class Smoother:
    """Rauch-Tung-Striebel smoothing of [v, a, j, b] of the ground and of the wheels.

    x_k|n = x_k|k + G (x_k+1|n - F x_k|k),  G = P_k|k F^T P_k+1|k^-1
    P_k|n = P_k|k + G (P_k+1|n - P_k+1|k) G^T

    `run` takes all streams at once and keeps nothing: a state between chunks would mean nothing.

    Source: Rauch, Tung and Striebel (1965), AIAA J. 3, 1445.
    """

    offline: ClassVar[bool] = True

    jerk_psd_m2ps7: float = 100.0
    """Density of the white noise that drives the jerk."""
    front_sd_mps: float = 0.10
    """sd of the front wheels' speed, as the paper's R1."""
    gnss_sd_mps: float = 0.13
    """sd of the GNSS speed, as its R2."""
    rear_sd_mps: float = 0.11
    """sd of the driven wheels' speed."""
    accel_sd_mps2: float = 0.06
    """sd of both accelerations."""
    bias_sd_mps2: float = 0.0
    """sd of the accelerometers' biases at the start."""
    bias_psd_m2ps5: float = 0.0
    """Density of their random walk."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        tuning["jerk_psd"], tuning["bias_psd"] = self.jerk_psd_m2ps7, self.bias_psd_m2ps5
        tuning["sd"] = (
            self.front_sd_mps,
            self.gnss_sd_mps,
            self.accel_sd_mps2,
            self.rear_sd_mps,
            self.accel_sd_mps2,
        )
        tuning["bias_sd"] = self.bias_sd_mps2
        return begin(setup, tuning, first_step())

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The unchanged state, and a table with one row per accepted wheel sample.

        An out-of-order wheel sample gives no row.
        """
        return state, advance(_loop, state, chunk)[1]


SMOOTHER = Smoother()


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    count = 0
    at = np.empty(len(signals), np.int64)
    z, age = np.empty((len(signals), MEASURED)), np.empty((len(signals), MEASURED))
    dt = np.empty(len(signals))
    for i in range(len(signals)):
        if gather(signals[i], nominal, memory):
            at[count], dt[count] = i, memory.dt_s
            for which in range(MEASURED):
                z[count, which], age[count, which] = memory.z[which], memory.age_s[which]
            rows[count].epoch_ns, rows[count].flags = memory.epoch_ns, memory.flags
            clear(memory)
            count += 1
    ground, ground_var = _smooth(z[:count], age, dt, FRONT_SPEED, BODY_ACCEL, 0, tuning)
    wheel, wheel_var = _smooth(z[:count], age, dt, REAR_SPEED, REAR_ACCEL, 1, tuning)
    for k in range(count):
        write_axle(
            rows[k], signals[at[k]], nominal, ground[k], ground_var[k], wheel[k], wheel_var[k]
        )
    return count


@compiled
def _smooth(
    z: Array, age: Array, dt: Array, first: int, last: int, channel: int, tuning: Record
) -> tuple[Array, Array]:
    """Speed and its variance at each step, (steps,), from measurements `first` to `last`."""
    n = len(z)
    f, q = np.eye(STATES), np.zeros((STATES, STATES))
    x, p = np.zeros((n, STATES)), np.zeros((n, STATES, STATES))
    predicted_x, predicted_p = np.zeros((n, STATES)), np.zeros((n, STATES, STATES))
    mean = np.zeros(STATES)
    cov = np.diag(np.array([1e4, 1.0, 1.0, tuning.bias_sd[channel] ** 2]))
    for k in range(n):
        _transition(f, q, dt[k], tuning)
        if k > 0:
            predict(mean, cov, f, q)
        predicted_x[k], predicted_p[k] = mean, cov
        for which in range(first, last + 1):
            _take(mean, cov, z[k, which], age[k, which], which, tuning.sd[which])
        x[k], p[k] = mean, cov
    for k in range(n - 2, -1, -1):
        _transition(f, q, dt[k + 1], tuning)
        gain = p[k] @ f.T @ np.linalg.pinv(predicted_p[k + 1])
        x[k] += gain @ (x[k + 1] - predicted_x[k + 1])
        p[k] += gain @ (p[k + 1] - predicted_p[k + 1]) @ gain.T
    return x[:, 0].copy(), p[:, 0, 0].copy()


@compiled
def _transition(f: Array, q: Array, dt: float, tuning: Record) -> None:
    f[0, 1] = f[1, 2] = dt
    f[0, 2] = 0.5 * dt * dt
    q[2, 2], q[3, 3] = tuning.jerk_psd * dt, tuning.bias_psd * dt


@compiled
def _take(mean: Array, cov: Array, z: float, age: float, which: int, sd: float) -> None:
    if which in (BODY_ACCEL, REAR_ACCEL):
        h = np.array([0.0, 1.0, -age, 1.0])
    else:
        h = np.array([1.0, -age, 0.5 * age * age, 0.0])
    update(mean, cov, h, z, sd * sd)
