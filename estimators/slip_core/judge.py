"""Whether a ground speed is taken, refused, or the estimate put in doubt.

Refused while e^2 > gate^2 S. What goes on longer than `patience_s` is the truth, unless the other
sources speak against it (`consensus`). Then the estimate's variance grows by e^2 first, and the
same unknown moves the errors of those who held it up.
"""

from __future__ import annotations

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_core.consensus import cost
from estimators.slip_core.layout import (
    BIAS,
    CAMERA,
    FROM_CAMERA,
    FROM_GNSS,
    GATED,
    SIZE,
    TOWED,
    V,
)
from estimators.slip_core.update import grow, variance
from twin.compute.compiled import law

BACK = 0.5
"""Once refused, a speed is taken again within this share of the gate."""
PRESS = 1.0
"""By so much per second counts that GNSS stays with what it says [1/s]."""
FRESH_S = 2.0
"""GNSS that was taken within this time is who tells the others' scales [s]."""
SLOW_MPS = 0.5
"""Below this speed an error says little of a scale."""


@law
def judged(
    source: int, h: Array, error: float, r: float, repeated: bool, tuning: Record, memory: Record
) -> bool:
    """Whether a speed is taken now.

    Args:
        source: which it is.
        h: its row, (SIZE,).
        error: what it says less what was foretold [m/s], or of a travel [m].
        r: its variance.
        repeated: it is the last value to the bit: that it stays with what it says proves nothing.
        tuning, memory: records; `memory` is changed.
    """
    total = variance(memory.p, h, r)
    nis = error**2 / total
    refused = memory.refused_ns[source] >= 0
    within = tuning.gate * (BACK if refused else 1.0)
    if nis <= within**2:
        memory.nis_sum[source] += nis
        memory.nis_count[source] += 1
        memory.refused_ns[source] = -1
        return True
    memory.flags |= GATED
    if not refused:
        memory.refused_ns[source] = memory.time_ns
        return False
    since = (memory.time_ns - memory.refused_ns[source]) * 1e-9
    if since < tuning.patience_s:
        return False
    off = memory.seen_mps[source] - memory.x[V]
    if source == FROM_GNSS:
        press = 0.0 if repeated else PRESS * since
        if cost(memory.x[V], memory) + press < cost(memory.seen_mps[source], memory):
            return False
    doubt(source, off, since, memory)
    memory.refused_ns[source] = -1
    return True


@law
def doubt(source: int, off: float, since: float, memory: Record) -> None:
    """A source has been off by so much [m/s] for so long [s], and the estimate may be wrong.

    While GNSS is taken, it is the source's own scale that has changed.
    """
    way = np.zeros(SIZE)
    fresh = memory.refused_ns[FROM_GNSS] < 0 and (
        memory.time_ns - memory.seen_ns[FROM_GNSS] < FRESH_S * 1e9
    ) and memory.seen_ns[FROM_GNSS] >= 0
    speed = max(abs(memory.x[V]), SLOW_MPS)
    if source == FROM_GNSS or not fresh:
        way[V] = off
        way[BIAS] = -off / since
        if source == FROM_GNSS:
            way[TOWED] = way[CAMERA] = -off / speed
        grow(memory.p, way, 1.0)
        way[V] = way[BIAS] = 0.0
    if source != FROM_GNSS:
        way[CAMERA if source == FROM_CAMERA else TOWED] = off / speed
        grow(memory.p, way, 1.0)
