"""How the state moves, and the rows that measure it.

    dv = a dt                         da = white (jerk)
    db = (tilting - g q) dt           q: pitch rate as the gyro has it, an input, nose down
    ds = s' dt - (s - usual) dt / tau ds' = -s' / tau + white, against that of the jerk: under load
                                      the wheels, held by the governor, keep their speed
    slip = s + o                      o'' = -2 z w o' - w^2 o + white, w = 2 pi swing_hz
    d rear travel  = w (1 + radius + quick radius) dt,   w = v / (1 - slip)
    d front travel = v (1 + skid + quick skid) dt

Inside the filter slip is 1 - v / w on both sides of 0, which for a braked wheel is not the reported
(w - v) / max(|w|, |v|): so v + w slip = w stays one straight line, along which a filter that has
nothing but the wheels' counts must stay uncertain. For the same reason its direction is taken from
the counted speed, averaged (`rim`), and not from the estimates: a direction that trembles with them
tells the filter, wrongly, where on the line it is (Huang, Mourikis and Roumeliotis 2010, on the
consistency of the EKF).

Tractors on tyres pitch at 2 to 3 Hz without suspension, and slip with the forces that come of it.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled
from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import (
    ACCEL_BIAS,
    DS,
    FRONT_TRAVEL,
    LATE,
    QUICK_RADIUS,
    QUICK_SKID,
    RADIUS,
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

LARGEST_SLIP, LEAST_SLIP = 0.97, -20.0
"""Slip is kept between these, so that the wheel's speed stays finite."""


@compiled
def gearing(slip: float) -> float:
    """w / v = 1 / (1 - slip)"""
    return 1.0 / (1.0 - min(max(slip, LEAST_SLIP), LARGEST_SLIP))


@compiled
def slip_of(x: Array) -> float:
    """Slip of the driven axle."""
    return float(x[S] + x[SWING])


@compiled
def slip_var(p: Array) -> float:
    """Its variance."""
    return float(p[S, S] + 2.0 * p[S, SWING] + p[SWING, SWING])


@compiled
def _swing(x: Array, p: Array, dt: float, tuning: Record) -> None:
    """Step the oscillator exactly; its noise is what keeps its variance, P - Phi P Phi^T."""
    w, z = 2.0 * math.pi * tuning.swing_hz, tuning.swing_damping
    free = w * math.sqrt(1.0 - z * z)
    fade, c, s = math.exp(-z * w * dt), math.cos(free * dt), math.sin(free * dt)
    a, b = fade * (c + z * w / free * s), fade * s / free
    k, d = -fade * w * w / free * s, fade * (c - z * w / free * s)
    low, high = x[SWING], x[SWING_RATE]
    x[SWING], x[SWING_RATE] = a * low + b * high, k * low + d * high
    for j in range(SIZE):
        low, high = p[SWING, j], p[SWING_RATE, j]
        p[SWING, j], p[SWING_RATE, j] = a * low + b * high, k * low + d * high
    for j in range(SIZE):
        low, high = p[j, SWING], p[j, SWING_RATE]
        p[j, SWING], p[j, SWING_RATE] = a * low + b * high, k * low + d * high
    at, rate = tuning.swing_sd**2, (tuning.swing_sd * w) ** 2
    p[SWING, SWING] += at - a * a * at - b * b * rate
    p[SWING_RATE, SWING_RATE] += rate - k * k * at - d * d * rate
    p[SWING, SWING_RATE] -= a * k * at + b * d * rate
    p[SWING_RATE, SWING] -= a * k * at + b * d * rate


@compiled
def _mix(p: Array, target: int, source: Array) -> None:
    """P <- E P E^T for E the identity with the row `target` replaced by it plus `source`."""
    at, n = np.empty(SIZE, np.int64), 0  # the few that are not zero
    for k in range(SIZE):
        if source[k] != 0.0:
            at[n] = k
            n += 1
    for j in range(SIZE):
        total = 0.0
        for m in range(n):
            total += source[at[m]] * p[at[m], j]
        p[target, j] += total
    for i in range(SIZE):
        total = 0.0
        for m in range(n):
            total += p[i, at[m]] * source[at[m]]
        p[i, target] += total


@compiled
def _fade(x: Array, p: Array, i: int, by: float, variance: float) -> None:
    """A Gauss-Markov state: x_i <- by x_i, and the noise that keeps its variance."""
    x[i] *= by
    for j in range(SIZE):
        p[i, j] *= by
    for j in range(SIZE):
        p[j, i] *= by
    p[i, i] += variance * (1.0 - by * by)


@compiled
def carry(x: Array, p: Array, rim: float, coupling: float, dt: float, tuning: Record) -> None:
    """Predict over a step. The couplings are few, so P <- F P F^T goes row by row.

    Args:
        x: mean, (SIZE,), changed in place.
        p: covariance, (SIZE, SIZE), changed in place.
        rim: counted speed of the driven wheels, averaged [m/s].
        coupling: correlation of the jerk's noise with the slip's, positive where one slows the
            machine and the other lets it slip.
        dt: the step [s].
        tuning: record of `tuning.TUNING`.
    """
    half = 0.5 * dt
    v = x[V] + half * x[A]
    s = slip_of(x) + half * (x[DS] + x[SWING_RATE])
    ratio = gearing(s)
    driven = 1.0 + x[RADIUS] + x[QUICK_RADIUS]
    towed = 1.0 + x[SKID] + x[QUICK_SKID]
    row = np.zeros(SIZE)
    row[V], row[A] = dt * ratio * driven, dt * half * ratio * driven
    row[S], row[DS] = dt * rim * ratio * driven, dt * half * rim * ratio * driven
    row[SWING], row[SWING_RATE] = row[S], row[DS]
    row[RADIUS] = row[QUICK_RADIUS] = dt * v * ratio
    _mix(p, REAR_TRAVEL, row)
    row[:] = 0.0
    row[V], row[A] = dt * towed, dt * half * towed
    row[SKID] = row[QUICK_SKID] = dt * v
    _mix(p, FRONT_TRAVEL, row)
    row[:] = 0.0
    row[A] = dt
    _mix(p, V, row)
    row[:] = 0.0
    back = dt / tuning.usual_tau
    row[DS], row[S], row[USUAL] = dt, -back, back
    _mix(p, S, row)
    row[:] = 0.0
    row[TILTING] = dt
    _mix(p, ACCEL_BIAS, row)
    x[ACCEL_BIAS] += dt * x[TILTING]
    x[REAR_TRAVEL] += dt * v * ratio * driven
    x[FRONT_TRAVEL] += dt * v * towed
    x[V] += dt * x[A]
    x[S] = max(LEAST_SLIP, min(LARGEST_SLIP, x[S] + dt * x[DS] + back * (x[USUAL] - x[S])))
    _swing(x, p, dt, tuning)
    _fade(x, p, A, math.exp(-dt / tuning.accel_tau), 0.0)
    _fade(x, p, DS, math.exp(-dt / tuning.slip_tau), 0.0)
    _fade(x, p, QUICK_SKID, math.exp(-dt / tuning.quick_tau), tuning.quick_skid_sd**2)
    _fade(x, p, QUICK_RADIUS, math.exp(-dt / tuning.quick_tau), tuning.quick_radius_sd**2)
    _integrated(p, V, A, tuning.jerk_psd, dt)
    _integrated(p, S, DS, tuning.slip_psd, dt)
    together = coupling * math.sqrt(tuning.jerk_psd * tuning.slip_psd)
    _together(p, math.copysign(together, -x[V]), dt)
    p[ACCEL_BIAS, ACCEL_BIAS] += tuning.bias_psd * dt
    p[WHEEL_BIAS, WHEEL_BIAS] += tuning.bias_psd * dt
    p[RADIUS, RADIUS] += tuning.radius_psd * dt
    p[SKID, SKID] += tuning.skid_psd * dt
    p[USUAL, USUAL] += tuning.usual_psd * dt
    p[LATE, LATE] += 1e-9 * dt


@compiled
def _integrated(p: Array, low: int, high: int, psd: float, dt: float) -> None:
    """White noise of density `psd` on state `high`, integrated into state `low`."""
    p[high, high] += psd * dt
    p[low, low] += psd * dt**3 / 3.0
    p[low, high] += psd * dt * dt / 2.0
    p[high, low] += psd * dt * dt / 2.0


@compiled
def _together(p: Array, density: float, dt: float) -> None:
    """Joint density of the noise on jerk and on the slip's second derivative, integrated."""
    for at_v, at_s, share in ((A, DS, dt), (V, DS, 0.5 * dt**2), (A, S, 0.5 * dt**2)):
        p[at_v, at_s] += density * share
        p[at_s, at_v] += density * share
    p[V, S] += density * dt**3 / 3.0
    p[S, V] += density * dt**3 / 3.0


@compiled
def ground_row(x: Array, age: float, h: Array) -> float:
    """GNSS of `age` ago: v - a (age + late)."""
    lag = age + x[LATE]
    h[:] = 0.0
    h[V], h[A], h[LATE] = 1.0, -lag, -x[A]
    return float(x[V] - lag * x[A])


@compiled
def rear_row(x: Array, rim: float, age: float, h: Array) -> float:
    """Speed of the driven wheels as their nominal radius gives it, `age` ago."""
    h[:] = 0.0
    v = x[V] - age * x[A]
    s = slip_of(x) - age * (x[DS] + x[SWING_RATE])
    ratio = gearing(s)
    scale = 1.0 + x[RADIUS] + x[QUICK_RADIUS]
    h[V], h[A] = ratio * scale, -age * ratio * scale
    h[S], h[DS] = rim * ratio * scale, -age * rim * ratio * scale
    h[SWING], h[SWING_RATE] = h[S], h[DS]
    h[RADIUS] = h[QUICK_RADIUS] = v * ratio
    return float(v * ratio * scale)


@compiled
def front_row(x: Array, age: float, h: Array) -> float:
    """Speed of the towed wheels as their nominal radius gives it, `age` ago."""
    h[:] = 0.0
    v = x[V] - age * x[A]
    scale = 1.0 + x[SKID] + x[QUICK_SKID]
    h[V], h[A], h[SKID], h[QUICK_SKID] = scale, -age * scale, v, v
    return float(v * scale)


@compiled
def wheel_accel_row(x: Array, usual_tau: float, h: Array) -> float:
    """Acceleration of the driven wheels' rim: dw/dt + bias, dw/dt = a w/v + v (dw/ds)/v s'."""
    h[:] = 0.0
    slip = slip_of(x)
    rate = x[DS] + x[SWING_RATE] + (x[USUAL] - x[S]) / usual_tau
    ratio = gearing(slip)
    slope, steeper = ratio**2, 2.0 * ratio**3
    h[V], h[A] = slope * rate, ratio
    h[S] = h[SWING] = x[A] * slope + x[V] * steeper * rate
    h[DS] = h[SWING_RATE] = x[V] * slope
    h[USUAL] = x[V] * slope / usual_tau
    h[S] -= h[USUAL]
    h[WHEEL_BIAS] = 1.0
    return float(x[A] * ratio + x[V] * slope * rate + x[WHEEL_BIAS])
