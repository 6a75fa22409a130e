"""How the state moves, and the rows that measure it.

    dv = a dt                         da = white (jerk)
    dw = w' dt - (w - v / (1 - usual)) dt / tau
                                      dw' = white, together with the jerk's (below)
    db = (tilting - g q) dt           q: pitch rate as the gyro has it, an input, nose down
    o'' = -2 z p o' - p^2 o + white   slip that comes of pitching, p = 2 pi swing_hz
    d rear travel  = (w + rim o) (1 + radius + quick radius) dt
    d front travel = v (1 + skid + quick skid) dt
    slip = 1 - v / (w + rim o)

The states are the two speeds and not the slip: what counters, GNSS and accelerometers measure is
then linear in them, and a filter that has nothing but the driven wheels' counts knows w and stays
as uncertain of v as it is. With slip as the state, v / (1 - s) = w is a curve, along which the
linearisation invents knowledge and drifts.

Tractors on tyres pitch at 2 to 3 Hz without suspension, and slip with the forces that come of it.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import (
    ACCEL_BIAS,
    CAMERA_SCALE,
    FRONT_TRAVEL,
    LATE,
    QUICK_RADIUS,
    QUICK_SKID,
    RADIUS,
    REAR_TRAVEL,
    RIM_RATE,
    SIZE,
    SKID,
    SWING,
    SWING_RATE,
    TILTING,
    USUAL,
    WHEEL_BIAS,
    A,
    V,
    W,
)
from twin.compute.compiled import compiled

LARGEST_SLIP, LEAST_SLIP = 0.9, -2.0
"""The usual slip is kept between these, so that the wheels' speed stays finite."""


@compiled
def gearing(slip: float) -> float:
    """w / v = 1 / (1 - slip)"""
    return 1.0 / (1.0 - min(max(slip, LEAST_SLIP), LARGEST_SLIP))


@compiled
def rim_speed(x: Array, rim: float) -> float:
    """Speed of the driven wheels' rims against the body, pitching's share with it [m/s]."""
    return float(x[W] + rim * x[SWING])


@compiled
def slip_var(p: Array, ground: float, wheel: float, rim: float, slow: float) -> float:
    """Variance of (w - v) / max(|w|, |v|), at least `slow`, from that of v, w and the swing.

    d slip = -dv / w + v / w^2 dw   where the wheels are the faster,   -w / v^2 dv + dw / v   else
    """
    if abs(wheel) >= abs(ground):
        turning = math.copysign(max(abs(wheel), slow), wheel)
        by_v, by_w = -1.0 / turning, ground / turning**2
    else:
        moving = math.copysign(max(abs(ground), slow), ground)
        by_v, by_w = -wheel / moving**2, 1.0 / moving
    total = 0.0
    rows = ((V, by_v), (W, by_w), (SWING, by_w * rim))
    for i, one in rows:
        for k, other in rows:
            total += one * other * p[i, k]
    return float(max(total, 0.0))


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
def carry(x: Array, p: Array, rim: float, restless: Array, dt: float, tuning: Record) -> None:
    """Predict over a step. The couplings are few, so P <- F P F^T goes row by row.

    Args:
        x: mean, (SIZE,), changed in place.
        p: covariance, (SIZE, SIZE), changed in place.
        rim: counted speed of the driven wheels, averaged [m/s].
        restless: densities of the noise on a', on w'' and of both together [m2/s5], and the time
            over which both accelerations are forgotten [s]; `noise.unrest`.
        dt: the step [s].
        tuning: record of `tuning.TUNING`.
    """
    half = 0.5 * dt
    v = x[V] + half * x[A]
    w = rim_speed(x, rim) + half * (x[RIM_RATE] + rim * x[SWING_RATE])
    driven = 1.0 + x[RADIUS] + x[QUICK_RADIUS]
    towed = 1.0 + x[SKID] + x[QUICK_SKID]
    row = np.zeros(SIZE)
    row[W], row[RIM_RATE] = dt * driven, dt * half * driven
    row[SWING], row[SWING_RATE] = rim * row[W], rim * row[RIM_RATE]
    row[RADIUS] = row[QUICK_RADIUS] = dt * rim
    _mix(p, REAR_TRAVEL, row)
    row[:] = 0.0
    row[V], row[A] = dt * towed, dt * half * towed
    row[SKID] = row[QUICK_SKID] = dt * v
    _mix(p, FRONT_TRAVEL, row)
    x[REAR_TRAVEL] += dt * w * driven
    x[FRONT_TRAVEL] += dt * v * towed
    row[:] = 0.0
    row[A] = dt
    _mix(p, V, row)
    x[V] += dt * x[A]
    row[:] = 0.0
    back, ratio = dt / tuning.usual_tau, gearing(x[USUAL])
    row[W], row[V], row[USUAL] = -back, back * ratio, back * rim * ratio
    row[RIM_RATE] = dt
    _mix(p, W, row)
    x[W] += dt * x[RIM_RATE] + back * (x[V] * ratio - x[W])
    row[:] = 0.0
    row[TILTING] = dt
    _mix(p, ACCEL_BIAS, row)
    x[ACCEL_BIAS] += dt * x[TILTING]
    _swing(x, p, dt, tuning)
    _fade(x, p, A, math.exp(-dt / restless[3]), 0.0)
    _fade(x, p, RIM_RATE, math.exp(-dt / restless[3]), 0.0)
    _fade(x, p, QUICK_SKID, math.exp(-dt / tuning.quick_tau), tuning.quick_skid_sd**2)
    _fade(x, p, QUICK_RADIUS, math.exp(-dt / tuning.quick_tau), tuning.quick_radius_sd**2)
    _integrated(p, V, A, restless[0], dt)
    _integrated(p, W, RIM_RATE, restless[1], dt)
    _together(p, restless[2], dt)
    p[ACCEL_BIAS, ACCEL_BIAS] += tuning.bias_psd * dt
    p[WHEEL_BIAS, WHEEL_BIAS] += tuning.bias_psd * dt
    p[RADIUS, RADIUS] += tuning.radius_psd * dt
    p[SKID, SKID] += tuning.skid_psd * dt
    p[USUAL, USUAL] += tuning.usual_psd * dt
    p[CAMERA_SCALE, CAMERA_SCALE] += tuning.camera_scale_psd * dt
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
    """Joint density of the noise on the jerk and on w'', integrated."""
    for at_v, at_w, share in ((A, RIM_RATE, dt), (V, RIM_RATE, 0.5 * dt**2), (A, W, 0.5 * dt**2)):
        p[at_v, at_w] += density * share
        p[at_w, at_v] += density * share
    p[V, W] += density * dt**3 / 3.0
    p[W, V] += density * dt**3 / 3.0


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
    w = rim_speed(x, rim) - age * (x[RIM_RATE] + rim * x[SWING_RATE])
    scale = 1.0 + x[RADIUS] + x[QUICK_RADIUS]
    h[W], h[RIM_RATE] = scale, -age * scale
    h[SWING], h[SWING_RATE] = rim * scale, -age * rim * scale
    h[RADIUS] = h[QUICK_RADIUS] = rim
    return float(w * scale)


@compiled
def front_row(x: Array, age: float, h: Array) -> float:
    """Speed of the towed wheels as their nominal radius gives it, `age` ago."""
    h[:] = 0.0
    v = x[V] - age * x[A]
    scale = 1.0 + x[SKID] + x[QUICK_SKID]
    h[V], h[A], h[SKID], h[QUICK_SKID] = scale, -age * scale, v, v
    return float(v * scale)


@compiled
def camera_row(x: Array, age: float, h: Array) -> float:
    """Ground speed as a camera of nominal height has it, `age` ago."""
    h[:] = 0.0
    v, scale = x[V] - age * x[A], 1.0 + x[CAMERA_SCALE]
    h[V], h[A], h[CAMERA_SCALE] = scale, -age * scale, v
    return float(v * scale)


@compiled
def wheel_accel_row(x: Array, usual_tau: float, h: Array) -> float:
    """Acceleration of the driven wheels' rims: w' - (w - v / (1 - usual)) / tau + bias."""
    h[:] = 0.0
    ratio = gearing(x[USUAL])
    h[RIM_RATE], h[W], h[WHEEL_BIAS] = 1.0, -1.0 / usual_tau, 1.0
    h[V], h[USUAL] = ratio / usual_tau, x[V] * ratio**2 / usual_tau
    return float(x[RIM_RATE] + (x[V] * ratio - x[W]) / usual_tau + x[WHEEL_BIAS])


@compiled
def zero_row(x: Array, zero_slip: float, h: Array) -> float:
    """By how much the driven wheels' speed is off what a slip known beforehand makes it [m/s]."""
    h[:] = 0.0
    h[W], h[V] = 1.0 - zero_slip, -1.0
    return float((1.0 - zero_slip) * x[W] - x[V])
