"""How the state moves: x <- f(x),  P <- F P F^T + Q,  with F = df/dx.

    v'  = v + a dt                              a'  = a exp(-dt / tau)  + white
    w'  = w + r dt                              r'  = r exp(-dt / tau)  + white
    rear'  = rear  + (w + rim swing) dt
    front' = front + hypot(v, wheelbase yaw rate) (1 + towed + quick) dt
    bias'  = bias + tilting dt                  swing'' = -2 z p swing' - p^2 swing + white
    slip   = 1 - v (1 + radius) / (w + rim swing)

The states are the two speeds and not the slip: what counters, GNSS and accelerometers measure is
then linear in them, and a filter that has nothing but the driven wheels' counts knows w and stays
as uncertain of v as it is. In a curve a front wheel rolls further than the rear-axle centre.
"""

from __future__ import annotations

import math

from estimators.kalman import Array, Record
from estimators.slip_ekf.layout import (
    ACROSS,
    BIAS,
    CAMERA,
    FRONT,
    LATE,
    QUICK,
    RADIUS,
    RATE,
    REAR,
    RECEIVER,
    SIZE,
    SWING,
    SWING_RATE,
    TILTING,
    TOWED,
    TRACTION,
    WHEEL_BIAS,
    A,
    V,
    W,
)
from twin.compute.compiled import array_law


@array_law
def longer(v: float, front_turn: float) -> tuple[float, float]:
    """Way of a front wheel over that of the rear-axle centre, and its derivative by v times v.

    hypot(v, b) / |v|,   v d/dv (hypot(v, b) / |v|) + that = |v| / hypot(v, b)

    Args:
        v: speed of the rear-axle centre [m/s].
        front_turn: b = wheelbase times yaw rate [m/s].
    """
    slow = max(abs(v), 0.1)
    way = math.hypot(slow, front_turn)
    return way / slow, slow / way


@array_law
def step(
    x: Array, rim: float, front_turn: float, fading_s: float, dt: float, tuning: Record, f: Array
) -> None:
    """Carry the mean, and fill F. What goes with `rim` takes the averaged speed as gradient.

    Args:
        x: mean, (SIZE,), changed in place.
        rim: counted speed of the driven wheels, averaged [m/s].
        front_turn: wheelbase times yaw rate [m/s].
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
    w = x[W] + rim * x[SWING] + half * (x[RATE] + rim * x[SWING_RATE])
    f[REAR, W], f[REAR, RATE] = dt, dt * half
    f[REAR, SWING], f[REAR, SWING_RATE] = rim * dt, rim * dt * half
    way, by_v = longer(v, front_turn)
    towed = 1.0 + x[TOWED] + x[QUICK]
    f[FRONT, V], f[FRONT, A] = dt * by_v * towed, dt * half * by_v * towed
    f[FRONT, TOWED] = f[FRONT, QUICK] = dt * way * v
    x[REAR] += dt * w
    x[FRONT] += dt * way * v * towed
    f[W, RATE] = dt
    x[W] += dt * x[RATE]
    f[V, A] = dt
    x[V] += dt * x[A]
    f[BIAS, TILTING] = dt
    x[BIAS] += dt * x[TILTING]
    for i, lasts_s in (
        (A, fading_s),
        (RATE, fading_s),
        (QUICK, tuning.quick_s),
        (RECEIVER, tuning.receiver_s),
        (TOWED, tuning.towed_s),
    ):
        f[i, i] = math.exp(-dt / lasts_s)
        x[i] *= f[i, i]
    _swing(x, f, dt, tuning)


@array_law
def _swing(x: Array, f: Array, dt: float, tuning: Record) -> None:
    """The damped oscillator, exactly."""
    p, z = 2.0 * math.pi * tuning.swing_hz, SWING_DAMPING
    free = p * math.sqrt(1.0 - z * z)
    fade, c, s = math.exp(-z * p * dt), math.cos(free * dt), math.sin(free * dt)
    f[SWING, SWING], f[SWING, SWING_RATE] = fade * (c + z * p / free * s), fade * s / free
    f[SWING_RATE, SWING] = -fade * p * p / free * s
    f[SWING_RATE, SWING_RATE] = fade * (c - z * p / free * s)
    low, high = x[SWING], x[SWING_RATE]
    x[SWING] = f[SWING, SWING] * low + f[SWING, SWING_RATE] * high
    x[SWING_RATE] = f[SWING_RATE, SWING] * low + f[SWING_RATE, SWING_RATE] * high


SWING_DAMPING = 0.15
"""Damping ratio of a tractor that pitches on its tyres."""


@array_law
def noise(
    f: Array, jerk: float, wheel: float, both: float, receiver_var: float, quick_var: float,
    camera_psd: float, gravity: float, dt: float, tuning: Record, q: Array,
) -> None:  # fmt: skip
    """Fill Q of a step.

    Args:
        f: F of the step.
        jerk, wheel, both: densities of the noise on a, on r, and of both together [m2/s5].
        receiver_var: variance of GNSS's lasting error [m2/s2].
        quick_var: variance of the towed wheels' quick error.
        camera_psd: density of the walk of a camera's scale [1/s].
        gravity: 1 where gravity leaks into the accelerations, else 0.
        dt: the step [s].
        tuning: record of the filter's constants.
        q: Q, (SIZE, SIZE), filled.
    """
    q[:, :] = 0.0
    shaken(q, jerk, wheel, both, dt)
    for i, var in ((QUICK, quick_var), (RECEIVER, receiver_var), (TOWED, tuning.scale_sd**2)):
        q[i, i] = var * (1.0 - f[i, i] ** 2)  # keeps the variance of what is forgotten
    at = tuning.swing_sd**2
    rate = at * (2.0 * math.pi * tuning.swing_hz) ** 2
    a, b, c, d = (
        f[SWING, SWING],
        f[SWING, SWING_RATE],
        f[SWING_RATE, SWING],
        f[SWING_RATE, SWING_RATE],
    )
    q[SWING, SWING] = at - a * a * at - b * b * rate
    q[SWING_RATE, SWING_RATE] = rate - c * c * at - d * d * rate
    q[SWING, SWING_RATE] = q[SWING_RATE, SWING] = -(a * c * at + b * d * rate)
    q[BIAS, BIAS] = (tuning.bias_psd + gravity * tuning.leak_psd) * dt
    q[WHEEL_BIAS, WHEEL_BIAS] = tuning.bias_psd * dt
    q[TRACTION, TRACTION] = tuning.traction_psd * dt
    q[CAMERA, CAMERA] = camera_psd * dt
    q[RADIUS, RADIUS] = q[LATE, LATE] = 1e-9 * dt
    q[ACROSS, ACROSS] = tuning.across_psd * dt


@array_law
def shaken(q: Array, jerk: float, wheel: float, both: float, dt: float) -> None:
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
        (RATE, RATE, wheel * dt),
    ):
        q[one, other] += density
    for one, other, density in (
        (V, A, jerk * dt**2 / 2.0),
        (W, RATE, wheel * dt**2 / 2.0),
        (A, RATE, both * dt),
        (V, RATE, both * dt**2 / 2.0),
        (A, W, both * dt**2 / 2.0),
        (V, W, both * dt**3 / 3.0),
    ):
        q[one, other] += density
        q[other, one] += density


@array_law
def carry(p: Array, f: Array, q: Array, room: Array) -> None:
    """P <- F P F^T + Q, with the zeros of F skipped; P stays symmetric to the bit.

    F P F^T = F (F P)^T as P is symmetric.
    """
    _times(f, p, room)
    for i in range(SIZE):
        for j in range(SIZE):
            p[i, j] = room[j, i]
    _times(f, p, room)
    for i in range(SIZE):
        for j in range(i, SIZE):
            p[i, j] = p[j, i] = room[i, j] + q[i, j]


@array_law
def _times(f: Array, p: Array, out: Array) -> None:
    """out = F P, row by row."""
    for i in range(SIZE):
        own = f[i, i]
        for j in range(SIZE):
            out[i, j] = own * p[i, j]
        for k in range(SIZE):
            if k != i and f[i, k] != 0.0:
                by = f[i, k]
                for j in range(SIZE):
                    out[i, j] += by * p[k, j]
