"""Counted wheels: travel where the count is unbroken, speed elsewhere, and what no slip means."""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_ekf import model
from estimators.slip_ekf.begin import begin
from estimators.slip_ekf.driven import axle, lifted, radius
from estimators.slip_ekf.layout import (
    ACCEL_BIAS,
    FRONT_TRAVEL,
    GATED,
    ONE_WHEEL,
    RADIUS,
    RAISED,
    REAR_TRAVEL,
    RIM_RATE,
    SKID,
    USUAL,
    A,
    V,
    W,
)
from estimators.slip_ekf.pitch import turned
from estimators.slip_ekf.rows import (
    LEAN_S,
    doubt,
    followed,
    gated,
    grow,
    grow_evenly,
    lean,
    restart,
    shift,
    spun,
    surprise,
    take,
)
from estimators.slip_ekf.tuning import FROM_FRONT, FROM_REAR
from twin.compute.compiled import compiled

SPIN_GAIN, SPIN_NIS, MOST_SPIN = 0.02, 1.5, 1000.0
"""How fast the noise of the driven wheels' motion grows where their counts surprise on average by
more than so much, and the most it does."""
MOST_LEAPS = 10
"""Samples in a row of turning driven wheels, none of them usable, that are refused."""
RIM_TAU_S = 3.0
"""Time over which the driven wheels' speed is averaged for the filter's gradients [s]."""


@compiled
def take_wheels(
    signal: Record,
    age: float,
    raised: float,
    h: Array,
    nominal: Record,
    tuning: Record,
    memory: Record,
) -> None:
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
        return
    towed = model.front_row(memory.x, age, h)
    across = signal.yaw_rate_radps * nominal.track_rear_m
    across = across if math.isfinite(across) else 0.0
    if lifted(wheels, across, (signal.epoch_ns - memory.rear_ns) * 1e-9, nominal, memory):
        # the mean of both was as much behind
        doubt(memory, 0.5 * abs(memory.towed_apart_mps), LEAN_S, 1.0)
    if memory.lifted:
        wheels[memory.lifted - 1] = np.nan
    front, front_var, front_n = axle(wheels, sd, nominal, 0.0, towed, across)
    predicted = model.rear_row(memory.x, memory.rim_mps, age, h)
    if memory.leaps > MOST_LEAPS:
        predicted = np.nan  # counts that cannot be, and go on: the prediction is wrong
    rear, rear_var, rear_n = axle(wheels, sd, nominal, 1.0, predicted, memory.apart_mps)
    turning = (nominal.driven * np.abs(wheels) > 0.0).any()
    memory.leaps = memory.leaps + 1 if turning and rear_n == 0 else 0
    if signal.one_driven_speed:
        rear_var *= rear_n
    if signal.one_towed_speed:
        front_var *= front_n
    if math.isfinite(rear):
        dt = min(max((signal.epoch_ns - memory.rear_ns) * 1e-9, 0.0), RIM_TAU_S)
        memory.rim_mps += dt / RIM_TAU_S * (rear - memory.rim_mps)
    _stand(rear, front, h, memory)
    if signal.wheel_age_s.max() > 0.0:
        front += pitched / (2.0 * signal.wheel_age_s.max()) * radius(nominal, 1.0)
    _take_front(signal, age, front, front_var, h, tuning, memory)
    _take_rear(signal, age, rear, rear_var, h, tuning, memory)
    if rear_n == 2:
        difference = wheels[3] - wheels[2] if nominal.driven[3] else wheels[1] - wheels[0]
        memory.apart_mps += 0.05 * (difference - memory.apart_mps)
    elif rear_n == 1:
        memory.flags |= ONE_WHEEL
    _zero(raised, h, tuning, memory)
    memory.rear_ns = signal.epoch_ns


@compiled
def _spans(signal: Record, memory: Record) -> bool:
    """Whether the counts of this sample are those since the last one."""
    step_ns = signal.epoch_ns - memory.rear_ns
    return bool(abs(2e9 * signal.wheel_age_s.max() - step_ns) < 1000.0)


@compiled
def _take_front(
    signal: Record,
    age: float,
    speed: float,
    variance: float,
    h: Array,
    tuning: Record,
    memory: Record,
) -> None:
    """Counted travel of the towed wheels where it is unbroken, else their speed."""
    if not (math.isfinite(speed) and math.isfinite(variance)):
        memory.front_spans = 0
        return
    memory.front_ns = signal.epoch_ns
    tau = signal.wheel_age_s.max()
    counted, count_var = speed * 2.0 * tau, variance * 2.0 * tau**2
    if memory.front_spans and age == 0.0 and _spans(signal, memory):
        h[:] = 0.0
        h[FRONT_TRAVEL] = 1.0
        error = counted - memory.x[FRONT_TRAVEL]
    else:
        error = speed - model.front_row(memory.x, age + tau, h)
        count_var, memory.front_spans = variance, 0
    lean(memory, FROM_FRONT, h, error, count_var, tuning.gate)
    if gated(memory, FROM_FRONT, h, error, count_var, signal.epoch_ns, tuning):
        memory.measured_ns = signal.epoch_ns
        if memory.front_spans:
            shift(memory, FRONT_TRAVEL, -counted)
    else:
        memory.flags |= GATED
        memory.front_spans = 0
    if not memory.front_spans and tau > 0.0:
        restart(memory, FRONT_TRAVEL, variance * 2.0 * tau**2)
        memory.front_spans = 1


@compiled
def _take_rear(
    signal: Record,
    age: float,
    speed: float,
    variance: float,
    h: Array,
    tuning: Record,
    memory: Record,
) -> None:
    """Counted travel of the driven wheels where it is unbroken, else their speed."""
    if not (math.isfinite(speed) and math.isfinite(variance)):
        memory.rear_spans = 0
        return
    tau = signal.wheel_age_s.max()
    counted, count_var = speed * 2.0 * tau, variance * 2.0 * tau**2
    if memory.rear_spans and age == 0.0 and _spans(signal, memory):
        h[:] = 0.0
        h[REAR_TRAVEL] = 1.0
        error = counted - memory.x[REAR_TRAVEL]
        grown, nis = surprise(memory, FROM_REAR, h, error, count_var, 5.0)
        if grown > 0.0 and memory.miscounted * error > 0.0:  # again the same way: a motion
            spun(memory, grown, 2.0 * tau)
        elif grown > 0.0:
            grow(memory, REAR_TRAVEL, REAR_TRAVEL, grown)
        memory.miscounted = error if grown > 0.0 else 0.0
        take(memory.x, memory.cov, h, error, count_var, memory.raised)
        memory.spin *= math.exp(SPIN_GAIN * (min(nis, 9.0) - SPIN_NIS))
        memory.spin = min(max(memory.spin, 1.0), MOST_SPIN)
        shift(memory, REAR_TRAVEL, -counted)
    else:
        error = speed - model.rear_row(memory.x, memory.rim_mps, age + tau, h)
        followed(memory, FROM_REAR, W, W, 0.0, h, error, variance, 5.0)
        if tau > 0.0:
            restart(memory, REAR_TRAVEL, count_var)
            memory.rear_spans = 1
    accel, n = 0.0, 0
    for i in range(4):
        if math.isfinite(signal.wheel_accel_mps2[i]):
            accel += signal.wheel_accel_mps2[i]
            n += 1
    if n:
        dt = min(max((signal.epoch_ns - memory.rear_ns) * 1e-9, 0.0), 0.1)
        by = tuning.measured_slip_psd * memory.rim_mps**2 * dt
        grow_evenly(memory, W, RIM_RATE, by, dt)
        error = accel / n - model.wheel_accel_row(memory.x, tuning.usual_tau, h)
        followed(memory, FROM_REAR, RIM_RATE, W, dt, h, error, 0.06**2, 3.0)


@compiled
def _stand(rear: float, front: float, h: Array, memory: Record) -> None:
    """A machine whose wheels all stand still stands still, and does not slip."""
    still = rear == 0.0 and (front == 0.0 or math.isnan(front)) and abs(memory.x[V]) < 0.1
    if still:
        h[:] = 0.0
        h[V] = 1.0
        take(memory.x, memory.cov, h, -memory.x[V], 0.01**2, 0)
        h[V], h[A] = 0.0, 1.0
        take(memory.x, memory.cov, h, -memory.x[A], 0.05**2, 0)
        restart(memory, W, 0.05**2)
        restart(memory, RIM_RATE, 0.3**2)


@compiled
def _zero(raised: float, h: Array, tuning: Record, memory: Record) -> None:
    """The zero condition: with the plough out of the ground the axle slips by a little known.

    The slip that pulls nothing is 0.2-0.9 %, rolling resistance adds as much. Measured once per
    second's worth of samples, since it is one fact and not fifty. When the plough goes down the
    driven tyres carry less and their radius grows.
    """
    if raised == 1.0:
        memory.flags |= RAISED
        if memory.raised == 0:
            memory.raised = 1
            if memory.lowered:
                _reload(-1.0, tuning, memory)
        if abs(memory.x[V]) > 0.5 and abs(memory.x[A]) < 0.3:
            error = -model.zero_row(memory.x, tuning.zero_slip, h)
            variance = (tuning.zero_slip_sd * memory.rim_mps) ** 2
            take(memory.x, memory.cov, h, error, variance, 1)
    elif raised == 0.0 and memory.raised == 1:
        memory.raised, memory.lowered = 0, 1
        _reload(1.0, tuning, memory)
        grow(memory, USUAL, USUAL, 0.15**2)  # the plough will ask for another slip


@compiled
def _reload(down: float, tuning: Record, memory: Record) -> None:
    """What the wheels carry moves from rear to front as the plough goes down: so do their radii."""
    shift(memory, RADIUS, down * tuning.unload)
    grow(memory, RADIUS, RADIUS, tuning.unload_sd**2)
    shift(memory, SKID, down * tuning.load)
    grow(memory, SKID, SKID, tuning.load_sd**2)
    grow(memory, ACCEL_BIAS, ACCEL_BIAS, tuning.settle_sd**2)
