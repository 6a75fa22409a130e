"""Noise of counters: of the instants at which they are read, and of each axle's count."""

from __future__ import annotations

import math

from estimators.kalman import Record
from estimators.slip_ekf.layout import FROM_TOWED
from twin.compute.compiled import array_law

SETTLE, SLOW_MPS = 100.0, 0.2
"""Samples over which the noise of the counts is averaged, and the speed above which [m/s]."""


@array_law
def learn_jitter(rear: float, front: float, step_s: float, memory: Record) -> None:
    """Variance of the instants of reading and of each axle's count, from second differences.

    d = c_k - 2 c_k-1 + c_k-2 of the counted travels c; of the motion hardly anything enters d

        E d_rear d_front = 6 w v jitter
        E (d_rear - w / v d_front)^2 = 6 (1 + (w / v)^2) count

    Where one axle alone is counted, E d^2 = 6 count: its jitter is taken for noise of the count.
    """
    counted = (rear * step_s, front * step_s)
    even = step_s / memory.step_s if memory.step_s > 0.0 else math.nan
    d_rear = counted[0] - memory.step[0] * even
    d_front = counted[1] - memory.step[1] * even
    memory.step[0], memory.step[1], memory.step_s = counted[0], counted[1], step_s
    if abs(rear) < SLOW_MPS:
        return
    memory.counted += 1
    gain = 1.0 / min(memory.counted + 5.0, SETTLE)
    if math.isfinite(d_rear * d_front) and abs(front) > SLOW_MPS:
        ratio = rear / front
        memory.jitter_var = _follow(
            memory.jitter_var, d_rear * d_front / (6.0 * rear * front), gain
        )
        own = (d_rear - ratio * d_front) ** 2 / (6.0 * (1.0 + ratio**2))
        memory.count_var = _follow(memory.count_var, own, gain)
    elif math.isfinite(d_rear) and memory.time_ns - memory.seen_ns[FROM_TOWED] > 1e9:
        memory.jitter_var = 0.0
        memory.count_var = _follow(memory.count_var, d_rear**2 / 6.0, gain)


@array_law
def _follow(now: float, found: float, gain: float) -> float:
    """A variance follows what is found, of which nine times as much counts at most."""
    some = max(now, 1e-8)
    return max(now + gain * (min(max(found, -some), 9.0 * some) - now), 0.0)
