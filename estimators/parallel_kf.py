"""The parallel Kalman filters of the IMA-PKF paper without its optimiser, and a tuned one.

Every filter here has x = [v, a, j] for the ground and [w, a_w, j_w] for the driven wheels. The
paper's six states are these two blocks: A, Q and the rows of H connect nothing across them. Beside
each stands an accelerometer bias b, and beside the ground's what the front wheels are off by, c;
they are zero where their standard deviation is set to zero, as in the paper.

One module, because the filters of this family differ in tuning alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from estimators.estimate import State, advance, begin, each_sample, too_old, write_axle
from estimators.fusion import fuse
from estimators.innovations import NOTES, each_innovation, innovations, note
from estimators.kalman import Record, correct, predict
from estimators.layout import (
    GNSS,
    IMU,
    NO_GROUND_SPEED,
    RESTARTED,
    SILENT_S,
    STALE_S,
    WHEELS,
)
from estimators.wheel_speed import driven_mean, mean_variance, towed_mean
from twin.compute.compiled import compiled
from twin.streams import Setup, Streams, Table

WHEEL = 2
"""Channel of the driven wheels; 0 and 1 are the ground's, one per observer."""
BIAS, FRONT_OFFSET, SIZE = 3, 4, 5
"""Indices of b and c in a channel [speed, acceleration, jerk, b, c], and its size."""
STEP_S = 0.02
"""The paper's sampling period, to which its Q belongs."""

TUNING = np.dtype(
    [
        ("takes_front", "i8", 2),
        ("takes_gnss", "i8", 2),
        ("process_var", "f8", 3),
        ("front_sd", "f8"),
        ("gnss_sd", "f8"),
        ("accel_sd", "f8"),
        ("rear_sd", "f8"),
        ("wheel_accel_sd", "f8"),
        ("bias_sd", "f8"),
        ("wheel_bias_sd", "f8"),
        ("bias_psd", "f8"),
        ("front_offset_sd", "f8"),
        ("front_offset_psd", "f8"),
    ],
    align=True,
)
MEMORY = np.dtype(
    [
        ("time_ns", "i8"),
        ("measured_ns", "i8"),
        ("flags", "i8"),
        ("known", "i8", 3),
        ("x", "f8", (3, SIZE)),
        ("cov", "f8", (3, SIZE, SIZE)),
        ("notes", NOTES),
    ],
    align=True,
)


@dataclass(frozen=True, kw_only=True)
class ParallelKf:
    """One or two observers of the ground speed beside one of the wheels', fused at the end.

    A = [[1, dt, dt^2/2], [0, 1, dt], [0, 0, 1]] for each block, over the true step; Q dt / 0.02 s
    rows: v + c (front wheels), v (GNSS), a + b (body accelerometer); w (driven wheels), a_w + b_w
    where a source measures it. A row is dropped where there is no measurement.
    Fusion: x = W1 x1 + W2 x2,  W_i = (P1^-1 + P2^-1)^-1 P_i^-1

    Speeds of some time ago (ticks, late samples) are v - a tau + j tau^2/2. Front wheels count as
    ground speed only if they are not driven. Both observers share the accelerometer and the process
    noise; inverse-P fusion takes them as independent, so the slip_sd of two observers is too small.

    Source: IMA-PKF paper (INMATEH 77-13), eq. (1)-(10), with the four rows of H that are not zero.
    The paper prints no Q; its R is the default here.
    """

    observers: tuple[tuple[str, ...], ...]
    """For each observer, one or two, what measures its ground speed: "front", "gnss" or both."""
    process_var: tuple[float, float, float]
    """Diagonal of Q per 0.02 s, of speed, acceleration and jerk [m2/s2, m2/s4, m2/s6]."""
    front_sd_mps: float | None = 0.10
    """sd of the front wheels' speed; None for the source's own. 0.10 in the paper's R1."""
    gnss_sd_mps: float | None = 0.13
    """sd of the GNSS speed; None for the receiver's own. 0.13 in the paper's R2."""
    accel_sd_mps2: float = 0.06
    """sd of the body acceleration; 0.06 in the paper."""
    rear_sd_mps: float | None = 0.11
    """sd of the driven wheels' mean speed; None for the source's own. 0.11 in the paper."""
    wheel_accel_sd_mps2: float = 0.06
    """sd of the wheels' acceleration; 0.06 in the paper, which names no sensor for it."""
    bias_sd_mps2: float = 0.0
    """sd of the body accelerometer's bias at the start, tilt included; 0 in the paper."""
    wheel_bias_sd_mps2: float = 0.0
    """sd of the wheel accelerometer's bias at the start; 0 in the paper."""
    bias_psd_m2ps5: float = 0.0
    """Density of the biases' random walk [m2/s5]."""
    front_offset_sd_mps: float = 0.0
    """sd of what the front wheels' speed is off by, from their radius and skid; 0 in the paper."""
    front_offset_psd_m2ps3: float = 0.0
    """Density of that offset's random walk [m2/s3]."""

    tunable: ClassVar[Mapping[str, str]] = {
        "process_var.1": "assumed",
        "process_var.2": "assumed",
        "accel_sd_mps2": "assumed",
        "wheel_accel_sd_mps2": "assumed",
        "bias_psd_m2ps5": "assumed",
        "front_offset_psd_m2ps3": "assumed",
    }
    """Fields that `twin tune` finds from innovations -> grade of the values above."""

    def init(self, setup: Setup) -> State:
        """The state before the first sample."""
        tuning = np.zeros(1, TUNING)
        for i, sources in enumerate(self.observers):
            tuning["takes_front"][0, i] = "front" in sources
            tuning["takes_gnss"][0, i] = "gnss" in sources
        tuning["process_var"] = self.process_var
        tuning["front_sd"] = np.nan if self.front_sd_mps is None else self.front_sd_mps
        tuning["gnss_sd"] = np.nan if self.gnss_sd_mps is None else self.gnss_sd_mps
        tuning["rear_sd"] = np.nan if self.rear_sd_mps is None else self.rear_sd_mps
        tuning["accel_sd"] = self.accel_sd_mps2
        tuning["wheel_accel_sd"] = self.wheel_accel_sd_mps2
        tuning["bias_sd"], tuning["wheel_bias_sd"] = self.bias_sd_mps2, self.wheel_bias_sd_mps2
        tuning["bias_psd"] = self.bias_psd_m2ps5
        tuning["front_offset_sd"] = self.front_offset_sd_mps
        tuning["front_offset_psd"] = self.front_offset_psd_m2ps3
        memory = np.zeros(1, MEMORY)
        memory["time_ns"] = memory["measured_ns"] = -1
        return begin(setup, tuning, memory)

    def run(self, state: State, chunk: Streams) -> tuple[State, Table]:
        """The state after the chunk, and a table with one row per accepted wheel sample.

        A wheel sample that is not newer than the last one, or over 5 s older than the newest sample
        of any sensor, gives no row.
        """
        return advance(_loop, state, chunk)

    def innovations(self, setup: Setup, streams: Streams) -> Table:
        """Innovation of each measurement of each observer, and its predicted variance."""
        return innovations(_innovations, self.init(setup), streams)


KF_Z2 = ParallelKf(observers=(("gnss",),), process_var=(1.0, 1.0, 1.0))
"""Kalman filter with observer Z2 alone and Q = I: the paper's "KF", read from its figures."""

PKF = ParallelKf(observers=(("front",), ("gnss",)), process_var=(1e-3, 1e-3, 1e-3))
"""Parallel Kalman filter with fixed Q = 1e-3 I: the paper's filter without its optimiser."""

KF_TUNED = ParallelKf(
    observers=(("front", "gnss"),),
    process_var=(1e-8, 4e-3, 1e-4),
    front_sd_mps=None,
    gnss_sd_mps=None,
    rear_sd_mps=None,
    accel_sd_mps2=0.2,
    bias_sd_mps2=0.5,
    wheel_bias_sd_mps2=0.1,
    bias_psd_m2ps5=1e-3,
    front_offset_sd_mps=0.05,
    front_offset_psd_m2ps3=1e-5,
)
"""Kalman filter of all five measurements with physical noise values in place of tuned ones.

Process noise: a white jerk of 0.2 m2/s5 (0.3 m/s2 that decorrelates in about 1 s). Measurement
noise: the sensors' own sd, 0.2 m/s2 of vibration, 3 degrees of tilt. The front wheels are 3 % of a
working speed off, by their radius and by their skid under motion resistance."""


@compiled
def _loop(signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any) -> int:
    return each_sample(_take, signals, nominal, tuning, memory, rows)


@compiled
def _innovations(
    signals: Any, nominal: Record, tuning: Record, memory: Record, rows: Any, kept: Any
) -> int:
    return each_innovation(_take, signals, nominal, tuning, memory, rows, kept)


@compiled
def _take(signal: Record, nominal: Record, tuning: Record, memory: Record, row: Record) -> bool:
    _carry(signal.epoch_ns, tuning, memory)
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if too_old(signal, memory):
        return False
    if signal.sensor == GNSS:
        _take_gnss(signal, age, tuning, memory)
    elif signal.sensor == IMU:
        for channel in range(2):
            _take_accel(channel, signal.accel_mps2, tuning.accel_sd, memory)
    elif signal.sensor == WHEELS:
        _take_front(signal, age, nominal, tuning, memory)
        _take_driven(signal, age, nominal, tuning, memory)
        _report(row, signal, nominal, memory)
        return True
    return False


@compiled
def _carry(epoch_ns: int, tuning: Record, memory: Record) -> None:
    """Predict to a newer epoch; start again after a gap, and doubt biases after a silence."""
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns >= 0 and dt > STALE_S:
        memory.known[:] = 0
        memory.flags |= RESTARTED
    elif memory.time_ns >= 0 and dt > 0.0:
        f, q = np.eye(SIZE), np.zeros((SIZE, SIZE))
        f[0, 1] = f[1, 2] = dt
        f[0, 2] = 0.5 * dt * dt
        for i in range(3):
            q[i, i] = tuning.process_var[i] * dt / STEP_S
        q[BIAS, BIAS] = tuning.bias_psd * dt
        q[FRONT_OFFSET, FRONT_OFFSET] = tuning.front_offset_psd * dt
        for channel in range(3):
            if memory.known[channel]:
                predict(memory.x[channel], memory.cov[channel], f, q)
        if dt > SILENT_S:
            memory.cov[0, BIAS, BIAS] += tuning.bias_sd**2
            memory.cov[1, BIAS, BIAS] += tuning.bias_sd**2
            memory.cov[WHEEL, BIAS, BIAS] += tuning.wheel_bias_sd**2
    memory.time_ns = max(memory.time_ns, epoch_ns)


@compiled
def _take_speed(
    channel: int, speed: float, variance: float, age: float, of_front: float, memory: Record
) -> int:
    """Measure v - a age + j age^2/2 + of_front c. Returns 1 if it would be the first."""
    if not (math.isfinite(speed) and math.isfinite(variance)):
        return 0
    if not memory.known[channel]:
        return 1
    h = np.array([1.0, -age, 0.5 * age * age, 0.0, of_front])
    note(memory.notes, *correct(memory.x[channel], memory.cov[channel], h, speed, variance))
    return 0


@compiled
def _begin(
    channel: int, speed: float, variance: float, bias_sd: float, offset_sd: float, memory: Record
) -> None:
    """Begin a channel with its first speed: [z, 0, 0, 0, 0], sd 1 of acceleration and jerk."""
    memory.known[channel] = 1
    memory.x[channel, :] = 0.0
    memory.cov[channel, :, :] = 0.0
    memory.x[channel, 0] = speed
    memory.cov[channel, 0, 0] = variance
    memory.cov[channel, 1, 1] = memory.cov[channel, 2, 2] = 1.0
    memory.cov[channel, BIAS, BIAS] = bias_sd**2
    memory.cov[channel, FRONT_OFFSET, FRONT_OFFSET] = offset_sd**2


@compiled
def _take_accel(channel: int, accel: float, sd: float, memory: Record) -> None:
    """Measure a + b."""
    if memory.known[channel]:
        h = np.array([0.0, 1.0, 0.0, 1.0, 0.0])
        note(memory.notes, *correct(memory.x[channel], memory.cov[channel], h, accel, sd**2))


@compiled
def _take_gnss(signal: Record, age: float, tuning: Record, memory: Record) -> None:
    sd = signal.v_sd_mps if math.isnan(tuning.gnss_sd) else tuning.gnss_sd
    if math.isfinite(signal.v_x_mps):
        memory.measured_ns = signal.epoch_ns
    for channel in range(2):
        if not tuning.takes_gnss[channel]:
            continue
        if _take_speed(channel, signal.v_x_mps, sd**2, age, 0.0, memory):
            first_var, offset_sd = sd**2 + age**2, tuning.front_offset_sd
            _begin(channel, signal.v_x_mps, first_var, tuning.bias_sd, offset_sd, memory)


@compiled
def _take_front(
    signal: Record, age: float, nominal: Record, tuning: Record, memory: Record
) -> None:
    speed = towed_mean(signal.wheel_mps, nominal)
    variance = mean_variance(signal.wheel_sd_mps, nominal, 0.0, signal.one_towed_speed)
    if not math.isnan(tuning.front_sd):
        variance = tuning.front_sd**2
    tau = age + signal.wheel_age_s.max()
    for channel in range(2):
        if tuning.takes_front[channel]:
            if math.isfinite(speed):
                memory.measured_ns = signal.epoch_ns
            if _take_speed(channel, speed, variance, tau, 1.0, memory):
                offset_sd = tuning.front_offset_sd
                first_var = variance + tau**2 + offset_sd**2
                _begin(channel, speed, first_var, tuning.bias_sd, offset_sd, memory)
                memory.cov[channel, 0, FRONT_OFFSET] = -(offset_sd**2)
                memory.cov[channel, FRONT_OFFSET, 0] = -(offset_sd**2)


@compiled
def _take_driven(
    signal: Record, age: float, nominal: Record, tuning: Record, memory: Record
) -> None:
    speed = driven_mean(signal.wheel_mps, nominal)
    variance = mean_variance(signal.wheel_sd_mps, nominal, 1.0, signal.one_driven_speed)
    if not math.isnan(tuning.rear_sd):
        variance = tuning.rear_sd**2
    tau = age + signal.wheel_age_s.max()
    if _take_speed(WHEEL, speed, variance, tau, 0.0, memory):
        _begin(WHEEL, speed, variance + tau**2, tuning.wheel_bias_sd, 0.0, memory)
    accel = driven_mean(signal.wheel_accel_mps2, nominal)
    _take_accel(WHEEL, accel, tuning.wheel_accel_sd, memory)


@compiled
def _report(row: Record, signal: Record, nominal: Record, memory: Record) -> None:
    """Fuse what there is of the two observers and write the estimate at the filter's time."""
    ground, ground_var, wheel, wheel_var = np.nan, np.nan, np.nan, np.nan
    if memory.known[0] and memory.known[1]:
        p1 = np.ascontiguousarray(memory.cov[0, :3, :3])
        p2 = np.ascontiguousarray(memory.cov[1, :3, :3])
        x, p = fuse(memory.x[0, :3], p1, memory.x[1, :3], p2)
        ground, ground_var = x[0], p[0, 0]
    else:
        for channel in range(2):
            if memory.known[channel]:
                ground, ground_var = memory.x[channel, 0], memory.cov[channel, 0, 0]
    if math.isnan(ground) or (memory.time_ns - memory.measured_ns) * 1e-9 > STALE_S:
        memory.flags |= NO_GROUND_SPEED
    if memory.known[WHEEL]:
        wheel, wheel_var = memory.x[WHEEL, 0], memory.cov[WHEEL, 0, 0]
    write_axle(row, signal, nominal, ground, ground_var, wheel, wheel_var)
    row.epoch_ns, row.flags = memory.time_ns, memory.flags
    memory.flags = 0
