"""The line from load to slip: learnt while GNSS is there, and used always.

    slip = usual + line . (load - mean load) + e     (recursive least squares, with an intercept)

Draft, torque and fuel rise together: which of them is told the more is the prior's, and does not
matter.
"""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.slip_ekf.held import HELD
from estimators.slip_ekf.layout import USUAL
from twin.compute.compiled import array_law

PRIOR_SD, OFFSET_SD = 0.05, 0.2
"""sd of the slip that comes of one usual change of a load, and of the intercept."""
WALK = 1e-7
"""Density of the walk of the line, as the ground changes [1/s]."""
SCATTER_S, MEAN_S = 1.0, 60.0
"""How long slip stays off the line, and time over which the mean load is taken [s]."""
MOST_BY_LOAD = 0.3
"""Slip that a load makes at most beside the usual one."""
ROBUST = 3.0
"""A slip further off the line than this many sd counts as this many."""


@array_law
def centred(loads: Array, memory: Record, z: Array) -> None:
    """Fill z = (1, load - mean load); 0 for a load that nobody tells, or has told before."""
    z[0] = 1.0
    for i in range(1, HELD):
        off = loads[i] - memory.mean_load[i]
        z[i] = off if math.isfinite(off) else 0.0


@array_law
def by_load(z: Array, memory: Record) -> tuple[float, float]:
    """Slip beside the usual one that the load makes, and its variance."""
    slip, var = 0.0, 0.0
    for i in range(1, HELD):
        slip += memory.line[i] * z[i]
        for j in range(1, HELD):
            var += z[i] * memory.line_p[i, j] * z[j]
    return min(max(slip, -MOST_BY_LOAD), MOST_BY_LOAD), max(var, 0.0)


@array_law
def _shift(i: int, by: float, memory: Record) -> None:
    """Move a mean load: the usual slip and the intercept are those at the mean."""
    p = memory.line_p
    memory.mean_load[i] += by
    memory.line[0] += memory.line[i] * by
    memory.x[USUAL] += memory.line[i] * by
    for j in range(HELD):
        p[0, j] += by * p[i, j]
    for j in range(HELD):
        p[j, 0] += by * p[j, i]


@array_law
def learn_line(
    loads: Array, slip: float, slip_var: float, dt: float, z: Array, pz: Array, memory: Record
) -> None:
    """Learn from the slip of now, of variance `slip_var` about the line over `dt` [s]."""
    c, p = memory.line, memory.line_p
    if p[0, 0] == 0.0:
        for i in range(HELD):
            p[i, i] = PRIOR_SD**2 if i else OFFSET_SD**2
    share = dt / (min(memory.slip_s, MEAN_S) + dt)
    for i in range(1, HELD):
        if math.isfinite(loads[i]) and not math.isfinite(memory.mean_load[i]):
            memory.mean_load[i] = loads[i]
        elif math.isfinite(loads[i]):
            _shift(i, share * (loads[i] - memory.mean_load[i]), memory)
    centred(loads, memory, z)
    total = slip_var * (1.0 + 2.0 * SCATTER_S / dt)
    error = slip
    for i in range(HELD):
        p[i, i] += WALK * dt
        error -= c[i] * z[i]
        pz[i] = 0.0
        for j in range(HELD):
            pz[i] += p[i, j] * z[j]
    for i in range(HELD):
        total += z[i] * pz[i]
    most = ROBUST * math.sqrt(slip_var)
    error = min(max(error, -most), most)
    for i in range(HELD):
        c[i] += pz[i] * error / total
    for i in range(HELD):
        for j in range(HELD):
            p[i, j] -= pz[i] * pz[j] / total
