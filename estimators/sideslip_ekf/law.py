"""The law of sliding, and what the slip filter says: both once for every wheel sample."""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.sideslip_ekf import rows
from estimators.sideslip_ekf.layout import (
    CAMERA_YAW,
    F_Y,
    MISALIGNED,
    PITCH,
    PUSH,
    ROLL,
    V_X,
    V_Y,
)  # fmt: skip
from estimators.sideslip_ekf.update import restart, take, variance
from twin.compute.compiled import array_law

GATE = 4.0
PULLS_SLIP = 0.04
"""Without a depth sensor, a driven axle that slips more than this pulls something."""
DRIVING_MPS = 0.3
STEADY_S, UNSTEADY = 5.0, 2.0
"""Time over which the angle of the law is averaged [s], and how far it is off over what that angle
has changed by: tyres deflect first, and a wheel that drops into a furrow slides as it likes [-]."""
BUMP_S = 0.125
"""A bump shoves for so long [s]: the 0.25 m of a tyre's contact at 2 m/s (derived)."""
MISFIT_S = 5.0
"""What the law itself is off by lasts for so long [s]."""
LASTING_S = 2.0
"""What the slip filter errs by lasts for so long [s]."""
FIRST_S, SETTLE_S, MOST_SQUARE = 0.3, 4.0, 9.0
"""How long the first spread of the law counts, time over which it is averaged [s], and what a
square counts at most over the mean."""
TRUST, SLOPING, PULLING, UNFELT = 1.0, 4.0, 16.0, 100.0
"""The law never tells more than this much less than is known already, and its variance grows by
the others on slopes, behind an implement, and where no force is felt."""
STANCE_S = 3.0
"""Level driving that tells how the body stands [s]."""
SEEN_NS = 200_000_000
"""So old a frame still shows how the body stands."""
BOUNCES_RAD, TILT_S = 2e-3, 1.0
"""A body pitches by so much, seen by the camera over so long."""
LEAST_STEP_S, MOST_STEP_S = 1e-3, 1.0


@array_law
def take_speed(values: Array, h: Array, nominal: Record, tuning: Record, memory: Record) -> None:
    """Take the speed of the slip filter, then the law.

    Args:
        values: ground speed [m/s], its sd, slip, and whether the plough is out of the ground.
        h: room for a row.
        nominal, tuning, memory: records; `memory` is changed.
    """
    speed, sd, slip, clear = values[0], values[1], values[2], values[3]
    if not memory.known:
        memory.law_ns = memory.epoch_ns
        return
    x, p = memory.x, memory.p
    since = (memory.epoch_ns - memory.law_ns) * 1e-9 if memory.law_ns >= 0 else MOST_STEP_S
    dt = min(max(since, LEAST_STEP_S), MOST_STEP_S)
    first = memory.law_ns < 0
    memory.law_ns = memory.epoch_ns
    _work(slip, clear, tuning, memory)
    if math.isfinite(speed) and math.isfinite(sd):
        rows.one(V_X, h)
        r = (sd**2 + tuning.speed_sd_mps**2) * max(LASTING_S / dt, 1.0)
        take(x, p, h, speed - x[V_X], r, GATE)
    if abs(x[V_X]) < DRIVING_MPS:
        return
    if not memory.heard[F_Y] and p[ROLL, ROLL] > 0.0:  # how it leans nobody knows, a road's camber
        for state, sd in ((ROLL, 0.0), (PITCH, 0.0), (PUSH, tuning.unfelt_slide)):
            restart(x, p, state, 0.0, sd**2)
    least = tuning.level_sd_mps**2 * 0.02 / dt
    off = rows.slide(x, memory.imu, nominal, h)
    if memory.level and memory.heard[F_Y]:
        known = variance(p, h)
        _learn(off, known, least, dt, tuning, memory)
        bumps = memory.law_var * x[V_X] ** 2 * max(BUMP_S / dt, 1.0)
        take(x, p, h, -off, max(bumps, TRUST * known), GATE)
        _upright(h, dt, nominal, tuning, memory)
        return
    steady = (off - x[V_Y]) / x[V_X] + x[PUSH]
    share = min(dt / STEADY_S, 1.0) if not first else 1.0
    memory.steady_rad += share * (steady - memory.steady_rad)
    unsure = tuning.law_share * abs(steady) + UNSTEADY * abs(steady - memory.steady_rad)
    unsure_var = (unsure * x[V_X]) ** 2 * max(MISFIT_S / dt, 1.0)
    foretold = variance(p, h)
    if memory.pulls:
        rough = PULLING * (tuning.rough_rad * x[V_X]) ** 2 * 0.02 / dt
    else:
        _learn(off, foretold, least, dt, tuning, memory)
        rough = (SLOPING if memory.heard[F_Y] else UNFELT) * max(
            memory.law_var * x[V_X] ** 2, TRUST * foretold
        )
    take(x, p, h, -off, rough + unsure_var, GATE)


@array_law
def _work(slip: float, clear: float, tuning: Record, memory: Record) -> None:
    """Whether an implement is in the ground: then it pushes aside, by nobody knows how much."""
    if math.isfinite(clear):
        memory.depth_told = 1
        pulls = 0 if clear == 1.0 else 1
    elif memory.depth_told:
        pulls = 1
    else:
        if math.isfinite(slip):
            memory.slip += 0.02 * (slip - memory.slip)
        pulls = 1 if memory.slip > PULLS_SLIP and memory.heard[F_Y] else 0
    if pulls and not memory.pulls:
        restart(memory.x, memory.p, PUSH, 0.0, tuning.push_sd**2)
        memory.pulls_s = 0.0
        memory.p[MISALIGNED, MISALIGNED] += tuning.sunk_sd**2
        memory.p[CAMERA_YAW, CAMERA_YAW] += tuning.camera_sunk_sd**2
    elif memory.pulls and not pulls:
        restart(memory.x, memory.p, PUSH, 0.0, 0.0)
    memory.pulls = pulls


@array_law
def _learn(
    off: float, known: float, least: float, dt: float, tuning: Record, memory: Record
) -> None:
    """How far the law is off from bump to bump: var += (e^2 - known - var) dt / settle."""
    rough, moving = tuning.rough_rad**2, memory.x[V_X] ** 2
    if memory.law_s == 0.0:
        memory.law_var = rough
    gain = dt / min(memory.law_s + FIRST_S, SETTLE_S)
    memory.law_s += dt
    found = min((off**2 - known) / moving, MOST_SQUARE * max(memory.law_var, rough))
    memory.law_var = max(memory.law_var + gain * (found - memory.law_var), least / moving)


@array_law
def _upright(h: Array, dt: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """On level ground nothing tilts the body but what is uneven."""
    x, p = memory.x, memory.p
    g = max(nominal.gravity_mps2, 1.0)
    nose, left_up = -memory.uneven[0] / g, memory.uneven[1] / g
    rows.one(ROLL, h)
    take(x, p, h, left_up - x[ROLL], max(memory.felt_var, 1e-6) / g**2, GATE)
    if memory.stance_s < STANCE_S:  # how it stands is one unknown, and is told once
        memory.stance_s += dt
        rows.one(PITCH, h)
        take(x, p, h, nose - x[PITCH], tuning.stance_sd**2 * STANCE_S / dt, GATE)
    if memory.tilted and memory.epoch_ns - memory.frame_ns < SEEN_NS:
        off = rows.camera_stance(x, memory, h)
        take(x, p, h, -off - nose, BOUNCES_RAD**2 * TILT_S / dt, GATE)
