"""What no data sheet knows, learnt from the streams: noise of the sensors and of the motion."""

from __future__ import annotations

import math

from estimators.kalman import Record
from twin.compute.compiled import array_law

SETTLE = 100.0
"""Samples over which variances are averaged."""
CLIP = 9.0
"""A square counts at most as so many variances: an event is not noise."""
QUICK_S = 0.25
"""A source with longer steps than this shows the motion in its second differences [s]."""
FACTOR_RATE = 0.01
"""How fast a factor follows normalised innovations that are too large on average."""


@array_law
def white_var(source: int, speed: float, epoch_ns: int, stated_var: float, memory: Record) -> float:
    """Variance of the white noise of a source of speeds, never below what it states.

    d = z_k - 2 z_k-1 + z_k-2,   E d^2 = 6 var    for white noise; motion hardly enters d

    Slower sources are taken at their word: there the motion enters.
    """
    since = (epoch_ns - memory.white_ns[source]) * 1e-9
    last = memory.white_last[source]
    if memory.white_ns[source] < 0 or since > QUICK_S:
        memory.white_ns[source] = epoch_ns
        last[0] = speed
        last[1] = math.nan
        return stated_var
    square = (speed - 2.0 * last[0] + last[1]) ** 2 / 6.0
    if math.isfinite(square):
        square = min(square, CLIP * max(memory.white_var[source], stated_var))
        memory.white_var[source] += (square - memory.white_var[source]) / SETTLE
    last[1] = last[0]
    last[0] = speed
    memory.white_ns[source] = epoch_ns
    return float(max(memory.white_var[source], stated_var))


@array_law
def factor(now: float, nis: float, due: float, least: float, most: float) -> float:
    """A factor of a variance that grows while e^2 / S is on average above what is due.

    ln f <- ln f + pace (min(e^2 / S, 9) - due),   least <= f <= most
    """
    return min(max(now * math.exp(FACTOR_RATE * (min(max(nis, -CLIP), CLIP) - due)), least), most)
