"""What is known of slip and radius from the plough: raised, lowered, and at work.

With the plough out of the ground the axle slips by a little, `UNLOADED_SLIP`. How little depends
on the soil, and so does the axle's torque then: at work the torque shows afterwards what it was.
"""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.slip_ekf import rows
from estimators.slip_ekf.begin import UNLOADED_SLIP_SD
from estimators.slip_ekf.brixius import slip_of, traction
from estimators.slip_ekf.held import PLOUGH, TORQUE
from estimators.slip_ekf.layout import (
    BIAS,
    FROM_GNSS,
    FROM_TOWED,
    NUMBER,
    RADIUS,
    RAISED,
    TOWED,
    TRACTION,
    UNLOADED_SLIP,
    A,
    V,
    W,
)
from estimators.slip_ekf.update import take
from twin.compute.compiled import array_law

SPREAD_SD, SPREAD_S = 0.004, 0.5
"""sd of the slip about `UNLOADED_SLIP` as the machine pitches, and for how long [s]."""
UNLOADED_SLIP_PSD, RAISED_S = 4e-8, 20.0
"""Density of the walk of `UNLOADED_SLIP` [1/s], and the time over which the torque without load is
averaged [s]: sqrt(sd^2 2 tau / walk), so that slip and torque are those of the same ground."""
CARRIED, CARRIED_SD = 0.009, 0.0035
"""Error of the rear wheels' radius while they carry the plough, whose load their nominal radius
does not know, and its sd [-]; 0.5 to 1.5 % for the twin's machines. Where the front wheels are
driven, too, the mean radius of all four stays, as the load comes off them."""
MOVED, MOVED_SD, REAR_SHARE = 0.006, 0.002, 0.4
"""Change of both axles' radii as the plough goes down, and its sd [-]: load moves from the rear
wheels to the front ones, 0.1 to 1 % for the twin's machines; and by how much more the rear radius
changes where the front one does."""
SETTLE_SD_MPS2 = 0.05
"""sd by which gravity's part changes then, as the body settles another way."""
NEW_SD, AGAIN_SD = 0.6, 0.15
"""sd of the traction that a plough calls for when it goes down for the first time, and again."""
ELSEWHERE_SD = 0.003
"""sd by which `UNLOADED_SLIP` is another one where the plough is raised again."""
WORK_S = 5.0
"""Time over which torque and slip at work are averaged, and after which they are used [s]."""
STRAIGHT_PM = 0.04
"""In a narrower curve than of 25 m driven front wheels scrub: nothing is learnt of four wheels
there [1/m]."""
OWN_TORQUE, MOST_TORQUE = 0.04, 0.88
"""Torque that rolls a driven wheel itself, and the most that the slip adds on firm soil, over load
times radius (Brixius 1987)."""
CARRIED_LOAD, LAW_SD, LAW_SHARE_SD = 1.2, 0.0012, 0.15
"""Load of the driven wheels while they carry the plough, over that at work, 1.1 to 1.3 for the
twin's machines; sd of what the law then gives, and its sd over that."""


@array_law
def take_plough(slow: Array, dt: float, h: Array, rear_share: float, memory: Record) -> None:
    """Take what the depth sensor and the axle's torque tell at a sample of the wheels.

    Args:
        slow: what slower sensors said, `held.Held.values`.
        dt: time since the last sample of the wheels [s].
        h: room for a row, (SIZE,).
        rear_share: how far the driven wheels are the rear ones: 1, or 0 where all are driven.
        memory: record, changed.
    """
    raised, torque = slow[PLOUGH], slow[TORQUE]
    steady = memory.x[V] > 0.5 and abs(memory.x[A]) < 0.3 and 0.0 < dt < 1.0
    if rear_share < 1.0 and abs(memory.yaw_rate) > STRAIGHT_PM * memory.x[V]:
        steady = False
    before = memory.plough
    if raised == 1.0:
        memory.plough = 1
        memory.flags |= RAISED
        if before != 1:
            memory.raised_s = memory.work_s = 0.0
        if before == -1:
            _move_load(-1.0, rear_share, memory)
            memory.p[UNLOADED_SLIP, UNLOADED_SLIP] += ELSEWHERE_SD**2
        elif before == 0:
            memory.x[RADIUS] += rear_share * CARRIED
            memory.p[RADIUS, RADIUS] += CARRIED_SD**2
        if steady:
            _no_load(torque, dt, h, memory)
    elif raised == 0.0:
        memory.plough = -1
        if before == 1:
            _move_load(1.0, rear_share, memory)
            memory.p[TRACTION, TRACTION] += AGAIN_SD**2 if memory.lowered else NEW_SD**2
            memory.lowered = 1
        elif before == 0:
            memory.x[RADIUS] += rear_share * (CARRIED - MOVED)
            memory.p[RADIUS, RADIUS] += CARRIED_SD**2
        if steady and memory.lowered:
            _at_work(torque, dt, h, memory)


@array_law
def _no_load(torque: float, dt: float, h: Array, memory: Record) -> None:
    """v (1 + radius) = w (1 - zero), by time and not by sample: variance sd^2 2 tau / dt."""
    if memory.p[UNLOADED_SLIP, UNLOADED_SLIP] < UNLOADED_SLIP_SD**2:
        memory.p[UNLOADED_SLIP, UNLOADED_SLIP] += UNLOADED_SLIP_PSD * dt
    error = -rows.no_slip(memory.x, memory.rim_mps, h)
    take(memory, h, error, (SPREAD_SD * memory.rim_mps) ** 2 * 2.0 * SPREAD_S / dt)
    if math.isfinite(torque):
        memory.raised_s += dt
        share = dt / min(memory.raised_s, RAISED_S)
        memory.torque[0] += share * (torque - memory.torque[0])


@array_law
def _at_work(torque: float, dt: float, h: Array, memory: Record) -> None:
    """Once a lowering, learn from the towed wheels how the radii changed, and from the torque.

    By Brixius' gross traction, torque / load = 0.88 y + 0.04 with y = 1 - exp(-7.5 slip), so

        own = 0.04 / (0.88 y + 0.04)
        unloaded slip = slip(y (T_raised / (1.2 T_work) - own) / (1 - own))
    """
    gnss = memory.time_ns - memory.seen_ns[FROM_GNSS] < 1.5e9 and memory.refused_ns[FROM_GNSS] < 0
    if not gnss or memory.work_s > WORK_S:
        return
    if memory.work_s == 0.0:
        memory.torque[1] = memory.work_slip = 0.0
    slip = 1.0 - memory.x[V] * (1.0 + memory.x[RADIUS]) / max(memory.x[W], memory.x[V])
    memory.work_s += dt
    share = dt / memory.work_s
    memory.torque[1] += share * (torque - memory.torque[1])
    memory.work_slip += share * (slip - memory.work_slip)
    if memory.work_s <= WORK_S:
        return
    if memory.time_ns - memory.seen_ns[FROM_TOWED] < 1e9:
        changed = min(max(memory.x[TOWED] - memory.towed_before, 0.0), 2.0 * MOVED)
        memory.x[RADIUS] += REAR_SHARE * (MOVED - changed)
    if memory.torque[1] > 2.0 * memory.torque[0] > 0.0:
        ratio = memory.torque[0] / (CARRIED_LOAD * memory.torque[1])
        zero = memory.x[UNLOADED_SLIP]
        for _ in range(3):  # the slip at work is less by as much as the radius is more
            y, _ = traction(max(memory.work_slip + zero - memory.x[UNLOADED_SLIP], 0.0))
            own = OWN_TORQUE / (MOST_TORQUE * y + OWN_TORQUE)
            zero, _ = slip_of(y * max(ratio - own, 0.0) / (1.0 - own))
        rows.one(NUMBER[UNLOADED_SLIP], h)
        law_var = LAW_SD**2 + (LAW_SHARE_SD * zero) ** 2
        take(memory, h, zero - memory.x[UNLOADED_SLIP], law_var)


@array_law
def _move_load(down: float, rear_share: float, memory: Record) -> None:
    """What the wheels carry moves from rear to front as the plough goes down: so do their radii."""
    memory.towed_before = memory.x[TOWED]
    memory.x[RADIUS] -= down * rear_share * MOVED
    memory.x[TOWED] += down * MOVED
    memory.p[RADIUS, RADIUS] += MOVED_SD**2
    memory.p[TOWED, TOWED] += MOVED_SD**2
    memory.p[BIAS, BIAS] += SETTLE_SD_MPS2**2
