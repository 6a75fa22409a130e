"""Counted wheels: travel where the count is unbroken, speed elsewhere, and what no slip means."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_core import learn, motion, rows
from estimators.slip_core.begin import begin
from estimators.slip_core.judge import judged
from estimators.slip_core.layout import (
    BIAS,
    FROM_DRIVEN,
    FROM_TOWED,
    FRONT,
    GATED,
    ONE_WHEEL,
    RADIUS,
    RAISED,
    RATE,
    READING,
    REAR,
    SIZE,
    TOWED,
    USUAL,
    A,
    V,
    W,
)
from estimators.slip_core.update import grow, restart, take, variance
from estimators.slip_core.wheels import APART_S, axle, in_the_air, radius
from twin.compute.compiled import law

MOST_LEAPS = 10
"""Samples in a row of turning driven wheels, none of them usable, that are refused."""
RIM_S = 3.0
"""Time over which the driven wheels' speed is averaged for the filter's gradients [s]."""
SPUN_S = 0.2
"""Time in which a driver changes the speed of the wheels [s]."""
LEAP = 5.0
"""A count further off than this many sd is a miscount or a motion."""
SPIN_NIS, MOST_SPIN = 1.5, 1000.0
"""Mean e^2 / S of the driven wheels' counts above which they move more than thought, and how much
more at most."""
MOST_EXCESS = 100.0
JITTER_SETTLE = 100.0
"""Samples over which the variance of the instants of reading is averaged."""
AHEAD_S = 0.06
"""No further ahead of the newest gyro sample is the pitch predicted [s]."""
ZERO_SLIP, ZERO_SLIP_SD = 0.003, 0.02
"""Slip with the plough out of the ground, 0.2-0.9 % pull nothing, and its sd in one of 50 samples a
second: 0.4 % over some seconds."""
UNLOAD, UNLOAD_SD, LOAD, LOAD_SD = -0.0075, 0.003, 0.0065, 0.002
"""Change of the counted over the true speed when the plough goes down, and its sd: each rear wheel
loses about 7 kN and its radius grows; the front wheels get it and shrink."""
SETTLE_SD_MPS2 = 0.05
"""sd by which gravity's part changes then, as the body settles another way."""


@law
def take_wheels(
    signal: Record, age: float, raised: float, h: Array, nominal: Record, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """Take a sample of all wheels, or begin with it.

    Args:
        signal, nominal, tuning, memory: records; `memory` is changed in place.
        age: how much older than the newest sample it is [s].
        raised: 1 with the plough out of the ground, 0 in it, NaN where nobody knows.
        h: room for a row, (SIZE,).
    """
    wheels, sd = signal.wheel_mps.copy(), signal.wheel_sd_mps
    pitched = turned(signal.epoch_ns, memory)
    if not memory.known:
        begin(signal, age, nominal, tuning, memory)
        memory.wheels_ns = signal.epoch_ns
        return
    dt = (signal.epoch_ns - memory.wheels_ns) * 1e-9
    tau = signal.wheel_age_s.max()
    yawing(signal, dt, nominal, memory)
    front_turn = nominal.wheelbase_m * memory.yaw_rate
    memory.lifted = in_the_air(
        wheels, memory.apart_mps[1] - memory.yaw_rate * nominal.track_front_m, memory.lifted, nominal
    )
    if memory.lifted:
        wheels[memory.lifted - 1] = np.nan
    foretold = rows.towed(memory.x, age, front_turn, h)
    front, front_var, front_n = axle(wheels, sd, nominal, 0.0, foretold, memory.apart_mps[1])
    foretold = rows.driven(memory.x, memory.rim_mps, age, h)
    if memory.leaps > MOST_LEAPS:
        foretold = np.nan  # counts that cannot be, and go on: the prediction is wrong
    rear, rear_var, rear_n = axle(wheels, sd, nominal, 1.0, foretold, memory.apart_mps[0])
    turning = False
    for i in range(4):
        turning = turning or nominal.driven[i] * abs(wheels[i]) > 0.0
    memory.leaps = memory.leaps + 1 if turning and rear_n == 0 else 0
    rear_var *= rear_n if signal.one_driven_speed else 1
    front_var *= front_n if signal.one_towed_speed else 1
    if rear_n == 1:
        memory.flags |= ONE_WHEEL
    if math.isfinite(rear):
        memory.rim_mps += min(max(dt, 0.0) / RIM_S, 1.0) * (rear - memory.rim_mps)
        memory.seen_ns[FROM_DRIVEN], memory.seen_mps[FROM_DRIVEN] = signal.epoch_ns, rear
    _stand(rear, front, h, memory)
    if tau > 0.0:
        front += pitched / (2.0 * tau) * radius(nominal, 1.0)
        _learn_jitter(rear, front, rear_var, 2.0 * tau, memory)
        restart(memory.x, memory.p, READING, memory.jitter_var)
    spans = age == 0.0 and abs(2.0 * tau - dt) < 1e-6
    if math.isfinite(front):
        way, _ = motion.longer(memory.x[V], front_turn)
        memory.seen_ns[FROM_TOWED], memory.seen_mps[FROM_TOWED] = signal.epoch_ns, front / way
    _take_front(age, tau, spans, front, front_var, front_turn, h, tuning, memory)
    _take_rear(age, tau, spans, rear, rear_var, h, tuning, memory)
    _take_accel(signal, dt, h, tuning, memory)
    _zero(raised, h, memory)
    memory.wheels_ns = signal.epoch_ns


@law
def turned(epoch_ns: int, memory: Record) -> float:
    """Pitch since the last wheel sample [rad]; the newest gyro samples are carried on to now.

    pitch(t) = pitch + q tau + dq/dt tau^2 / 2

    A counter turns with the body: a travel counted is short by R times this. What is too much now
    is given back at the next sample.
    """
    ahead = min(max((epoch_ns - memory.imu_ns) * 1e-9, 0.0), AHEAD_S) if memory.imu_ns >= 0 else 0.0
    now = memory.pitch_rad + memory.pitch_rate * ahead + 0.5 * memory.pitch_accel * ahead**2
    since = now - memory.pitch_held_rad
    memory.pitch_held_rad = now
    return float(since)


@law
def yawing(signal: Record, dt: float, nominal: Record, memory: Record) -> None:
    """Right less left of both axles, averaged, and the yaw rate: the gyro's, else the wheels'.

    yaw rate = (right - left) / track,   of the towed wheels where there are any
    """
    share = min(max(dt, 0.0) / APART_S, 1.0)
    rate = signal.yaw_rate_radps
    for rear in range(2):
        left = 2 * rear
        driven = nominal.driven[left] > 0.0
        apart = signal.wheel_mps[left + 1] - signal.wheel_mps[left]
        at = 0 if driven else 1
        if math.isfinite(apart):
            memory.apart_mps[at] += share * (apart - memory.apart_mps[at])
            track = nominal.track_rear_m if rear else nominal.track_front_m
            if signal.yaw_rate_radps == 0.0 and track > 0.0 and (not driven or rate == 0.0):
                rate = memory.apart_mps[at] / track
    memory.yaw_rate = rate


@law
def _learn_jitter(rear: float, front: float, rear_var: float, step_s: float, memory: Record) -> None:
    """Variance of the instants of reading, from what both axles' counts have in common.

    d = c_k - 2 c_k-1 + c_k-2 of the counted travels c,   E d_rear d_front = 6 w v var
    of one axle alone                                     E d^2 = 6 (w^2 var + rounding)
    """
    if memory.step_s > 0.0 and math.isfinite(rear):
        even = step_s / memory.step_s
        d_rear = rear * step_s - memory.step[0] * even
        both = rear * memory.rim_mps
        if math.isfinite(front) and math.isfinite(memory.step[1]):
            product = d_rear * (front * step_s - memory.step[1] * even)
            both = rear * front
        else:
            product = d_rear**2 - 3.0 * rear_var * step_s**2
        if abs(both) > 0.1:
            found = product / (6.0 * both)
            limit = 9.0 * max(memory.jitter_var, 1e-10)
            found = min(max(found, -limit), limit)
            memory.jitter_var = max(
                memory.jitter_var + (found - memory.jitter_var) / JITTER_SETTLE, 0.0
            )
    memory.step[0], memory.step[1], memory.step_s = rear * step_s, front * step_s, step_s


@law
def _stand(rear: float, front: float, h: Array, memory: Record) -> None:
    """A machine whose wheels all stand still stands still, and does not slip."""
    still = rear == 0.0 and (front == 0.0 or math.isnan(front)) and abs(memory.x[V]) < 0.1
    if still:
        rows.one(V, h)
        take(memory.x, memory.p, h, -memory.x[V], 0.01**2, 0)
        rows.one(A, h)
        take(memory.x, memory.p, h, -memory.x[A], 0.05**2, 0)
        restart(memory.x, memory.p, W, 0.05**2)
        restart(memory.x, memory.p, RATE, 0.3**2)


@law
def _take_front(
    age: float, tau: float, spans: bool, speed: float, var: float, front_turn: float, h: Array,
    tuning: Record, memory: Record,
) -> None:  # fmt: skip
    """Counted travel of the towed wheels where it is unbroken, else their speed."""
    if not (math.isfinite(speed) and math.isfinite(var)):
        memory.spans[1] = 0
        return
    counted, count_var = speed * 2.0 * tau, var * 2.0 * tau**2
    travels = spans and memory.spans[1] == 1
    if travels:
        error, r = counted - rows.travel(memory.x, FRONT, speed, h), count_var
    else:
        error, r = speed - rows.towed(memory.x, age + tau, front_turn, h), var
    if judged(FROM_TOWED, h, error, r, False, tuning, memory):
        take(memory.x, memory.p, h, error, r, memory.raised)
        memory.measured_ns = memory.time_ns
        memory.x[FRONT] -= counted
    else:
        travels = False
    if not travels and tau > 0.0:
        restart(memory.x, memory.p, FRONT, count_var + speed**2 * memory.jitter_var)
        memory.spans[1] = 1


@law
def _take_rear(
    age: float, tau: float, spans: bool, speed: float, var: float, h: Array, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """Counted travel of the driven wheels where it is unbroken, else their speed."""
    if not (math.isfinite(speed) and math.isfinite(var)):
        memory.spans[0] = 0
        return
    counted, count_var = speed * 2.0 * tau, var * 2.0 * tau**2
    travels = spans and memory.spans[0] == 1
    if travels:
        error, r = counted - rows.travel(memory.x, REAR, speed, h), count_var
    else:
        error, r = speed - rows.driven(memory.x, memory.rim_mps, age + tau, h), var
    total = variance(memory.p, h, r)
    nis = error**2 / total
    memory.nis_sum[FROM_DRIVEN] += nis
    memory.nis_count[FROM_DRIVEN] += 1
    memory.spin = learn.factor(memory.spin, nis, SPIN_NIS, MOST_SPIN)
    leapt = nis > LEAP**2
    if leapt and travels and memory.miscount * error <= 0.0:  # once: a miscount
        memory.p[REAR, REAR] += error**2 - total
    elif leapt:  # again the same way: a motion
        way = np.zeros(SIZE)
        step = 2.0 * tau if travels else 1.0
        way[W], way[RATE] = 1.0 / step, 1.0 / (step * SPUN_S)
        way[REAR] = 1.0 if travels else 0.0
        grow(memory.p, way, error**2 - total)
    memory.miscount = error if leapt else 0.0
    take(memory.x, memory.p, h, error, r, memory.raised)
    if travels:
        memory.x[REAR] -= counted
    elif tau > 0.0:
        restart(memory.x, memory.p, REAR, count_var + speed**2 * memory.jitter_var)
        memory.spans[0] = 1


@law
def _take_accel(signal: Record, dt: float, h: Array, tuning: Record, memory: Record) -> None:
    """An accelerometer of the driven wheels, where a source has one: it needs no model of slip."""
    accel, n = 0.0, 0
    for i in range(4):
        if math.isfinite(signal.wheel_accel_mps2[i]):
            accel += signal.wheel_accel_mps2[i]
            n += 1
    if n == 0:
        return
    step = min(max(dt, 0.0), 0.1)
    motion.integrated(memory.p, W, RATE, MEASURED_PSD * memory.rim_mps**2, step)
    error = accel / n - rows.wheel_accel(memory.x, tuning.return_s, h)
    total = variance(memory.p, h, WHEEL_ACCEL_SD**2)
    if error**2 > 9.0 * total:
        motion.integrated(memory.p, W, RATE, (error**2 - total) / max(step, 1e-3), step)
    take(memory.x, memory.p, h, error, WHEEL_ACCEL_SD**2, memory.raised)


MEASURED_PSD, WHEEL_ACCEL_SD = 0.3, 0.06
"""Density of slip's own noise then [1/s3], and sd of such an accelerometer [m/s2]; the IMA-PKF
paper's."""


@law
def _zero(raised: float, h: Array, memory: Record) -> None:
    """The zero condition: with the plough out of the ground the axle slips by a little known.

    When the plough goes down the driven tyres carry less and their radius grows.
    """
    if raised == 1.0:
        memory.flags |= RAISED
        if memory.raised == 0:
            memory.raised = 1
            if memory.lowered:
                _reload(-1.0, memory)
        if abs(memory.x[V]) > 0.5 and abs(memory.x[A]) < 0.3:
            error = -rows.no_slip(memory.x, ZERO_SLIP, h)
            take(memory.x, memory.p, h, error, (ZERO_SLIP_SD * memory.rim_mps) ** 2, 1)
    elif raised == 0.0 and memory.raised == 1:
        memory.raised, memory.lowered = 0, 1
        _reload(1.0, memory)
        memory.p[USUAL, USUAL] += 0.15**2  # the plough will ask for another slip


@law
def _reload(down: float, memory: Record) -> None:
    """What the wheels carry moves from rear to front as the plough goes down: so do their radii."""
    memory.x[RADIUS] += down * UNLOAD
    memory.x[TOWED] += down * LOAD
    memory.p[RADIUS, RADIUS] += UNLOAD_SD**2
    memory.p[TOWED, TOWED] += LOAD_SD**2
    memory.p[BIAS, BIAS] += SETTLE_SD_MPS2**2
