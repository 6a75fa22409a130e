"""Whether a ground speed is accepted or refused, or the covariance is inflated.

Refused while e^2 > gate^2 S. What goes on longer than `hold_s` is the truth, unless the other
sources speak against it (`consensus`). Then the estimate's variance grows by e^2 first, and the
same unknown moves the errors of those who held it up.
"""

from __future__ import annotations

import numpy as np

from estimators.innovations import note
from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.slip_ekf.consensus import disagreement
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

NO_IMU_EVIDENCE = 1.0
"""Evidence against the estimate without an accelerometer [-]."""
OFF_SHARE = 0.1
"""Share of a sample in the mean by which a source is off."""
HYSTERESIS = 0.5
"""Once refused, a speed is taken again within this share of the gate."""
GAP_STEPS = 10.0
"""A step of more intervals of the accelerometer than this is a gap, as for counters."""
SLOW_MPS, MOST_SHARE = 0.5, 0.1
"""Below this speed a scale's error is not seen; the most that a scale changes at once."""


@array_law
def note_speed(source: int, epoch_ns: int, speed: float, memory: Record) -> None:
    """A source gives a ground speed; what it was off by before a silence is forgotten."""
    if memory.seen_ns[source] >= 0 and epoch_ns - memory.seen_ns[source] > STALE_S * 1e9:
        memory.refused_ns[source] = -1
        if source == FROM_GNSS:
            memory.mean_innovation_ns = -1
    memory.seen_ns[source], memory.seen_mps[source] = epoch_ns, speed


@array_law
def accepted(
    source: int,
    h: Array,
    error: float,
    r: float,
    evidence_ps: float,
    tuning: Record,
    memory: Record,
) -> bool:
    """Whether a speed is taken now.

    Args:
        source: which it is.
        h: its row, (SIZE,).
        error: innovation [m/s], or of a travel [m].
        r: its variance.
        evidence_ps: evidence for the source for each second that it is refused [1/s]; 0 for one
            that repeats its last value to the bit.
        tuning, memory: records; `memory` is changed.
    """
    total = variance(memory.p, h, r)
    note(memory.notes, error, total)
    nis = error**2 / total
    refused = memory.refused_ns[source] >= 0
    within = tuning.gate * (HYSTERESIS if refused else 1.0)
    if nis <= within**2:
        memory.nis_sum[source] += nis
        memory.nis_count[source] += 1
        memory.refused_ns[source] = -1
        return True
    memory.flags |= GATED
    off = memory.seen_mps[source] - memory.x[V]
    if not refused:
        memory.refused_ns[source] = memory.time_ns
        memory.mean_error_mps[source] = off
    memory.mean_error_mps[source] += OFF_SHARE * (off - memory.mean_error_mps[source])
    since = (memory.time_ns - memory.refused_ns[source]) * 1e-9
    if has_accelerometer(memory) and since < tuning.hold_s:
        return False
    own = memory.x[V]
    stated = own + memory.mean_error_mps[source]
    evidence = evidence_ps * since + (0.0 if has_accelerometer(memory) else NO_IMU_EVIDENCE)
    supported = disagreement(own, source, memory) + evidence >= disagreement(stated, source, memory)
    if not supported and (source == FROM_GNSS or since < tuning.hold_s):
        return False
    inflate(source, stated - own, max(since, tuning.hold_s), supported, memory)
    memory.refused_ns[source] = -1
    return True


@array_law
def has_accelerometer(memory: Record) -> bool:
    """Whether an accelerometer has given a sample within a second."""
    return bool(memory.accel_ns[0] >= 0 and memory.time_ns - memory.accel_ns[0] < 1e9)


@array_law
def forget_accelerations(dt: float, memory: Record) -> None:
    """No accelerometer saw how the motion changed in a step of much more than its interval.

    Args:
        dt: the step [s].
        memory: record, changed.
    """
    newest, before = memory.accel_ns[0], memory.accel_ns[1]
    if before >= 0 and dt > GAP_STEPS * (newest - before) * 1e-9:
        memory.accel_ns[:] = -1


@array_law
def inflate(source: int, off: float, since: float, supported: bool, memory: Record) -> None:
    """A source is off by so much [m/s] for so long [s]: the estimate is wrong, or its scale is.

    Args:
        source: which it is.
        off: what it measures less the estimate [m/s].
        since: for how long [s].
        supported: the others do not speak for the estimate.
        memory: record, changed.
    """
    direction = np.zeros(SIZE)
    share = min(max(off / max(abs(memory.x[V]), SLOW_MPS), -MOST_SHARE), MOST_SHARE)
    if supported:
        direction[V] = off
        direction[BIAS] = -off / since
        if source == FROM_GNSS:
            direction[TOWED] = direction[CAMERA] = -share
        grow(memory.p, direction, 1.0)
    elif source != FROM_GNSS:
        direction[CAMERA if source == FROM_CAMERA else TOWED] = share
        grow(memory.p, direction, 1.0)
