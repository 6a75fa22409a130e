"""Counted wheels: travel where the count is unbroken, speed elsewhere, and what no slip means."""

from __future__ import annotations

import math

import numpy as np

from estimators.innovations import note
from estimators.kalman import Array, Record
from estimators.slip_ekf import learn, load, motion, rows, unloaded
from estimators.slip_ekf.begin import begin
from estimators.slip_ekf.held import PLOUGH
from estimators.slip_ekf.imu import pitch
from estimators.slip_ekf.jerk import adapt_factors, gain
from estimators.slip_ekf.jitter import learn_jitter
from estimators.slip_ekf.judge import accepted, note_speed
from estimators.slip_ekf.layout import (
    FROM_DRIVEN,
    FROM_TOWED,
    FRONT,
    NUMBER,
    ONE_WHEEL,
    READ_DELAY,
    REAR,
    SIZE,
    W_RATE,
    A,
    V,
    W,
)
from estimators.slip_ekf.update import grow, restart, take, variance
from estimators.slip_ekf.wheels import axle, in_the_air, radius, yawing
from twin.compute.compiled import array_law

MEASURED_PSD, WHEEL_ACCEL_SD = 0.3, 0.06
"""Density of slip's own noise where the wheels have an accelerometer [1/s3], and its sd [m/s2]; the
IMA-PKF paper's."""
JUMP_MPS, JUMP_MPS2 = 2.0, 10.0
"""No wheel changes its speed by more between two samples, beyond what jitter makes [m/s], nor, over
a gap, by more than a tyre brakes on a dry road [m/s2]."""
MOST_REFUSED = 10
"""Samples in a row of turning driven wheels, none of them usable, that are refused."""
RIM_S = 3.0
"""Time over which the driven wheels' speed is averaged for the filter's gradients [s]."""
THROTTLE_S = 0.2
"""Time in which a driver changes the speed of the wheels [s]."""
OUTLIER_SD, AGAIN_SD, EXACT_SHARE = 5.0, 3.0, 4.0
"""A count further off than the first of these is a miscount [sd]. Two in a row, the same way, are a
motion; where jitter's variance is less than so many times the count's, from the second on."""
SLOW_MPS = 0.2
"""Below this speed counts tell nothing of the motion's changes."""


@array_law
def take_wheels(
    signal: Record, age: float, slow: Array, h: Array, nominal: Record, tuning: Record,
    memory: Record,
) -> None:  # fmt: skip
    """Take a sample of all wheels, or begin with it.

    Args:
        signal, nominal, tuning, memory: records; `memory` is changed in place.
        age: how much older than the newest sample it is [s].
        slow: what slower sensors said, `held.Held.values`.
        h: room for a row, (SIZE,).
    """
    wheels, sd = np.empty(4), signal.wheel_sd_mps
    tau = 0.0
    for i in range(4):
        wheels[i] = signal.wheel_mps[i]
        tau = max(tau, signal.wheel_age_s[i])
    pitched = pitch(signal.epoch_ns, memory)[0] - memory.pitch_held_rad
    memory.pitch_held_rad += pitched
    if not memory.known:
        begin(signal, age, nominal, tuning, memory)
        memory.wheels_ns = signal.epoch_ns
        return
    dt = (signal.epoch_ns - memory.wheels_ns) * 1e-9
    jump = max(JUMP_MPS, JUMP_MPS2 * dt)
    if tau > 0.0:
        jump += OUTLIER_SD * abs(memory.rim_mps) * math.sqrt(2.0 * memory.jitter_var) / (2.0 * tau)
    yawing(signal, dt, jump, nominal, memory)
    front_turn_mps = nominal.wheelbase_m * memory.yaw_rate
    path_ratio, _ = motion.front_path(memory.x[V], front_turn_mps)
    for i in range(2):  # steered wheels that are driven go a longer way than the rear axle
        if nominal.driven[i]:
            wheels[i] /= path_ratio
    across = memory.yaw_rate * nominal.track_front_m / path_ratio  # along the steered wheels
    memory.lifted = in_the_air(wheels, memory.difference_mps[1] - across, memory.lifted, nominal)
    if memory.lifted:
        wheels[memory.lifted - 1] = np.nan
    predicted = rows.towed(memory.x, age, front_turn_mps, h)
    if memory.implausible[1] > MOST_REFUSED:
        predicted = np.nan  # counts that cannot be, and go on: the prediction is wrong
    front, front_var, front_n = axle(wheels, sd, nominal, 0.0, predicted, across, jump)
    predicted = rows.driven(memory.x, memory.rim_mps, age, h)
    if memory.implausible[0] > MOST_REFUSED:
        predicted = np.nan
    rear, rear_var, rear_n = axle(
        wheels, sd, nominal, 1.0, predicted, memory.difference_mps[0], jump
    )
    for at in range(2):
        turning, n = False, rear_n if at == 0 else front_n
        for i in range(4):
            turning = turning or (nominal.driven[i] == 1.0 - at and abs(wheels[i]) > 0.0)
        memory.implausible[at] = memory.implausible[at] + 1 if turning and n == 0 else 0
    rear_var *= rear_n if signal.one_driven_speed else 1
    front_var *= front_n if signal.one_towed_speed else 1
    if rear_n == 1:
        memory.flags |= ONE_WHEEL
    if math.isfinite(rear):
        memory.rim_mps += min(max(dt, 0.0) / RIM_S, 1.0) * (rear - memory.rim_mps)
        note_speed(NUMBER[FROM_DRIVEN], signal.epoch_ns, rear, memory)
    _stand_still(rear, front, h, memory)
    if tau > 0.0:
        front += pitched / (2.0 * tau) * radius(nominal, 1.0)
        learn_jitter(rear, front, 2.0 * tau, memory)
        restart(memory, NUMBER[READ_DELAY], memory.jitter_var)
    spans = age == 0.0 and abs(2.0 * tau - dt) < 1e-6
    if math.isfinite(front):
        note_speed(NUMBER[FROM_TOWED], signal.epoch_ns, front / path_ratio, memory)
    _take_front(age, tau, spans, front, front_var, front_turn_mps, h, tuning, memory)
    _take_rear(age, tau, spans, rear, rear_var, dt, h, tuning, memory)
    _take_accel(signal, dt, h, memory)
    rear_share = 1.0 - max(nominal.driven[0], nominal.driven[1])
    unloaded.take_plough(slow, dt, h, rear_share, memory)
    if slow[PLOUGH] != 1.0:
        load.take_expected(slow, dt, h, tuning, memory)
    memory.wheels_ns = signal.epoch_ns


@array_law
def _stand_still(rear: float, front: float, h: Array, memory: Record) -> None:
    """A machine whose wheels all stand still stands still, and does not slip."""
    still = rear == 0.0 and (front == 0.0 or math.isnan(front)) and abs(memory.x[V]) < 0.1
    if still:
        rows.one(NUMBER[V], h)
        take(memory, h, -memory.x[V], 0.01**2)
        rows.one(NUMBER[A], h)
        take(memory, h, -memory.x[A], 0.05**2)
        restart(memory, NUMBER[W], 0.05**2)
        restart(memory, NUMBER[W_RATE], 0.3**2)


@array_law
def speed_var(source: int, speed: float, tau: float, var: float, memory: Record) -> float:
    """Variance of a speed: of one that is counted over 2 tau, with the instants of reading's.

    var + 2 jitter speed^2 / (2 tau)^2

    Of a source that gives speeds the noise is learnt.
    """
    if tau > 0.0:
        return float(var + 2.0 * memory.jitter_var * (speed / (2.0 * tau)) ** 2)
    return learn.white_var(source, speed, memory.time_ns, var, memory)


@array_law
def _take_front(
    age: float, tau: float, spans: bool, speed: float, var: float, front_turn_mps: float, h: Array,
    tuning: Record, memory: Record,
) -> None:  # fmt: skip
    """Counted travel of the towed wheels where it is unbroken, else their speed.

    A late sample is no origin: the travel since its own epoch is not known.
    """
    memory.towed_innovation = math.nan
    if not (math.isfinite(speed) and math.isfinite(var)):
        memory.unbroken[1] = 0
        return
    counted, count_var = speed * 2.0 * tau, max(var * 2.0 * tau**2, memory.count_var)
    travels = spans and memory.unbroken[1] == 1
    if travels:
        error, r = counted - rows.travel(memory.x, NUMBER[FRONT], speed, h), count_var
    else:
        r = speed_var(NUMBER[FROM_TOWED], speed, tau, var, memory)
        error = speed - rows.towed(memory.x, age + tau, front_turn_mps, h)
    memory.towed_innovation = error / math.sqrt(variance(memory.p, h, r))
    if accepted(NUMBER[FROM_TOWED], h, error, r, 0.0, tuning, memory):
        take(memory, h, error, r)
        memory.measured_ns = memory.time_ns
        memory.x[FRONT] -= counted
    else:
        travels = False
    if not travels and tau > 0.0:
        restart(memory, NUMBER[FRONT], count_var + speed**2 * memory.jitter_var)
        memory.unbroken[1] = 1 if age == 0.0 else 0


@array_law
def _take_rear(
    age: float, tau: float, spans: bool, speed: float, var: float, dt: float, h: Array,
    tuning: Record, memory: Record,
) -> None:  # fmt: skip
    """Counted travel of the driven wheels where it is unbroken, else their speed."""
    if not (math.isfinite(speed) and math.isfinite(var)):
        memory.unbroken[0] = 0
        return
    counted, count_var = speed * 2.0 * tau, max(var * 2.0 * tau**2, memory.count_var)
    travels = spans and memory.unbroken[0] == 1
    if travels:
        error, r = counted - rows.travel(memory.x, NUMBER[REAR], speed, h), count_var
    else:
        r = speed_var(NUMBER[FROM_DRIVEN], speed, tau, var, memory)
        error = speed - rows.driven(memory.x, memory.rim_mps, age + tau, h)
    total = variance(memory.p, h, r)
    note(memory.notes, error, total)
    normalised = error / math.sqrt(total)
    memory.nis_sum[FROM_DRIVEN] += normalised**2
    memory.nis_count[FROM_DRIVEN] += 1
    adapt_factors(normalised, memory)
    is_outlier = abs(normalised) > OUTLIER_SD
    exact = travels and memory.jitter_var * speed**2 < EXACT_SHARE * count_var
    again = min(abs(normalised), abs(memory.last)) > (AGAIN_SD if exact else OUTLIER_SD)
    if (again and normalised * memory.last > 0.0) or (is_outlier and not travels):
        direction = np.zeros(SIZE)  # a motion
        step = 2.0 * tau if travels else 1.0
        direction[W], direction[W_RATE] = 1.0 / step, 1.0 / (step * THROTTLE_S)
        direction[REAR] = 1.0 if travels else 0.0
        grow(memory.p, direction, error**2 - total)
    elif is_outlier and travels:  # once: a miscount
        memory.p[REAR, REAR] += error**2 - total
    memory.last = normalised
    take(memory, h, error, r)
    if not is_outlier and abs(speed) > SLOW_MPS and 0.0 < dt < 1.0:
        gain(memory.x[V], speed, dt, tuning.wheel_jerk_gain, memory)
    if travels:
        memory.x[REAR] -= counted
    elif tau > 0.0:
        restart(memory, NUMBER[REAR], count_var + speed**2 * memory.jitter_var)
        memory.unbroken[0] = 1 if age == 0.0 else 0


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
    motion.add_jerk(memory.p, 0.0, MEASURED_PSD * memory.rim_mps**2, 0.0, step)
    error = accel / n - rows.wheel_accel(memory.x, h)
    total = variance(memory.p, h, WHEEL_ACCEL_SD**2)
    if error**2 > 9.0 * total:
        motion.add_jerk(memory.p, 0.0, (error**2 - total) / max(step, 1e-3), 0.0, step)
    take(memory, h, error, WHEEL_ACCEL_SD**2)
