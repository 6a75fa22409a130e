"""Noise adaptation by what innovations do identify: their likelihood, or their whiteness.

A bank of filters that differ in the density of a white jerk runs on the same measurements, one bank
for the ground's speed and one for the wheels'. Nothing is searched for and nothing is tuned.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.estimate import State, advance, begin, write_axle
from estimators.kalman import Record, correct, predict
from estimators.layout import RESTARTED, STALE_S
from estimators.steps import (
    BODY_ACCEL,
    FRONT_SPEED,
    MEASURED,
    REAR_ACCEL,
    REAR_SPEED,
    STEP,
    clear,
    first_step,
    gather,
)
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]

GROUND, WHEEL = 0, 1
FILTERS, STATES = 6, 4
"""Filters of a bank; each has [speed, acceleration, jerk, bias of the accelerometer]."""
LAGS = 5
"""Lags at which innovations are asked to be uncorrelated, 0.1 s."""

TUNING = np.dtype(
    [
        ("by_whiteness", "?"),
        ("jerk_psd", "f8", FILTERS),
        ("jerk_rate", "f8"),
        ("sd", "f8", MEASURED),
        ("bias_sd", "f8", 2),
        ("bias_psd", "f8"),
        ("memory_s", "f8"),
        ("floor", "f8"),
    ],
    align=True,
)
MEMORY = np.dtype(
    [
        ("step", STEP),
        ("known", "i8", 2),
        ("x", "f8", (2, FILTERS, STATES)),
        ("cov", "f8", (2, FILTERS, STATES, STATES)),
        ("weight", "f8", (2, FILTERS)),
        ("past", "f8", (2, FILTERS, LAGS, MEASURED)),
        ("correlation", "f8", (2, FILTERS, LAGS + 1, MEASURED)),
    ],
    align=True,
)


@dataclass(frozen=True, kw_only=True)
class FilterBank:
    """Two banks of six Kalman filters on all five measurements.

    A = [[1, dt, dt^2/2], [0, 1, dt], [0, 0, e^(-rate dt)]] (+) 1;  Q = diag(0, 0, psd dt, psd_b dt)
    likelihood:  w_m <- w_m N(e_m; 0, S_m), floored;   x = sum w_m x_m
    whiteness:   x = x_m of the least sum over lags l = 1 .. 5 of rho_l^2, rho_l the autocorrelation
                 of each measurement's innovation, forgotten with `memory_s`

    Source: Magill (1965), IEEE Trans. Autom. Control 10, 434 (likelihood); Mehra (1970), ibid. 15,
    175 (whiteness as the test of the gain).
    """

    rule: Literal["likelihood", "whiteness"] = "likelihood"
    """How the bank's filters are weighed."""
    jerk_psd_m2ps7: tuple[float, ...] = (0.1, 1.0, 10.0, 1e2, 1e3, 1e4)
    """Density of the white noise that drives the jerk, of each of the six filters."""
    jerk_rate_ps: float = 2.0
    """Rate at which jerk decays; without, long predictions run away."""
    front_sd_mps: float | None = None
    """sd of the front wheels' speed; None for the source's own."""
    gnss_sd_mps: float | None = None
    """sd of the GNSS speed; None for the receiver's own."""
    rear_sd_mps: float | None = None
    """sd of the driven wheels' speed; None for the source's own."""
    accel_sd_mps2: float = 0.06
    """sd of the body's acceleration, vibration included."""
    wheel_accel_sd_mps2: float = 0.06
    """sd of the driven wheels' acceleration."""
    bias_sd_mps2: float = 0.3
    """sd of the body accelerometer's bias at the start, tilt included: 2 degrees."""
    wheel_bias_sd_mps2: float = 0.3
    """sd of the wheel accelerometer's bias at the start."""
    bias_psd_m2ps5: float = 1e-4
    """Density of the biases' random walk."""
    memory_s: float = 5.0
    """Time over which the past of weights and correlations is forgotten."""
    floor: float = 1e-4
    """Least weight of a filter, so that it can come back."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        tuning["by_whiteness"], tuning["jerk_psd"] = self.rule == "whiteness", self.jerk_psd_m2ps7
        own = (self.front_sd_mps, self.gnss_sd_mps, self.rear_sd_mps)
        front, gnss, rear = (np.nan if sd is None else sd for sd in own)
        tuning["sd"] = (front, gnss, self.accel_sd_mps2, rear, self.wheel_accel_sd_mps2)
        tuning["jerk_rate"], tuning["bias_psd"] = self.jerk_rate_ps, self.bias_psd_m2ps5
        tuning["bias_sd"] = (self.bias_sd_mps2, self.wheel_bias_sd_mps2)
        tuning["memory_s"], tuning["floor"] = self.memory_s, self.floor
        memory = np.zeros(1, MEMORY)
        memory["step"], memory["weight"] = first_step(), 1.0 / FILTERS
        return begin(setup, tuning, memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        An out-of-order wheel sample gives no row.
        """
        return advance(_loop, state, chunk)


MMAE = FilterBank()
"""Bank of Kalman filters weighted by likelihood (multiple-model adaptive estimation)."""
WHITENESS = FilterBank(rule="whiteness")
"""Of a bank of Kalman filters, the one with the whitest innovations."""


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    count = 0
    for i in range(len(signals)):
        if gather(signals[i], nominal, memory.step):
            step = memory.step
            if step.dt_s > STALE_S:
                memory.known[GROUND] = memory.known[WHEEL] = 0
                step.flags |= RESTARTED
            for bank in range(2):
                _advance(bank, tuning, memory)
            ground, ground_var = _mixed(GROUND, memory)
            wheel, wheel_var = _mixed(WHEEL, memory)
            write_axle(rows[count], signals[i], nominal, ground, ground_var, wheel, wheel_var)
            rows[count].epoch_ns, rows[count].flags = step.epoch_ns, step.flags
            clear(step)
            count += 1
    return count


@compiled
def _advance(bank: int, tuning: Record, memory: Record) -> None:
    """One step of a bank: predict, update, weigh; begin with the first speed."""
    first, last = (FRONT_SPEED, BODY_ACCEL) if bank == GROUND else (REAR_SPEED, REAR_ACCEL)
    if not memory.known[bank]:
        _begin(bank, first, last, tuning, memory)
        return
    score = np.zeros(FILTERS)
    for m in range(FILTERS):
        x, cov = memory.x[bank, m], memory.cov[bank, m]
        _predict(x, cov, tuning.jerk_psd[m], tuning, memory.step.dt_s)
        for which in range(first, last + 1):
            normal, logarithm = _take(which, x, cov, tuning, memory.step)
            score[m] += logarithm
            if math.isfinite(normal):
                _correlate(bank, m, which, normal, tuning, memory)
    if tuning.by_whiteness:
        _choose(bank, first, last, memory)
    else:
        _weigh(bank, score, tuning, memory)


@compiled
def _variance(which: int, tuning: Record, step: Record) -> float:
    sd = tuning.sd[which]
    return float(step.sd[which] if math.isnan(sd) else sd) ** 2


@compiled
def _begin(bank: int, first: int, last: int, tuning: Record, memory: Record) -> None:
    """All filters with the first speed that came: [z, 0, 0, 0], sd 1 of acceleration and jerk."""
    for which in range(first, last):  # the last one is the acceleration
        variance, age = _variance(which, tuning, memory.step), memory.step.age_s[which]
        if memory.known[bank] or not math.isfinite(memory.step.z[which] + variance):
            continue
        memory.known[bank] = 1
        for m in range(FILTERS):
            memory.x[bank, m, :] = 0.0
            memory.cov[bank, m, :, :] = 0.0
            memory.x[bank, m, 0] = memory.step.z[which]
            memory.cov[bank, m, 0, 0] = variance + age * age
            memory.cov[bank, m, 1, 1] = memory.cov[bank, m, 2, 2] = 1.0
            memory.cov[bank, m, 3, 3] = tuning.bias_sd[bank] ** 2
            memory.weight[bank, m] = 1.0 / FILTERS


@compiled
def _predict(x: Array, cov: Array, jerk_psd: float, tuning: Record, dt: float) -> None:
    f, q = np.eye(STATES), np.zeros((STATES, STATES))
    f[0, 1] = f[1, 2] = dt
    f[0, 2] = 0.5 * dt * dt
    f[2, 2] = np.exp(-tuning.jerk_rate * dt)
    q[2, 2], q[3, 3] = jerk_psd * dt, tuning.bias_psd * dt
    predict(x, cov, f, q)


@compiled
def _take(which: int, x: Array, cov: Array, tuning: Record, step: Record) -> tuple[float, float]:
    """Take a measurement: e / sqrt(S) and log N(e; 0, S); NaN and 0 if none came."""
    tau, z, r = step.age_s[which], step.z[which], _variance(which, tuning, step)
    h = np.array([1.0, -tau, 0.5 * tau * tau, 0.0])
    if which in (BODY_ACCEL, REAR_ACCEL):
        h = np.array([0.0, 1.0, -tau, 1.0])
    innovation, variance = correct(x, cov, h, z, r)
    if math.isnan(innovation):
        return np.nan, 0.0
    squared = innovation * innovation / variance
    return innovation / math.sqrt(variance), -0.5 * (squared + np.log(variance))


@compiled
def _correlate(
    bank: int, m: int, which: int, normal: float, tuning: Record, memory: Record
) -> None:
    """Count an innovation into its autocorrelation at lags 0 to 5."""
    past, correlation = memory.past[bank, m, :, which], memory.correlation[bank, m, :, which]
    keep = np.exp(-memory.step.dt_s / tuning.memory_s)
    correlation[0] = keep * correlation[0] + normal * normal
    for lag in range(1, LAGS + 1):
        correlation[lag] = keep * correlation[lag] + normal * past[lag - 1]
    for lag in range(LAGS - 1, 0, -1):
        past[lag] = past[lag - 1]
    past[0] = normal


@compiled
def _choose(bank: int, first: int, last: int, memory: Record) -> None:
    """All weight to the filter of the whitest innovations."""
    best, least = 0, np.inf
    for m in range(FILTERS):
        total = 0.0
        for which in range(first, last + 1):
            power = memory.correlation[bank, m, 0, which]
            for lag in range(1, LAGS + 1):
                if power > 0.0:
                    total += (memory.correlation[bank, m, lag, which] / power) ** 2
        if total < least:
            best, least = m, total
    for m in range(FILTERS):
        memory.weight[bank, m] = 1.0 if m == best else 0.0


@compiled
def _weigh(bank: int, score: Array, tuning: Record, memory: Record) -> None:
    """w <- w^keep exp(score), floored and normalised."""
    weight, top, total = memory.weight[bank], score.max(), 0.0
    keep = np.exp(-memory.step.dt_s / tuning.memory_s)
    for m in range(FILTERS):
        weight[m] = weight[m] ** keep * np.exp(score[m] - top)
        total += weight[m]
    for m in range(FILTERS):
        weight[m] = max(weight[m] / total, tuning.floor)


@compiled
def _mixed(bank: int, memory: Record) -> tuple[float, float]:
    """Mean and variance of the bank's speed, the spread of its filters included."""
    if not memory.known[bank]:
        return np.nan, np.nan
    total, mean, variance = 0.0, 0.0, 0.0
    for m in range(FILTERS):
        total += memory.weight[bank, m]
        mean += memory.weight[bank, m] * memory.x[bank, m, 0]
    mean /= total
    for m in range(FILTERS):
        off = memory.x[bank, m, 0] - mean
        variance += memory.weight[bank, m] / total * (memory.cov[bank, m, 0, 0] + off * off)
    return mean, variance
