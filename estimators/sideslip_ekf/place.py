"""Fixed positions: taken where they agree with the receiver's own velocities."""

from __future__ import annotations

import math

from estimators.innovations import note
from estimators.kalman import Array, Record
from estimators.layout import FIXED
from estimators.sideslip_ekf import rows
from estimators.sideslip_ekf.layout import (
    EAST,
    F_Y,
    NORTH,
    PITCH,
    RECEIVER_E,
    RECEIVER_N,
    ROLL,
)
from estimators.sideslip_ekf.update import restart, take
from twin.compute.compiled import array_law

GATE = 3.0
SPAN_S, MOST_SPAN_S = 1.0, 3.0
"""Positions and velocities are compared over so long, and not over more [s]."""
SHARE, MOST = 0.2, 25.0
"""Share of one comparison in their mean, and what one counts at most."""
AGREES = 4.0
"""Mean square, over what both sd make it, up to which they agree."""
FREE_M2 = 100.0
"""Variance of a place that nothing is known of [m2]."""


@array_law
def take_place(values: Array, h: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """Take a fixed position; what it errs by for long is a state, which begins anew with a fix.

    Args:
        values: a sample in the columns of `layout.READ`.
        h: room for a row.
        nominal, tuning, memory: records; `memory` is changed.
    """
    place = values[7:9]
    sd = values[9] if values[9] > 0.0 else nominal.position_sd_m
    fixed = values[4] == FIXED and math.isfinite(place[0]) and math.isfinite(place[1])
    noise = values[5] if values[5] > 0.0 else nominal.velocity_sd_mps
    _compare(values[:2], place, fixed, sd, noise, memory)
    if not fixed or memory.agree > AGREES:
        memory.fixed = memory.placed = 0
        return
    x, p = memory.x, memory.p
    if not memory.fixed:
        for state in (RECEIVER_E, RECEIVER_N):
            restart(x, p, state, 0.0, (tuning.lasting_share * sd) ** 2)
        memory.fixed = 1
    for i in range(2):
        state = EAST if i == 0 else NORTH
        foretold = rows.place(x, i == 1, nominal, h)
        if not memory.placed:
            restart(x, p, state, x[state] + place[i] - foretold, FREE_M2)
        error = place[i] - rows.place(x, i == 1, nominal, h)
        unfelt(h, memory)
        known = memory.placed
        nis = take(x, p, h, error, (tuning.white_share * sd) ** 2, GATE)
        if known:
            noted(error, nis, memory)
    memory.placed = 1


@array_law
def noted(error: float, nis: float, memory: Record) -> None:
    """Note an innovation e and its variance S, from e^2 / S."""
    if nis > 0.0:
        note(memory.notes, error, error**2 / nis)


@array_law
def unfelt(h: Array, memory: Record) -> None:
    """Where nothing feels how the body leans, GNSS does not tell it either."""
    if not memory.heard[F_Y]:
        h[ROLL] = h[PITCH] = 0.0


@array_law
def _compare(
    velocity: Array, place: Array, fixed: bool, sd: float, noise: float, memory: Record
) -> None:
    """Mean square of the way between two positions less that of the velocities.

    e = (place - place before) - integral v,   E |e|^2 / 2 = 2 sd^2 + noise^2 T dt

    A log's positions may come late, or from another solution than its velocities.
    """
    dt = (memory.epoch_ns - memory.way_ns) * 1e-9
    span = (memory.epoch_ns - memory.anchor_ns) * 1e-9
    broken = memory.way_ns < 0 or dt > MOST_SPAN_S or not fixed
    if broken or not (math.isfinite(velocity[0]) and math.isfinite(velocity[1])):
        memory.way_ns = -1
        if not (fixed and math.isfinite(velocity[0]) and math.isfinite(velocity[1])):
            return
        span = 0.0
    for i in range(2):
        memory.way_m[i] += 0.5 * (memory.way_mps[i] + velocity[i]) * dt if span > 0.0 else 0.0
        memory.way_mps[i] = velocity[i]
    memory.way_ns = memory.epoch_ns
    if 0.0 < span < SPAN_S:
        return
    if span > 0.0:
        square = 0.0
        for i in range(2):
            square += (place[i] - memory.anchor_m[i] - memory.way_m[i]) ** 2
        square /= 2.0 * (2.0 * sd**2 + noise**2 * span * dt)
        memory.agree += SHARE * (min(square, MOST) - memory.agree)
    for i in range(2):
        memory.anchor_m[i], memory.way_m[i] = place[i], 0.0
    memory.anchor_ns = memory.epoch_ns
