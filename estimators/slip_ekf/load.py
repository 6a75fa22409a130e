"""The slip that the load calls for: learnt while GNSS is there, and used always.

Gross traction rises with slip as y = 1 - exp(-7.5 slip) (`brixius`), and with the load in
proportion. So a line from load to y holds where one from load to slip does not:

    y = traction + line . (load - mean load) + e     (recursive least squares, with an intercept)

Draft, torque and fuel rise together: which of them gets the larger coefficient is up to
the prior, and does not matter.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.layout import STALE_S
from estimators.slip_ekf import rows
from estimators.slip_ekf.brixius import slip_of, traction
from estimators.slip_ekf.held import HELD
from estimators.slip_ekf.layout import FROM_DRIVEN, FROM_GNSS, TRACTION, V, W
from estimators.slip_ekf.update import take, variance
from twin.compute.compiled import array_law

PRIOR_SD, OFFSET_SD = 0.2, 0.7
"""sd of the y that comes of a load's common variation, and of the intercept."""
WALK = 2e-6
"""Density of the walk of the line, as the ground changes [1/s]."""
SCATTER_S, MEAN_S = 1.0, 60.0
"""How long slip stays off the line, and time over which the mean load is taken [s]."""
MOST_BY_LOAD = 1.0
"""The y that a load makes at most beside the mean one."""
ROBUST = 3.0
"""A y further off the line than this many sd counts as this many."""
UNCOUNTED_S = 0.2
"""After this time without a count the expected slip is less certain [s]."""
SCATTER_SD, LEARN_SD = 0.07, 0.05
"""sd of y about the line, and sd of a slip from which it is learnt."""
MOVING_MPS, SPREAD_LEARN_S, LEAST_SD, MOST_SD = 0.3, 15.0, 0.03, 0.4
"""Speed above which slip is expected [m/s]; time over which the spread of y about it is learnt [s];
between what it is kept."""
LEAST_STEEP = 0.25
"""dslip/dy for the spread at least: slip near zero spreads as it does at 8 %."""
UNCOUNTED_SD = 0.1
"""sd of the slip of wheels that are not counted."""


@array_law
def take_expected(slow: Array, dt: float, h: Array, tuning: Record, memory: Record) -> None:
    """The driven wheels slip as the load calls for; what they are off it by lasts some seconds.

    v = w (1 - slip(y)),   variance of one sample in dt: 2 spread slip_s / dt

    While GNSS is there, the line and the spread are learnt.
    """
    rim = memory.rim_mps
    if abs(rim) < MOVING_MPS or not 0.0 < dt < STALE_S:
        return
    z = np.zeros(HELD)
    centred(slow, memory, z)
    by, by_var = by_load(z, memory)
    off = rows.expected(memory.x, by, rim, h)
    steep = max(slip_of(memory.x[TRACTION] + by)[1], LEAST_STEEP) * abs(rim)
    spread = max(memory.y_var, LEAST_SD**2) * steep**2
    state_var = variance(memory.p, h, 0.0)
    known = state_var + by_var * steep**2
    if memory.time_ns - memory.seen_ns[FROM_GNSS] < 1.5e9 and memory.refused_ns[FROM_GNSS] < 0:
        memory.slip_s += dt
        state_sq = (LEARN_SD * rim) ** 2 + memory.p[TRACTION, TRACTION] * steep**2
        if state_var < state_sq and abs(memory.x[W]) > MOVING_MPS:
            y, _ = traction(1.0 - memory.x[V] / memory.x[W])
            learn_line(slow, y, dt, z, memory)
        square = min(max(off**2 - known, 0.0) / steep**2, MOST_SD**2)
        share = dt / (min(memory.slip_s, SPREAD_LEARN_S) + 5.0)
        memory.y_var += min(share, 1.0) * (square - memory.y_var)
    spread += by_var * steep**2
    if memory.time_ns - memory.seen_ns[FROM_DRIVEN] > UNCOUNTED_S * 1e9:
        spread += (UNCOUNTED_SD * rim) ** 2  # they may slip as they like
    take(memory, h, -off, spread * (1.0 + 2.0 * tuning.slip_s / dt * spread / (spread + known)))


@array_law
def centred(loads: Array, memory: Record, z: Array) -> None:
    """Fill z = (1, load - mean load); 0 for a load that is unknown, or has no mean yet."""
    z[0] = 1.0
    for i in range(1, HELD):
        off = loads[i] - memory.mean_load[i]
        z[i] = off if math.isfinite(off) else 0.0


@array_law
def by_load(z: Array, memory: Record) -> tuple[float, float]:
    """The y beside the mean one that the load makes, and its variance."""
    y, var = 0.0, 0.0
    for i in range(1, HELD):
        y += memory.line[i] * z[i]
        for j in range(1, HELD):
            var += z[i] * memory.line_p[i, j] * z[j]
    return min(max(y, -MOST_BY_LOAD), MOST_BY_LOAD), max(var, 0.0)


@array_law
def _shift(i: int, by: float, memory: Record) -> None:
    """Move a mean load: the expected traction and the intercept are those at the mean."""
    p = memory.line_p
    memory.mean_load[i] += by
    memory.line[0] += memory.line[i] * by
    memory.x[TRACTION] += memory.line[i] * by
    for j in range(HELD):
        p[0, j] += by * p[i, j]
    for j in range(HELD):
        p[j, 0] += by * p[j, i]


@array_law
def learn_line(loads: Array, y: float, dt: float, z: Array, memory: Record) -> None:
    """Learn from the y of now, which has been for `dt` [s]."""
    c, p, pz = memory.line, memory.line_p, np.zeros(HELD)
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
    total = SCATTER_SD**2 * (1.0 + 2.0 * SCATTER_S / dt)
    error = y
    for i in range(HELD):
        p[i, i] += WALK * dt
        error -= c[i] * z[i]
        for j in range(HELD):
            pz[i] += p[i, j] * z[j]
    for i in range(HELD):
        total += z[i] * pz[i]
    most = ROBUST * SCATTER_SD
    error = min(max(error, -most), most)
    for i in range(HELD):
        c[i] += pz[i] * error / total
    for i in range(HELD):
        for j in range(HELD):
            p[i, j] -= pz[i] * pz[j] / total
