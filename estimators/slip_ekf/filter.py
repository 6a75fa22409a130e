"""The causal filter: every sample in order of arrival, at the epoch it was measured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.compiled import compiled
from estimators.estimate import SLOW_MPS
from estimators.kalman import Array, Record
from estimators.layout import (
    GNSS,
    GRAVITY_MPS2,
    IMU,
    NO_GROUND_SPEED,
    OUT_OF_ORDER,
    RESTARTED,
    STALE_S,
    WHEELS,
)
from estimators.slip_ekf import model
from estimators.slip_ekf.driven import axle, radius
from estimators.slip_ekf.layout import (
    ACCEL_BIAS,
    DS,
    FRONT_TRAVEL,
    GATED,
    LATE,
    NO_FRONT,
    NO_IMU,
    ONE_WHEEL,
    QUICK_RADIUS,
    QUICK_SKID,
    RADIUS,
    RAISED,
    REAR_TRAVEL,
    SIZE,
    SKID,
    SWING,
    SWING_RATE,
    TILTING,
    USUAL,
    WHEEL_BIAS,
    A,
    S,
    V,
)
from estimators.slip_ekf.noise import listen
from estimators.slip_ekf.pitch import rate_now, turn, turned
from estimators.slip_ekf.rows import followed, gated, grow, take

RIM_TAU_S = 0.5
"""Time over which the driven wheels' speed is averaged for the filter's gradients [s]."""
FROM_GNSS, FROM_IMU, FROM_FRONT, FROM_REAR = range(4)

TUNING = np.dtype(
    [
        (name, "f8")
        for name in (
            "jerk_psd", "accel_tau", "slip_psd", "measured_slip_psd", "load_correlation",
            "slip_tau", "usual_tau",
            "usual_psd", "swing_sd", "swing_hz", "swing_damping", "bias_sd",
            "bias_psd", "gyro_bias_sd",
            "radius_sd", "radius_psd", "skid_sd", "skid_psd",
            "quick_skid_sd", "quick_radius_sd", "quick_tau", "late_sd",
            "gate", "patience", "follow", "zero_slip", "zero_slip_sd", "unload", "unload_sd",
            "v_y_psd", "mount_sd", "accel_floor_sd",
        )
    ],
    align=True,
)  # fmt: skip


@compiled
def loop(
    signals: Any, raised: Array, nominal: Record, tuning: Record, memory: Record, rows: Any
) -> int:
    """Take the samples, write an estimate per wheel sample; returns how many."""
    n = 0
    h = np.zeros(SIZE)
    for i in range(len(signals)):
        signal = signals[i]
        memory.flags |= signal.flags
        if signal.flags & OUT_OF_ORDER:
            continue
        advance(signal.epoch_ns, tuning, memory)
        if measure(signal, raised[i], h, nominal, tuning, memory):
            report(rows[n], signal, nominal, tuning, memory)
            n += 1
    return n


@compiled
def measure(
    signal: Record, raised: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> bool:
    """Take a sample at its own epoch; whether an estimate is due, one per wheel sample."""
    age = (memory.time_ns - signal.epoch_ns) * 1e-9
    if age > STALE_S:
        memory.flags |= OUT_OF_ORDER
    elif signal.sensor == GNSS:
        _take_gnss(signal, age, h, tuning, memory)
    elif signal.sensor == IMU:
        _take_imu(signal, age, h, nominal, tuning, memory)
    elif signal.sensor == WHEELS:
        _take_wheels(signal, age, raised, h, nominal, tuning, memory)
        return True
    return False


@compiled
def advance(epoch_ns: int, tuning: Record, memory: Record) -> None:
    """Predict to a newer epoch; start again after a gap."""
    dt = (epoch_ns - memory.time_ns) * 1e-9
    if memory.time_ns >= 0 and dt > STALE_S:
        memory.known = 0
        memory.rear_spans = memory.front_spans = 0
        memory.first_mps = np.nan
        memory.v_y_ns = -1
        memory.flags |= RESTARTED
    elif memory.time_ns >= 0 and dt > 0.0 and memory.known:
        memory.travelled_m += memory.x[V] * dt
        memory.shift[:] = 0.0
        memory.cut[:] = 0
        memory.grown[:, :] = 0.0
        # slow motion is the driver's, who changes both speeds: the load shows in accelerations
        felt = memory.imu_ns >= 0 and epoch_ns - memory.imu_ns < 1_000_000_000
        coupling = tuning.load_correlation if felt else 0.0
        model.carry(memory.x, memory.cov, memory.rim_mps, coupling, dt, tuning)
    memory.time_ns = max(memory.time_ns, epoch_ns)


@compiled
def _take_gnss(signal: Record, age: float, h: Array, tuning: Record, memory: Record) -> None:
    speed, sd = signal.v_x_mps, signal.v_sd_mps
    if np.isfinite(speed) and np.isfinite(sd):
        if memory.known:
            error = speed - model.ground_row(memory.x, age, h)
            # what the motion did since, which v - a age does not know
            unknown = tuning.jerk_psd * age**3 / 3.0
            if gated(memory, FROM_GNSS, h, error, sd**2 + unknown, signal.epoch_ns, tuning):
                memory.measured_ns = signal.epoch_ns
            else:
                memory.flags |= GATED
        else:
            memory.first_mps, memory.first_var = speed, sd**2 + age**2
            memory.measured_ns = signal.epoch_ns
    if np.isfinite(signal.v_y_held_mps) and np.isfinite(speed):
        _take_across(signal, tuning, memory)


@compiled
def _take_across(signal: Record, tuning: Record, memory: Record) -> None:
    """A random walk of the velocity across the body, measured by GNSS with its heading."""
    measured, variance = signal.v_y_held_mps, signal.v_y_held_sd_mps**2
    if memory.v_y_ns < 0:
        memory.v_y, memory.v_y_var = measured, variance
    else:
        memory.v_y_var += tuning.v_y_psd * max(0.0, (signal.epoch_ns - memory.v_y_ns) * 1e-9)
        error, total = measured - memory.v_y, memory.v_y_var + variance
        if error * error < tuning.gate**2 * total:
            gain = memory.v_y_var / total
            memory.v_y += gain * error
            memory.v_y_var *= 1.0 - gain
        else:  # taken in part: a skid across is rare, a wrong heading is not
            memory.v_y_var += 0.1 * error * error
    memory.v_y_ns = signal.epoch_ns


@compiled
def _take_imu(
    signal: Record, age: float, h: Array, nominal: Record, tuning: Record, memory: Record
) -> None:
    accel = signal.accel_x_mps2
    dt = min(max((signal.epoch_ns - memory.imu_ns) * 1e-9, 0.0), 0.1)
    turn(signal.pitch_rate_radps, signal.epoch_ns, memory)
    if memory.known and np.isfinite(signal.gyro_y_radps):
        tilt = 0.5 * (memory.gyro_y + signal.gyro_y_radps) * dt if memory.gyro_y_known else 0.0
        _shift(memory, ACCEL_BIAS, -GRAVITY_MPS2 * tilt)
        memory.gyro_y, memory.gyro_y_known = signal.gyro_y_radps, 1
        # the unit stands above the axle: pitching moves it
        accel -= memory.pitch_accel * nominal.imu_m[2]
    accel += signal.yaw_rate_radps**2 * nominal.imu_m[0]
    memory.imu_ns = signal.epoch_ns
    if not np.isfinite(accel):
        return
    floor = nominal.accel_sd_mps2 if np.isfinite(nominal.accel_sd_mps2) else 0.0
    variance = listen(accel, max(floor, tuning.accel_floor_sd) ** 2, memory)
    if memory.known:
        h[:] = 0.0
        h[A] = h[ACCEL_BIAS] = 1.0
        error = accel - memory.x[A] - memory.x[ACCEL_BIAS]
        unknown = tuning.jerk_psd * age  # what the motion did since
        followed(memory, FROM_IMU, A, V, dt, h, error, variance + unknown, tuning.follow)


@compiled
def _take_wheels(
    signal: Record,
    age: float,
    raised: float,
    h: Array,
    nominal: Record,
    tuning: Record,
    memory: Record,
) -> None:
    wheels, sd = signal.wheel_mps, signal.wheel_sd_mps
    pitched = turned(signal.epoch_ns, memory)
    if not memory.known:
        _begin(signal, age, nominal, tuning, memory)
        return
    towed = model.front_row(memory.x, age, h)
    front, front_var, front_n = axle(wheels, sd, nominal, 0.0, towed, 0.0)
    predicted = model.rear_row(memory.x, memory.rim_mps, age, h)
    rear, rear_var, rear_n = axle(wheels, sd, nominal, 1.0, predicted, memory.apart_mps)
    if signal.one_driven_speed:
        rear_var *= rear_n
    if signal.one_towed_speed:
        front_var *= front_n
    if np.isfinite(rear):
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
def _restart(memory: Record, state: int, variance: float) -> None:
    """Count an axle's travel from here."""
    memory.cut[state] = 1
    memory.x[state] = 0.0
    memory.cov[state, :] = 0.0
    memory.cov[:, state] = 0.0
    memory.cov[state, state] = variance


@compiled
def _shift(memory: Record, state: int, by: float) -> None:
    """Move a state's origin."""
    memory.x[state] += by
    memory.shift[state] += by


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
    if not (np.isfinite(speed) and np.isfinite(variance)):
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
    if gated(memory, FROM_FRONT, h, error, count_var, signal.epoch_ns, tuning):
        memory.measured_ns = signal.epoch_ns
        if memory.front_spans:
            _shift(memory, FRONT_TRAVEL, -counted)
    else:
        memory.flags |= GATED
        memory.front_spans = 0
    if not memory.front_spans and tau > 0.0:
        _restart(memory, FRONT_TRAVEL, variance * 2.0 * tau**2)
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
    if not (np.isfinite(speed) and np.isfinite(variance)):
        memory.rear_spans = 0
        return
    tau = signal.wheel_age_s.max()
    counted, count_var = speed * 2.0 * tau, variance * 2.0 * tau**2
    if memory.rear_spans and age == 0.0 and _spans(signal, memory):
        h[:] = 0.0
        h[REAR_TRAVEL] = 1.0
        error = counted - memory.x[REAR_TRAVEL]
        followed(memory, FROM_REAR, REAR_TRAVEL, REAR_TRAVEL, 0.0, h, error, count_var, 5.0)
        _shift(memory, REAR_TRAVEL, -counted)
    else:
        error = speed - model.rear_row(memory.x, memory.rim_mps, age + tau, h)
        followed(memory, FROM_REAR, S, S, 0.0, h, error, variance, 5.0)
        if tau > 0.0:
            _restart(memory, REAR_TRAVEL, count_var)
            memory.rear_spans = 1
    accel, n = 0.0, 0
    for i in range(4):
        if np.isfinite(signal.wheel_accel_mps2[i]):
            accel += signal.wheel_accel_mps2[i]
            n += 1
    if n:
        dt = min(max((signal.epoch_ns - memory.rear_ns) * 1e-9, 0.0), 0.1)
        psd = tuning.measured_slip_psd
        grow(memory, DS, DS, psd * dt)
        grow(memory, S, S, psd * dt**3 / 3.0)
        grow(memory, S, DS, psd * dt * dt / 2.0)
        grow(memory, DS, S, psd * dt * dt / 2.0)
        error = accel / n - model.wheel_accel_row(memory.x, tuning.usual_tau, h)
        followed(memory, FROM_REAR, DS, S, dt, h, error, 0.06**2, 3.0)


@compiled
def _stand(rear: float, front: float, h: Array, memory: Record) -> None:
    """A machine whose wheels all stand still stands still, and does not slip."""
    still = rear == 0.0 and (front == 0.0 or np.isnan(front)) and abs(memory.x[V]) < 0.1
    if still:
        h[:] = 0.0
        h[V] = 1.0
        take(memory.x, memory.cov, h, -memory.x[V], 0.01**2, 0)
        h[V], h[A] = 0.0, 1.0
        take(memory.x, memory.cov, h, -memory.x[A], 0.05**2, 0)
        _restart(memory, S, 0.05**2)
        _restart(memory, DS, 0.3**2)


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
        if abs(memory.x[V]) > 0.5 and abs(memory.x[A]) < 0.3:
            h[:] = 0.0
            h[S] = 1.0
            error = tuning.zero_slip - memory.x[S]
            take(memory.x, memory.cov, h, error, tuning.zero_slip_sd**2, 1)
    elif raised == 0.0 and memory.raised == 1:
        memory.raised = 0
        _shift(memory, RADIUS, tuning.unload)
        grow(memory, RADIUS, RADIUS, tuning.unload_sd**2)
        grow(memory, USUAL, USUAL, 0.15**2)  # the plough will ask for another slip


@compiled
def _begin(signal: Record, age: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Begin with the first ground speed and the slip it makes with the driven wheels' speed."""
    wheels, sd = signal.wheel_mps, signal.wheel_sd_mps
    front, front_var, _ = axle(wheels, sd, nominal, 0.0, np.nan, 0.0)
    rear, rear_var, _ = axle(wheels, sd, nominal, 1.0, np.nan, 0.0)
    speed, variance = memory.first_mps, memory.first_var
    if np.isfinite(front):
        front_var += (tuning.skid_sd * front) ** 2
        if np.isfinite(speed):
            share = variance / (variance + front_var)
            speed, variance = speed + share * (front - speed), variance * (1.0 - share)
        else:
            speed, variance = front, front_var
            memory.measured_ns = signal.epoch_ns
    if not np.isfinite(speed) or not np.isfinite(rear):
        return
    memory.known = 1
    memory.rim_mps = rear
    memory.x[:] = 0.0
    memory.cov[:, :] = 0.0
    memory.x[V] = speed
    slow = max(abs(rear), abs(speed)) < 0.3
    if not slow:
        turning = math.copysign(max(abs(rear), 0.3), rear)
        memory.x[S] = max(-2.0, min(0.9, 1.0 - speed / turning))
    by_speed = 0.0 if slow else -1.0 / math.copysign(max(abs(rear), 0.3), rear)
    slip_var = 0.1**2 if slow else (rear_var + tuning.radius_sd**2 * rear**2) / max(rear**2, 0.09)
    memory.cov[V, V] = variance
    memory.cov[V, S] = memory.cov[S, V] = by_speed * variance
    memory.cov[S, S] = slip_var + by_speed**2 * variance
    for state, deviation in (
        (A, 1.0),
        (DS, 0.3),
        (ACCEL_BIAS, math.hypot(tuning.bias_sd, nominal.accel_bias_sd_mps2)),
        (RADIUS, tuning.radius_sd),
        (SKID, tuning.skid_sd),
        (QUICK_SKID, tuning.quick_skid_sd),
        (QUICK_RADIUS, tuning.quick_radius_sd),
        (LATE, tuning.late_sd),
        (WHEEL_BIAS, tuning.bias_sd),
        (TILTING, GRAVITY_MPS2 * tuning.gyro_bias_sd),
        (SWING, tuning.swing_sd),
        (SWING_RATE, tuning.swing_sd * 2.0 * math.pi * tuning.swing_hz),
    ):
        memory.cov[state, state] = deviation**2
    memory.gyro_y_known = 0
    memory.x[USUAL] = memory.x[S]
    memory.cov[USUAL, :] = memory.cov[S, :]
    memory.cov[:, USUAL] = memory.cov[:, S]
    memory.cov[USUAL, USUAL] = memory.cov[S, S] + 0.05**2
    if not slow:
        memory.cov[S, RADIUS] = memory.cov[RADIUS, S] = -(tuning.radius_sd**2) * (1.0 - memory.x[S])
    memory.rear_ns = signal.epoch_ns
    if signal.wheel_age_s.max() > 0.0:
        _restart(memory, REAR_TRAVEL, rear_var * 2.0 * signal.wheel_age_s.max() ** 2)
        memory.rear_spans = 1
        if np.isfinite(front):
            _restart(memory, FRONT_TRAVEL, rear_var * 2.0 * signal.wheel_age_s.max() ** 2)
            memory.front_spans = 1


@compiled
def report(row: Record, signal: Record, nominal: Record, tuning: Record, memory: Record) -> None:
    """Write the estimate of now; nothing where the ground speed is unknown for too long."""
    row.epoch_ns = memory.time_ns
    unknown = not memory.known or (memory.time_ns - memory.measured_ns) * 1e-9 > STALE_S
    if unknown:
        memory.flags |= NO_GROUND_SPEED
    if (memory.time_ns - memory.front_ns) * 1e-9 > 1.0 or memory.front_ns < 0:
        memory.flags |= NO_FRONT
    if (memory.time_ns - memory.imu_ns) * 1e-9 > 1.0 or memory.imu_ns < 0:
        memory.flags |= NO_IMU
    row.flags = memory.flags
    memory.flags = 0
    if not memory.known:
        return
    x, p = memory.x, memory.cov
    ratio = model.gearing(model.slip_of(x))
    # the driveline turns with the body: over the ground the wheels turn by its pitching more
    wheel = x[V] * ratio + radius(nominal, 1.0) * rate_now(memory)
    row.speed_mps, row.wheel_speed_mps = x[V], wheel
    row.slip = (wheel - x[V]) / max(abs(wheel), abs(x[V]), SLOW_MPS)
    # of a braked wheel w / v - 1 is reported, which changes by (w / v)^2 of 1 - v / w
    row.slip_sd = math.sqrt(max(model.slip_var(p), 0.0)) * min(1.0, ratio * ratio)
    across = 0.5 * signal.yaw_rate_radps * nominal.track_rear_m
    for side, at in ((-1.0, 2), (1.0, 3)):
        rim = wheel + side * 0.5 * memory.apart_mps
        ground = x[V] + side * across
        largest = max(abs(rim), abs(ground), SLOW_MPS)
        if at == 2:
            row.slip_rl = (rim - ground) / largest
        else:
            row.slip_rr = (rim - ground) / largest
    if memory.v_y_ns >= 0:
        _report_across(row, signal, nominal, tuning, memory)


@compiled
def _report_across(
    row: Record, signal: Record, nominal: Record, tuning: Record, memory: Record
) -> None:
    """Sideslip: its sd is that of v_y and of the antennas' mounting angle, which nothing tells."""
    ground = memory.x[V]
    since = max(0.0, (memory.time_ns - memory.v_y_ns) * 1e-9)
    v_y_cg = memory.v_y + nominal.cg_x_m * signal.yaw_rate_radps
    row.v_y_mps = v_y_cg
    row.sideslip_m, row.sideslip_rear_m = signal.sideslip_m, signal.sideslip_rear_m
    row.sideslip_sd_m = math.hypot(signal.sideslip_sd_m, tuning.mount_sd * memory.travelled_m)
    if abs(ground) >= SLOW_MPS:
        row.sideslip_rear_rad = math.atan2(memory.v_y, ground)
        row.sideslip_rad = math.atan2(v_y_cg, ground)
        variance = memory.v_y_var + tuning.v_y_psd * since
        row.sideslip_sd_rad = math.sqrt(variance / ground**2 + tuning.mount_sd**2)
