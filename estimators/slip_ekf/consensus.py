"""Which source is wrong, where a ground speed and the estimate disagree for long?

Each of the sources may be. The disagreement of a ground speed v with the others is

    sum over the other sources of min(((measured - v) / (share v))^2, 9)
"""

from __future__ import annotations

from estimators.kalman import Record
from estimators.slip_ekf.layout import FROM_CAMERA, FROM_DRIVEN, FROM_GNSS, FROM_TOWED, TOWED
from twin.compute.compiled import array_law

MOST_COST = 9.0
"""What it costs that a source is wrong: three sd."""
RECENT_S = 0.5
"""A source counts for so long after its last sample [s]."""
SPEED_SHARE, CAMERA_SHARE, SLIP_SHARE = 0.03, 0.1, 0.15
"""sd of what GNSS or towed wheels, a camera and driven wheels are off the ground speed, over it,
before anything of them is learnt [-]; a slip of up to 0.15 is common."""


CHANGE_SHARE, MOST_CHANGE = 0.04, 4.0
"""sd of a change of what is learnt of the towed wheels, and what it costs at most [-]."""


@array_law
def disagreement(v: float, asking: int, memory: Record) -> float:
    """What the sources beside the one that asks say against a ground speed [-]."""
    total = 0.0
    speed = max(abs(v), 0.5)
    for source in (FROM_GNSS, FROM_TOWED, FROM_CAMERA, FROM_DRIVEN):
        since = (memory.time_ns - memory.seen_ns[source]) * 1e-9
        stated = memory.seen_mps[source]
        if source == asking or memory.seen_ns[source] < 0 or since > RECENT_S:
            continue
        share = SPEED_SHARE
        if source == FROM_CAMERA:
            share = CAMERA_SHARE
        elif source == FROM_DRIVEN:
            share = SLIP_SHARE
        if source == FROM_TOWED:  # and that what is learnt of them has changed
            changed = ((stated / (1.0 + memory.x[TOWED]) - v) / (CHANGE_SHARE * speed)) ** 2
            total += min(changed, MOST_CHANGE)
        total += min(((stated - v) / (share * speed)) ** 2, MOST_COST)
    return total
