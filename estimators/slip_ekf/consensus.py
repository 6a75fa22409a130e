"""Who is wrong, where a ground speed and the estimate disagree for long?

Every source may be wrong. A ground speed v costs what the sources that spoke last say against it,
each at most as much as its being wrong costs:

    cost(v) = sum over the other sources of min(((said - v) / (share v))^2, 9)
"""

from __future__ import annotations

from estimators.kalman import Record
from estimators.slip_ekf.layout import FROM_CAMERA, FROM_DRIVEN, FROM_GNSS, FROM_TOWED, TOWED
from twin.compute.compiled import array_law

WRONG = 9.0
"""What it costs that a source is wrong: three sd."""
RECENT_S = 0.5
"""A source that spoke within this time is heard [s]."""
SPEED_SHARE, CAMERA_SHARE, SLIP_SHARE = 0.03, 0.1, 0.15
"""sd of what GNSS or towed wheels, a camera and driven wheels are off the ground speed, over it,
before anything of them is learnt [-]; a slip of up to 0.15 is usual."""


CHANGE_SHARE, MOST_CHANGE = 0.04, 4.0
"""sd of a change of what is learnt of the towed wheels, and what it costs at most [-]."""


@array_law
def cost(v: float, asking: int, memory: Record) -> float:
    """What the sources beside the one that asks say against a ground speed [-]."""
    total = 0.0
    speed = max(abs(v), 0.5)
    for source in (FROM_GNSS, FROM_TOWED, FROM_CAMERA, FROM_DRIVEN):
        since = (memory.time_ns - memory.seen_ns[source]) * 1e-9
        said = memory.seen_mps[source]
        if source == asking or memory.seen_ns[source] < 0 or since > RECENT_S:
            continue
        share = SPEED_SHARE
        if source == FROM_CAMERA:
            share = CAMERA_SHARE
        elif source == FROM_DRIVEN:
            share = SLIP_SHARE
        if source == FROM_TOWED:  # and that what is learnt of them has changed
            changed = ((said / (1.0 + memory.x[TOWED]) - v) / (CHANGE_SHARE * speed)) ** 2
            total += min(changed, MOST_CHANGE)
        total += min(((said - v) / (share * speed)) ** 2, WRONG)
    return total
