"""Whether a ground speed is taken, refused, or the estimate put in doubt.

Refused while e^2 > gate^2 S. What goes on longer than `patience_s` is the truth, unless the other
sources speak against it (`consensus`). Then the estimate's variance grows by e^2 first, and the
same unknown moves the errors of those who held it up.
"""

from __future__ import annotations

import numpy as np

from estimators.innovations import note
from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.slip_ekf.consensus import cost
from estimators.slip_ekf.layout import (
    BIAS,
    CAMERA,
    FROM_CAMERA,
    FROM_GNSS,
    GATED,
    SIZE,
    TOWED,
    V,
)
from estimators.slip_ekf.update import grow, variance
from twin.compute.compiled import array_law

DOUBT = 1.0
"""Without an accelerometer the estimate itself is doubted by so much [-]."""
OFF_SHARE = 0.1
"""Share of a sample in the mean by which a source is off."""
BACK = 0.5
"""Once refused, a speed is taken again within this share of the gate."""
SLOW_MPS, MOST_SHARE = 0.5, 0.1
"""Below this speed an error says little of a scale, and none is off by more at once."""


@array_law
def heard(source: int, epoch_ns: int, speed: float, memory: Record) -> None:
    """A source gives a ground speed; what it was off by before a silence is forgotten."""
    if memory.seen_ns[source] >= 0 and epoch_ns - memory.seen_ns[source] > STALE_S * 1e9:
        memory.refused_ns[source] = -1
        if source == FROM_GNSS:
            memory.lean_ns = -1
    memory.seen_ns[source], memory.seen_mps[source] = epoch_ns, speed


@array_law
def judged(
    source: int, h: Array, error: float, r: float, press: float, tuning: Record, memory: Record
) -> bool:
    """Whether a speed is taken now.

    Args:
        source: which it is.
        h: its row, (SIZE,).
        error: what it says less what was foretold [m/s], or of a travel [m].
        r: its variance.
        press: what it counts that the source stays with what it says [1/s]; 0 for what repeats its
            last value to the bit, which proves nothing.
        tuning, memory: records; `memory` is changed.
    """
    total = variance(memory.p, h, r)
    note(memory.notes, error, total)
    nis = error**2 / total
    refused = memory.refused_ns[source] >= 0
    within = tuning.gate * (BACK if refused else 1.0)
    if nis <= within**2:
        memory.nis_sum[source] += nis
        memory.nis_count[source] += 1
        memory.refused_ns[source] = -1
        return True
    memory.flags |= GATED
    off = memory.seen_mps[source] - memory.x[V]
    if not refused:
        memory.refused_ns[source] = memory.time_ns
        memory.off_mps[source] = off
    memory.off_mps[source] += OFF_SHARE * (off - memory.off_mps[source])
    since = (memory.time_ns - memory.refused_ns[source]) * 1e-9
    if felt(memory) and since < tuning.patience_s:
        return False
    own = memory.x[V]
    said = own + memory.off_mps[source]
    pressed = press * since + (0.0 if felt(memory) else DOUBT)
    backed = cost(own, source, memory) + pressed >= cost(said, source, memory)
    if not backed and (source == FROM_GNSS or since < tuning.patience_s):
        return False
    doubt(source, said - own, max(since, tuning.patience_s), backed, memory)
    memory.refused_ns[source] = -1
    return True


@array_law
def felt(memory: Record) -> bool:
    """Whether an accelerometer tells a motion, which else only speeds can tell."""
    return bool(memory.accel_count > 0 and memory.time_ns - memory.accel_ns[0] < 1e9)


@array_law
def doubt(source: int, off: float, since: float, backed: bool, memory: Record) -> None:
    """A source is off by so much [m/s] for so long [s]: the estimate is wrong, or its scale is.

    Args:
        source: which it is.
        off: what it says less the estimate [m/s].
        since: for how long [s].
        backed: the others do not speak for the estimate.
        memory: record, changed.
    """
    way = np.zeros(SIZE)
    share = min(max(off / max(abs(memory.x[V]), SLOW_MPS), -MOST_SHARE), MOST_SHARE)
    if backed:
        way[V] = off
        way[BIAS] = -off / since
        if source == FROM_GNSS:
            way[TOWED] = way[CAMERA] = -share
        grow(memory.p, way, 1.0)
    elif source != FROM_GNSS:
        way[CAMERA if source == FROM_CAMERA else TOWED] = share
        grow(memory.p, way, 1.0)
