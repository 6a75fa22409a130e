"""Samples wait a little, so that late ones find their place, and are taken in order of epoch."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.sideslip_ekf.layout import CAMERA, FRAME, IMU, ROOM, VALUES
from twin.compute.compiled import array_law

MOST_LAG_NS, FORGET = 300_000_000, 100_000
"""No sample waits longer than this [ns]; a longest delay is forgotten over so many samples."""
USUAL_S, LONGEST_S = 1.0 / 30.0, 5.0
"""Between two frames, where a stream does not tell; more is no interval [s]."""


@array_law
def arrive(epoch_ns: int, memory: Record) -> None:
    """Time goes on to a sample's epoch; how late samples come is how long all of them wait."""
    memory.newest_ns = max(memory.newest_ns, epoch_ns)
    late = min(memory.newest_ns - epoch_ns, MOST_LAG_NS)
    memory.lag_ns = max(late, memory.lag_ns - memory.lag_ns // FORGET)


@array_law
def wait(epoch_ns: int, sensor: int, values: Array, memory: Record) -> None:
    """Put a sample at its place among those that wait; the last of two of one epoch goes last."""
    at = memory.count
    while at > 0 and memory.waiting[at - 1].epoch_ns > epoch_ns:
        memory.waiting[at].epoch_ns = memory.waiting[at - 1].epoch_ns
        memory.waiting[at].sensor = memory.waiting[at - 1].sensor
        for i in range(VALUES):
            memory.waiting[at].values[i] = memory.waiting[at - 1].values[i]
        at -= 1
    memory.waiting[at].epoch_ns, memory.waiting[at].sensor = epoch_ns, sensor
    for i in range(VALUES):
        memory.waiting[at].values[i] = values[i] if i < len(values) else np.nan
    memory.count += 1


@array_law
def wait_frame(epoch_ns: int, values: Array, memory: Record) -> None:
    """A velocity of the camera: forward speed at the middle, both at the end of its interval.

    The height errs along the velocity; a covariance's smaller eigenvalue is without that.
    """
    ahead, left, var_x, var_y, cov = values[0], values[1], values[2], values[3], values[4]
    half = math.hypot(0.5 * (var_x - var_y), cov)
    variance = max(0.5 * (var_x + var_y) - half, 1e-10)
    if not math.isfinite(ahead + left + half):
        return
    span_s = values[5] if 0.0 < values[5] < LONGEST_S else USUAL_S
    told = np.empty(6)
    told[0], told[1], told[2], told[3] = ahead, left, variance, span_s
    told[4], told[5] = values[7], values[8]
    wait(epoch_ns, CAMERA, told, memory)
    wait(epoch_ns + round(0.5e9 * span_s), FRAME, told, memory)


@array_law
def first_is_due(memory: Record) -> bool:
    """Whether the oldest sample has waited long enough; at once where no room is left."""
    if memory.count == 0:
        return False
    old = memory.waiting[0].epoch_ns <= memory.newest_ns - memory.lag_ns - memory.lag_ns // 4
    return bool(old or memory.count > ROOM - 3)


@array_law
def drop_first(memory: Record) -> None:
    """The oldest sample is taken."""
    for k in range(1, memory.count):
        memory.waiting[k - 1].epoch_ns = memory.waiting[k].epoch_ns
        memory.waiting[k - 1].sensor = memory.waiting[k].sensor
        for i in range(VALUES):
            memory.waiting[k - 1].values[i] = memory.waiting[k].values[i]
    memory.count -= 1


@array_law
def imu_at(epoch_ns: int, memory: Record, out: Array) -> None:
    """The IMU at an epoch: linear up to the next sample that waits, held where there is none.

    Args:
        epoch_ns: when.
        memory: record.
        out: rates and forces, (5,), filled.
    """
    out[:] = memory.imu
    for k in range(memory.count):
        if memory.waiting[k].sensor != IMU:
            continue
        share = 1.0
        if memory.waiting[k].epoch_ns > memory.epoch_ns:
            span = memory.waiting[k].epoch_ns - memory.epoch_ns
            share = min(max((epoch_ns - memory.epoch_ns) / span, 0.0), 1.0)
        for i in range(5):
            value = memory.waiting[k].values[i]
            if not math.isfinite(value):
                continue
            out[i] += share * (value - out[i]) if memory.imu_ns >= 0 else value - out[i]
        return
