"""Counted wheels: travel where the count is unbroken, speed elsewhere, and what no slip means."""

from __future__ import annotations

import math

import numpy as np

from estimators.innovations import note
from estimators.kalman import Array, Record
from estimators.slip_ekf import learn, load, motion, rows, unloaded
from estimators.slip_ekf.begin import begin
from estimators.slip_ekf.held import PLOUGH
from estimators.slip_ekf.judge import heard, judged
from estimators.slip_ekf.layout import (
    FROM_DRIVEN,
    FROM_TOWED,
    FRONT,
    NUMBER,
    ONE_WHEEL,
    RATE,
    READING,
    REAR,
    SIZE,
    A,
    V,
    W,
)
from estimators.slip_ekf.update import grow, restart, take, variance
from estimators.slip_ekf.wheels import APART_S, axle, in_the_air, radius, usable
from twin.compute.compiled import array_law

MEASURED_PSD, WHEEL_ACCEL_SD = 0.3, 0.06
"""Density of slip's own noise where the wheels have an accelerometer [1/s3], and its sd [m/s2]; the
IMA-PKF paper's."""
JUMP_MPS = 2.0
"""No wheel changes its speed by more between two samples, beyond what jitter makes [m/s]."""
MOST_LEAPS = 10
"""Samples in a row of turning driven wheels, none of them usable, that are refused."""
RIM_S = 3.0
"""Time over which the driven wheels' speed is averaged for the filter's gradients [s]."""
SPUN_S = 0.2
"""Time in which a driver changes the speed of the wheels [s]."""
LEAP = 5.0
"""A count further off than this many sd is a miscount or a motion."""
SPIN_NIS, TOGETHER, MOST_SPIN = 1.5, 0.2, 1000.0
"""Mean e^2 / S of the driven wheels' counts above which they move more than thought, mean product
of both axles' e / sqrt(S) above which the machine does, and how much more at most."""
LEAST_UNREST, MOST_EXCESS = 1.0, 100.0
SETTLE, SLOW_MPS = 100.0, 0.2
"""Samples over which the noise of the counts is averaged, and the speed above which [m/s]."""
AHEAD_S = 0.06
"""No further ahead of the newest gyro sample is the pitch predicted [s]."""


@array_law
def take_wheels(
    signal: Record, age: float, slower: Array, h: Array, nominal: Record, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """Take a sample of all wheels, or begin with it.

    Args:
        signal, nominal, tuning, memory: records; `memory` is changed in place.
        age: how much older than the newest sample it is [s].
        slower: what slower sensors said, `held.Held.values`.
        h: room for a row, (SIZE,).
    """
    wheels, sd = np.empty(4), signal.wheel_sd_mps
    tau = 0.0
    for i in range(4):
        wheels[i] = signal.wheel_mps[i]
        tau = max(tau, signal.wheel_age_s[i])
    pitched = turned(signal.epoch_ns, memory)
    if not memory.known:
        begin(signal, age, nominal, tuning, memory)
        memory.wheels_ns = signal.epoch_ns
        return
    dt = (signal.epoch_ns - memory.wheels_ns) * 1e-9
    jump = JUMP_MPS
    if tau > 0.0:
        jump += LEAP * abs(memory.rim_mps) * math.sqrt(2.0 * memory.jitter_var) / (2.0 * tau)
    yawing(signal, dt, jump, nominal, memory)
    front_turn = nominal.wheelbase_m * memory.yaw_rate
    way, _ = motion.longer(memory.x[V], front_turn)
    across = memory.yaw_rate * nominal.track_front_m / way  # along the steered wheels
    memory.lifted = in_the_air(wheels, memory.apart_mps[1] - across, memory.lifted, nominal)
    if memory.lifted:
        wheels[memory.lifted - 1] = np.nan
    foretold = rows.towed(memory.x, age, front_turn, h)
    if memory.leaps[1] > MOST_LEAPS:
        foretold = np.nan  # counts that cannot be, and go on: the prediction is wrong
    front, front_var, front_n = axle(wheels, sd, nominal, 0.0, foretold, across, jump)
    foretold = rows.driven(memory.x, memory.rim_mps, age, h)
    if memory.leaps[0] > MOST_LEAPS:
        foretold = np.nan
    rear, rear_var, rear_n = axle(wheels, sd, nominal, 1.0, foretold, memory.apart_mps[0], jump)
    for at in range(2):
        turning, n = False, rear_n if at == 0 else front_n
        for i in range(4):
            turning = turning or (nominal.driven[i] == 1.0 - at and abs(wheels[i]) > 0.0)
        memory.leaps[at] = memory.leaps[at] + 1 if turning and n == 0 else 0
    rear_var *= rear_n if signal.one_driven_speed else 1
    front_var *= front_n if signal.one_towed_speed else 1
    if rear_n == 1:
        memory.flags |= ONE_WHEEL
    if math.isfinite(rear):
        memory.rim_mps += min(max(dt, 0.0) / RIM_S, 1.0) * (rear - memory.rim_mps)
        heard(NUMBER[FROM_DRIVEN], signal.epoch_ns, rear, memory)
    _stand(rear, front, h, memory)
    if tau > 0.0:
        front += pitched / (2.0 * tau) * radius(nominal, 1.0)
        _listen(rear, front, 2.0 * tau, memory)
        restart(memory, NUMBER[READING], memory.jitter_var)
    spans = age == 0.0 and abs(2.0 * tau - dt) < 1e-6
    if math.isfinite(front):
        heard(NUMBER[FROM_TOWED], signal.epoch_ns, front / way, memory)
    _take_front(age, tau, spans, front, front_var, front_turn, h, tuning, memory)
    _take_rear(age, tau, spans, rear, rear_var, dt, h, tuning, memory)
    _take_accel(signal, dt, h, memory)
    unloaded.take_plough(slower, dt, h, memory)
    if slower[PLOUGH] != 1.0:
        load.take_expected(slower, dt, h, tuning, memory)
    memory.wheels_ns = signal.epoch_ns


@array_law
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


@array_law
def yawing(signal: Record, dt: float, jump: float, nominal: Record, memory: Record) -> None:
    """Right less left of both axles, averaged, and the yaw rate: the gyro's, else the wheels'.

    yaw rate = (right - left) / (track cos(steer)),   of the towed wheels where there are any

    1 / cos(steer) is the way of a front wheel over that of the rear-axle centre.
    """
    way, _ = motion.longer(memory.x[V], nominal.wheelbase_m * memory.yaw_rate)
    share = min(max(dt, 0.0) / APART_S, 1.0)
    rate = signal.yaw_rate_radps
    for rear in range(2):
        left = 2 * rear
        driven = nominal.driven[left] > 0.0
        at = 0 if driven else 1
        speed = memory.seen_mps[FROM_DRIVEN if driven else FROM_TOWED]
        both = usable(signal.wheel_mps[left], speed, jump)
        both = both and usable(signal.wheel_mps[left + 1], speed, jump)
        apart = signal.wheel_mps[left + 1] - signal.wheel_mps[left]
        if both:
            memory.apart_mps[at] += share * (apart - memory.apart_mps[at])
            track = nominal.track_rear_m if rear else nominal.track_front_m
            if signal.yaw_rate_radps == 0.0 and track > 0.0 and (not driven or rate == 0.0):
                rate = memory.apart_mps[at] / track * (1.0 if rear else way)
    memory.yaw_rate = rate


@array_law
def _listen(rear: float, front: float, step_s: float, memory: Record) -> None:
    """Variance of the instants of reading and of each axle's count, from second differences.

    d = c_k - 2 c_k-1 + c_k-2 of the counted travels c; of the motion hardly anything enters d

        E d_rear d_front = 6 w v jitter
        E (d_rear - w / v d_front)^2 = 6 (1 + (w / v)^2) count

    Where one axle alone is counted, E d^2 = 6 count: its jitter is taken for noise of the count.
    """
    counted = (rear * step_s, front * step_s)
    even = step_s / memory.step_s if memory.step_s > 0.0 else math.nan
    d_rear = counted[0] - memory.step[0] * even
    d_front = counted[1] - memory.step[1] * even
    memory.step[0], memory.step[1], memory.step_s = counted[0], counted[1], step_s
    if abs(rear) < SLOW_MPS:
        return
    memory.counted += 1
    gain = 1.0 / min(memory.counted + 5.0, SETTLE)
    if math.isfinite(d_rear * d_front) and abs(front) > SLOW_MPS:
        ratio = rear / front
        memory.jitter_var = _follow(
            memory.jitter_var, d_rear * d_front / (6.0 * rear * front), gain
        )
        own = (d_rear - ratio * d_front) ** 2 / (6.0 * (1.0 + ratio**2))
        memory.count_var = _follow(memory.count_var, own, gain)
    elif math.isfinite(d_rear) and memory.time_ns - memory.seen_ns[FROM_TOWED] > 1e9:
        memory.jitter_var = 0.0
        memory.count_var = _follow(memory.count_var, d_rear**2 / 6.0, gain)


@array_law
def _follow(now: float, found: float, gain: float) -> float:
    """A variance follows what is found, of which nine times as much counts at most."""
    some = max(now, 1e-8)
    return max(now + gain * (min(max(found, -some), 9.0 * some) - now), 0.0)


@array_law
def _stand(rear: float, front: float, h: Array, memory: Record) -> None:
    """A machine whose wheels all stand still stands still, and does not slip."""
    still = rear == 0.0 and (front == 0.0 or math.isnan(front)) and abs(memory.x[V]) < 0.1
    if still:
        rows.one(NUMBER[V], h)
        take(memory, h, -memory.x[V], 0.01**2)
        rows.one(NUMBER[A], h)
        take(memory, h, -memory.x[A], 0.05**2)
        restart(memory, NUMBER[W], 0.05**2)
        restart(memory, NUMBER[RATE], 0.3**2)


@array_law
def speed_var(source: int, speed: float, tau: float, var: float, memory: Record) -> float:
    """Variance of a speed: of one that is counted over 2 tau, with the instants of reading's.

    var + 2 jitter speed^2 / (2 tau)^2

    A source that gives speeds is heard for its own noise.
    """
    if tau > 0.0:
        return float(var + 2.0 * memory.jitter_var * (speed / (2.0 * tau)) ** 2)
    return learn.white_var(source, speed, memory.time_ns, var, memory)


@array_law
def _take_front(
    age: float, tau: float, spans: bool, speed: float, var: float, front_turn: float, h: Array,
    tuning: Record, memory: Record,
) -> None:  # fmt: skip
    """Counted travel of the towed wheels where it is unbroken, else their speed.

    A late sample is no origin: the travel since its own epoch is not known.
    """
    memory.off_towed = math.nan
    if not (math.isfinite(speed) and math.isfinite(var)):
        memory.spans[1] = 0
        return
    counted, count_var = speed * 2.0 * tau, max(var * 2.0 * tau**2, memory.count_var)
    travels = spans and memory.spans[1] == 1
    if travels:
        error, r = counted - rows.travel(memory.x, NUMBER[FRONT], speed, h), count_var
    else:
        r = speed_var(NUMBER[FROM_TOWED], speed, tau, var, memory)
        error = speed - rows.towed(memory.x, age + tau, front_turn, h)
    memory.off_towed = error / math.sqrt(variance(memory.p, h, r))
    if judged(NUMBER[FROM_TOWED], h, error, r, 0.0, tuning, memory):
        take(memory, h, error, r)
        memory.measured_ns = memory.time_ns
        memory.x[FRONT] -= counted
    else:
        travels = False
    if not travels and tau > 0.0:
        restart(memory, NUMBER[FRONT], count_var + speed**2 * memory.jitter_var)
        memory.spans[1] = 1 if age == 0.0 else 0


@array_law
def _take_rear(
    age: float, tau: float, spans: bool, speed: float, var: float, dt: float, h: Array,
    tuning: Record, memory: Record,
) -> None:  # fmt: skip
    """Counted travel of the driven wheels where it is unbroken, else their speed."""
    if not (math.isfinite(speed) and math.isfinite(var)):
        memory.spans[0] = 0
        return
    counted, count_var = speed * 2.0 * tau, max(var * 2.0 * tau**2, memory.count_var)
    travels = spans and memory.spans[0] == 1
    if travels:
        error, r = counted - rows.travel(memory.x, NUMBER[REAR], speed, h), count_var
    else:
        r = speed_var(NUMBER[FROM_DRIVEN], speed, tau, var, memory)
        error = speed - rows.driven(memory.x, memory.rim_mps, age + tau, h)
    total = variance(memory.p, h, r)
    note(memory.notes, error, total)
    nis = error**2 / total
    memory.nis_sum[FROM_DRIVEN] += nis
    memory.nis_count[FROM_DRIVEN] += 1
    _restless(error / math.sqrt(total), memory)
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
    take(memory, h, error, r)
    if not leapt and abs(speed) > SLOW_MPS and 0.0 < dt < 1.0:
        learn.gain(memory.x[V], speed, dt, tuning.load_gain, memory)
    if travels:
        memory.x[REAR] -= counted
    elif tau > 0.0:
        restart(memory, NUMBER[REAR], count_var + speed**2 * memory.jitter_var)
        memory.spans[0] = 1 if age == 0.0 else 0


@array_law
def _restless(off: float, memory: Record) -> None:
    """Learn from what both axles surprise by together, the motion, and what by itself.

    Args:
        off: e / sqrt(S) of the driven wheels, after the towed ones were taken.
        memory: record, changed.
    """
    memory.spin = learn.factor(memory.spin, off**2, SPIN_NIS, 1.0, MOST_SPIN)
    if not math.isfinite(memory.off_towed):
        memory.unrest = memory.spin
        return
    both = memory.off_towed * off
    memory.unrest = learn.factor(memory.unrest, both, TOGETHER, LEAST_UNREST, MOST_SPIN)
    own = memory.off_towed**2 - max(both, 0.0)
    memory.excess[FROM_TOWED] = learn.factor(memory.excess[FROM_TOWED], own, 1.0, 1.0, MOST_EXCESS)


@array_law
def _take_accel(signal: Record, dt: float, h: Array, memory: Record) -> None:
    """An accelerometer of the driven wheels, where a source has one: it needs no model of slip."""
    accel, n = 0.0, 0
    for i in range(4):
        if math.isfinite(signal.wheel_accel_mps2[i]):
            accel += signal.wheel_accel_mps2[i]
            n += 1
    if n == 0:
        return
    step = min(max(dt, 0.0), 0.1)
    motion.shaken(memory.p, 0.0, MEASURED_PSD * memory.rim_mps**2, 0.0, step)
    error = accel / n - rows.wheel_accel(memory.x, h)
    total = variance(memory.p, h, WHEEL_ACCEL_SD**2)
    if error**2 > 9.0 * total:
        motion.shaken(memory.p, 0.0, (error**2 - total) / max(step, 1e-3), 0.0, step)
    take(memory, h, error, WHEEL_ACCEL_SD**2)
