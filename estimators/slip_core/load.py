"""The line from load to slip: learnt while GNSS is there, and used always.

    slip = c_0 + c . load + e,   c <- c + K (slip - c_0 - c . load)   (recursive least squares)

What the load changes by moves the usual slip by c times that. Draft, torque and fuel rise
together: which of them is told the more is the prior's, and does not matter.
"""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.slip_core.held import FIRST_LOAD, HELD
from estimators.slip_core.layout import USUAL, V, W
from twin.compute.compiled import law

PRIOR_SD, OFFSET_SD = 0.05, 0.2
"""sd of the slip that comes of one usual change of a load, and of slip at no load."""
WALK = 1e-7
"""Density of the walk of the line, as the ground changes [1/s]."""
SCATTER_SD, SCATTER_S = 0.02, 1.0
"""sd of what slip is off the line by, and how long that lasts [s]."""
MOST_SLIP = 0.6


@law
def follow(loads: Array, memory: Record) -> None:
    """Move the usual slip by what the load has changed since the last sample."""
    change = 0.0
    for i in range(FIRST_LOAD, HELD):
        if math.isfinite(loads[i]) and math.isfinite(memory.load[i]):
            change += memory.line[i] * (loads[i] - memory.load[i])
    memory.x[USUAL] = min(max(memory.x[USUAL] + change, -MOST_SLIP), MOST_SLIP)
    memory.load[:] = loads


@law
def learn_line(dt: float, memory: Record) -> None:
    """Learn the line from the slip of now; a load that nobody tells counts as none."""
    load, c, p = memory.load, memory.line, memory.line_p
    z = load.copy()
    z[0] = 1.0
    told = 0
    for i in range(FIRST_LOAD, HELD):
        if math.isfinite(z[i]):
            told += 1
        else:
            z[i] = 0.0
    if told == 0:
        return
    if p[0, 0] == 0.0:
        for i in range(HELD):
            p[i, i] = PRIOR_SD**2 if i else OFFSET_SD**2
    error = 1.0 - memory.x[V] / memory.x[W]
    total = SCATTER_SD**2 * (1.0 + 2.0 * SCATTER_S / dt)
    pz = z.copy()
    for i in range(HELD):
        p[i, i] += WALK * dt
        error -= c[i] * z[i]
        pz[i] = 0.0
        for j in range(HELD):
            pz[i] += p[i, j] * z[j]
    for i in range(HELD):
        total += z[i] * pz[i]
    for i in range(HELD):
        c[i] += pz[i] * error / total
        for j in range(HELD):
            p[i, j] -= pz[i] * pz[j] / total
