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
UNLOADED_SLIP_PSD = 1e-6
"""Density of the walk of `UNLOADED_SLIP` from place to place [1/s]: 0.3 points in 10 s."""
MOVED, MOVED_SD = 0.005, 0.002
"""Change of both axles' radii as the plough goes down, and its sd [-]: load moves from the rear
wheels to the front ones; 0.1 to 1 % for the twin's machines."""
REAR_OVER_FRONT = 0.9
"""Change of the rear over that of the front radius then; 0.6 to 1.2 for the twin's machines."""
SETTLE_SD_MPS2 = 0.05
"""sd by which gravity's part changes then, as the body settles another way."""
NEW_SD, AGAIN_SD = 0.6, 0.15
"""sd of the traction that a plough calls for when it goes down for the first time, and again."""
WORK_S = 5.0
"""Time over which torque and slip are averaged, and after which they are used [s]."""
OWN_TORQUE, LAW_SD = 0.6, 0.35
"""Share of the torque without load that rolls the driven wheels themselves, and relative sd of what
the law then gives."""


@array_law
def take_plough(slow: Array, dt: float, h: Array, memory: Record) -> None:
    """Take what the depth sensor and the axle's torque tell at a sample of the wheels.

    Args:
        slow: what slower sensors said, `held.Held.values`.
        dt: time since the last sample of the wheels [s].
        h: room for a row, (SIZE,).
        memory: record, changed.
    """
    raised, torque = slow[PLOUGH], slow[TORQUE]
    steady = abs(memory.x[V]) > 0.5 and abs(memory.x[A]) < 0.3 and 0.0 < dt < 1.0
    if raised == 1.0:
        if memory.raised == 0 and memory.lowered:
            _move_load(-1.0, memory)
        memory.flags |= RAISED
        if memory.raised == 0 or memory.raised_s == 0.0:
            memory.raised_s = memory.work_s = 0.0
        memory.raised = 1
        if steady:
            _no_load(torque, dt, h, memory)
    elif raised == 0.0:
        if memory.raised == 1:
            _move_load(1.0, memory)
            memory.p[TRACTION, TRACTION] += AGAIN_SD**2 if memory.lowered else NEW_SD**2
            memory.raised, memory.lowered = 0, 1
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
        share = dt / min(memory.raised_s, WORK_S)
        memory.torque[0] += share * (torque - memory.torque[0])


@array_law
def _at_work(torque: float, dt: float, h: Array, memory: Record) -> None:
    """Once a lowering, learn from the towed wheels how the radii changed, and from the torque.

    By Brixius' gross traction, torque - own torque is proportional to y = 1 - exp(-7.5 slip), so

        unloaded slip = slip(y (T_raised - T_own) / (T_work - T_own)),   T_own = 0.6 T_raised
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
        found = REAR_OVER_FRONT * changed
        memory.x[RADIUS] += 0.5 * (MOVED - found)  # as sure as what was thought before
        memory.p[RADIUS, RADIUS] -= 0.5 * MOVED_SD**2
    own = OWN_TORQUE * memory.torque[0]
    if memory.torque[1] > 2.0 * memory.torque[0] > 0.0:
        ratio = (memory.torque[0] - own) / (memory.torque[1] - own)
        zero = memory.x[UNLOADED_SLIP]
        for _ in range(3):  # the slip at work is less by as much as the radius is more
            slip = max(memory.work_slip + zero - memory.x[UNLOADED_SLIP], 0.0)
            zero, _ = slip_of(ratio * traction(slip)[0])
        rows.one(NUMBER[UNLOADED_SLIP], h)
        take(memory, h, zero - memory.x[UNLOADED_SLIP], (LAW_SD * zero) ** 2 + 1e-8)


@array_law
def _move_load(down: float, memory: Record) -> None:
    """What the wheels carry moves from rear to front as the plough goes down: so do their radii."""
    memory.towed_before = memory.x[TOWED]
    memory.x[RADIUS] -= down * MOVED
    memory.x[TOWED] += down * MOVED
    memory.p[RADIUS, RADIUS] += MOVED_SD**2
    memory.p[TOWED, TOWED] += MOVED_SD**2
    memory.p[BIAS, BIAS] += SETTLE_SD_MPS2**2
