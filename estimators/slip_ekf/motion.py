"""How the state moves: x <- f(x),  P <- F P F^T + Q,  with F = df/dx.

    v'  = v + a dt                              a'  = a exp(-dt / tau)  + white
    w'  = w + r dt                              r'  = r exp(-dt / tau)  + white
    rear'  = rear  + (w + rim p) dt
    front' = front + hypot(v, wheelbase yaw rate) (1 + towed + quick) dt
    bias'  = bias + tilting dt                  p'' = -2 z p p' - p^2 swing + white
    slip   = 1 - v (1 + radius) / (w + rim p)

The states are the two speeds and not the slip: what counters, GNSS and accelerometers measure is
then linear in them, and a filter that has nothing but the driven wheels' counts knows w and stays
as uncertain of v as it is. In a curve a front wheel rolls further than the rear-axle centre.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import (
    BIAS,
    BIAS_RATE,
    CAMERA,
    FRONT,
    GNSS_BIAS,
    LATENCY,
    PITCH_SLIP,
    PITCH_SLIP_RATE,
    RADIUS,
    REAR,
    SIZE,
    TOWED,
    TOWED_FAST,
    TRACTION,
    V_Y,
    W_RATE,
    WHEEL_BIAS,
    A,
    V,
    W,
)
from twin.compute.compiled import array_law

COUPLED = np.array(
    [(V, A), (W, W_RATE), (BIAS, BIAS_RATE)]
    + [(REAR, i) for i in (W, W_RATE, PITCH_SLIP, PITCH_SLIP_RATE)]
    + [(FRONT, i) for i in (V, A, TOWED, TOWED_FAST)]
    + [(PITCH_SLIP, PITCH_SLIP_RATE), (PITCH_SLIP_RATE, PITCH_SLIP)]
)
"""Where F is not zero off its diagonal: which state changes by which other."""


@array_law
def front_path(v: float, front_turn_mps: float) -> tuple[float, float]:
    """Way of a front wheel over that of the rear-axle centre, and its derivative by v times v.

    hypot(v, b) / |v|,   v d/dv (hypot(v, b) / |v|) + that = |v| / hypot(v, b)

    Args:
        v: speed of the rear-axle centre [m/s].
        front_turn_mps: b = wheelbase times yaw rate [m/s].
    """
    slow = max(abs(v), 0.1)
    path_ratio = math.hypot(slow, front_turn_mps)
    return path_ratio / slow, slow / path_ratio


@array_law
def step(
    x: Array,
    rim: float,
    front_turn_mps: float,
    fading_s: float,
    dt: float,
    tuning: Record,
    f: Array,
) -> None:
    """Carry the mean, and fill F. What goes with `rim` takes the averaged speed as gradient.

    Args:
        x: mean, (SIZE,), changed in place.
        rim: counted speed of the driven wheels, averaged [m/s].
        front_turn_mps: wheelbase times yaw rate [m/s].
        fading_s: time over which accelerations are forgotten [s].
        dt: the step [s].
        tuning: record of the filter's constants.
        f: F, (SIZE, SIZE), filled.
    """
    f[:, :] = 0.0
    for i in range(SIZE):
        f[i, i] = 1.0
    half = 0.5 * dt
    v = x[V] + half * x[A]
    w = x[W] + rim * x[PITCH_SLIP] + half * (x[W_RATE] + rim * x[PITCH_SLIP_RATE])
    f[REAR, W], f[REAR, W_RATE] = dt, dt * half
    f[REAR, PITCH_SLIP], f[REAR, PITCH_SLIP_RATE] = rim * dt, rim * dt * half
    path_ratio, by_v = front_path(v, front_turn_mps)
    towed = 1.0 + x[TOWED] + x[TOWED_FAST]
    f[FRONT, V], f[FRONT, A] = dt * by_v * towed, dt * half * by_v * towed
    f[FRONT, TOWED] = f[FRONT, TOWED_FAST] = dt * path_ratio * v
    x[REAR] += dt * w
    x[FRONT] += dt * path_ratio * v * towed
    f[W, W_RATE] = dt
    x[W] += dt * x[W_RATE]
    f[V, A] = dt
    x[V] += dt * x[A]
    f[BIAS, BIAS_RATE] = dt
    x[BIAS] += dt * x[BIAS_RATE]
    for i, lasts_s in (
        (A, fading_s),
        (W_RATE, fading_s),
        (TOWED_FAST, tuning.towed_fast_s),
        (GNSS_BIAS, tuning.gnss_bias_s),
        (TOWED, tuning.towed_scale_s),
    ):
        f[i, i] = math.exp(-dt / lasts_s)
        x[i] *= f[i, i]
    _oscillate(x, f, dt, tuning)


@array_law
def _oscillate(x: Array, f: Array, dt: float, tuning: Record) -> None:
    """The damped oscillator, exactly."""
    p, z = 2.0 * math.pi * tuning.pitch_hz, PITCH_DAMPING
    free = p * math.sqrt(1.0 - z * z)
    fade, c, s = math.exp(-z * p * dt), math.cos(free * dt), math.sin(free * dt)
    f[PITCH_SLIP, PITCH_SLIP], f[PITCH_SLIP, PITCH_SLIP_RATE] = (
        fade * (c + z * p / free * s),
        fade * s / free,
    )
    f[PITCH_SLIP_RATE, PITCH_SLIP] = -fade * p * p / free * s
    f[PITCH_SLIP_RATE, PITCH_SLIP_RATE] = fade * (c - z * p / free * s)
    low, high = x[PITCH_SLIP], x[PITCH_SLIP_RATE]
    x[PITCH_SLIP] = f[PITCH_SLIP, PITCH_SLIP] * low + f[PITCH_SLIP, PITCH_SLIP_RATE] * high
    x[PITCH_SLIP_RATE] = (
        f[PITCH_SLIP_RATE, PITCH_SLIP] * low + f[PITCH_SLIP_RATE, PITCH_SLIP_RATE] * high
    )


TURNING_PSD = 1e-4
"""Density of the walk of the towed wheels' scale, over (wheelbase yaw rate / v)^2 [1/s]: steered
wheels that scrub, as they do by 1 % on a headland of the twin."""
PITCH_DAMPING = 0.15
"""Damping ratio of a tractor that pitches on its tyres."""


@array_law
def noise(
    f: Array, jerk: float, wheel: float, both: float, gnss_bias_var: float, towed_fast_var: float,
    turn: float, camera_psd: float, gravity: float, dt: float, tuning: Record, q: Array,
) -> None:  # fmt: skip
    """Fill Q of a step.

    Args:
        f: F of the step.
        jerk, wheel, both: densities of the noise on a, on r, and of both together [m2/s5].
        gnss_bias_var: variance of GNSS's lasting error [m2/s2].
        towed_fast_var: variance of the towed wheels' quick error.
        turn: wheelbase times yaw rate over speed.
        camera_psd: density of the walk of a camera's scale [1/s].
        gravity: 1 where gravity leaks into the accelerations, else 0.
        dt: the step [s].
        tuning: record of the filter's constants.
        q: Q, (SIZE, SIZE), filled.
    """
    q[:, :] = 0.0
    add_jerk(q, jerk, wheel, both, dt)
    for i, var in (
        (TOWED_FAST, towed_fast_var),
        (GNSS_BIAS, gnss_bias_var),
        (TOWED, tuning.scale_sd**2),
    ):
        q[i, i] = var * (1.0 - f[i, i] ** 2)  # keeps the variance of what is forgotten
    q[TOWED, TOWED] += TURNING_PSD * turn**2 * dt
    at = tuning.pitch_slip_sd**2
    rate = at * (2.0 * math.pi * tuning.pitch_hz) ** 2
    a, b, c, d = (
        f[PITCH_SLIP, PITCH_SLIP],
        f[PITCH_SLIP, PITCH_SLIP_RATE],
        f[PITCH_SLIP_RATE, PITCH_SLIP],
        f[PITCH_SLIP_RATE, PITCH_SLIP_RATE],
    )
    q[PITCH_SLIP, PITCH_SLIP] = at - a * a * at - b * b * rate
    q[PITCH_SLIP_RATE, PITCH_SLIP_RATE] = rate - c * c * at - d * d * rate
    q[PITCH_SLIP, PITCH_SLIP_RATE] = q[PITCH_SLIP_RATE, PITCH_SLIP] = -(a * c * at + b * d * rate)
    q[BIAS, BIAS] = (tuning.bias_psd + gravity * tuning.gravity_psd) * dt
    q[WHEEL_BIAS, WHEEL_BIAS] = tuning.bias_psd * dt
    q[TRACTION, TRACTION] = tuning.traction_psd * dt
    q[CAMERA, CAMERA] = camera_psd * dt
    q[RADIUS, RADIUS] = q[LATENCY, LATENCY] = 1e-9 * dt
    q[V_Y, V_Y] = tuning.v_y_psd * dt


@array_law
def add_jerk(q: Array, jerk: float, wheel: float, both: float, dt: float) -> None:
    """Add the noise of a step's jerks: Q or P grows.

    Args:
        q: what grows, (SIZE, SIZE).
        jerk, wheel, both: densities of the white noise on a, on r, and of both together [m2/s5].
        dt: the step [s].
    """
    for one, other, density in (
        (V, V, jerk * dt**3 / 3.0),
        (A, A, jerk * dt),
        (W, W, wheel * dt**3 / 3.0),
        (W_RATE, W_RATE, wheel * dt),
    ):
        q[one, other] += density
    for one, other, density in (
        (V, A, jerk * dt**2 / 2.0),
        (W, W_RATE, wheel * dt**2 / 2.0),
        (A, W_RATE, both * dt),
        (V, W_RATE, both * dt**2 / 2.0),
        (A, W, both * dt**2 / 2.0),
        (V, W, both * dt**3 / 3.0),
    ):
        q[one, other] += density
        q[other, one] += density


@array_law
def propagate_covariance(p: Array, f: Array, q: Array, scratch: Array) -> None:
    """P <- F P F^T + Q, with F's zeros skipped; P stays symmetric to the bit.

    F P F^T = F (F P)^T as P is symmetric.
    """
    _times(f, p, scratch)
    for i in range(SIZE):
        for j in range(SIZE):
            p[i, j] = scratch[j, i]
    _times(f, p, scratch)
    for i in range(SIZE):
        for j in range(i, SIZE):
            p[i, j] = p[j, i] = scratch[i, j] + q[i, j]


@array_law
def _times(f: Array, p: Array, out: Array) -> None:
    """out = F P, of the rows of F what is not zero."""
    for i in range(SIZE):
        for j in range(SIZE):
            out[i, j] = f[i, i] * p[i, j]
    for n in range(len(COUPLED)):
        i, k = COUPLED[n]
        for j in range(SIZE):
            out[i, j] += f[i, k] * p[k, j]
