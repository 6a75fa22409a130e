"""What each source measures: h(x), and its row H = dh/dx filled in place.

One function per kind of measurement, and none knows how the state moves.
"""

from __future__ import annotations

from estimators.kalman import Array
from estimators.slip_ekf.brixius import slip_of
from estimators.slip_ekf.layout import (
    BIAS,
    CAMERA,
    LATE,
    QUICK,
    RADIUS,
    RATE,
    READING,
    RECEIVER,
    SWING,
    SWING_RATE,
    TOWED,
    TRACTION,
    WHEEL_BIAS,
    ZERO,
    A,
    V,
    W,
)
from estimators.slip_ekf.motion import longer
from twin.compute.compiled import array_law


@array_law
def gnss(x: Array, age: float, h: Array) -> float:
    """Ground speed of `age` ago: v - a (age + late) + receiver [m/s]."""
    lag = age + x[LATE]
    h[:] = 0.0
    h[V], h[A], h[LATE], h[RECEIVER] = 1.0, -lag, -x[A], 1.0
    return float(x[V] - lag * x[A] + x[RECEIVER])


@array_law
def camera(x: Array, age: float, h: Array) -> float:
    """Ground speed as a camera of nominal height has it, `age` ago: (v - a age) (1 + camera)."""
    h[:] = 0.0
    v, scale = x[V] - age * x[A], 1.0 + x[CAMERA]
    h[V], h[A], h[CAMERA] = scale, -age * scale, v
    return float(v * scale)


@array_law
def accel(x: Array, h: Array) -> float:
    """An accelerometer along the body: a + bias [m/s2]."""
    h[:] = 0.0
    h[A] = h[BIAS] = 1.0
    return float(x[A] + x[BIAS])


@array_law
def towed(x: Array, age: float, front_turn: float, h: Array) -> float:
    """Speed of the towed wheels as their nominal radius gives it, `age` ago.

    hypot(v - a age, wheelbase yaw rate) (1 + towed + quick)
    """
    h[:] = 0.0
    v, scale = x[V] - age * x[A], 1.0 + x[TOWED] + x[QUICK]
    way, by_v = longer(v, front_turn)
    h[V], h[A], h[TOWED], h[QUICK] = by_v * scale, -age * by_v * scale, way * v, way * v
    return float(way * v * scale)


@array_law
def driven(x: Array, rim: float, age: float, h: Array) -> float:
    """Speed of the driven wheels as their nominal radius gives it, `age` ago.

    w + rim swing - age (r + rim swing')
    """
    h[:] = 0.0
    h[W], h[RATE], h[SWING], h[SWING_RATE] = 1.0, -age, rim, -age * rim
    return float(x[W] + rim * x[SWING] - age * (x[RATE] + rim * x[SWING_RATE]))


@array_law
def travel(x: Array, state: int, speed: float, h: Array) -> float:
    """Counted travel since the last count [m]: REAR or FRONT + speed reading.

    Both axles are read at once: by how much too late is one unknown.
    """
    h[:] = 0.0
    h[state], h[READING] = 1.0, speed
    return float(x[state] + speed * x[READING])


@array_law
def wheel_accel(x: Array, h: Array) -> float:
    """Acceleration of the driven rims: r + bias [m/s2]."""
    h[:] = 0.0
    h[RATE] = h[WHEEL_BIAS] = 1.0
    return float(x[RATE] + x[WHEEL_BIAS])


@array_law
def expected(x: Array, by_load: float, rim: float, h: Array) -> float:
    """How far the ground speed is off what the load makes it [m/s].

    v - w (1 - slip(traction + by_load))

    The gradient by traction is that at the mean load: one that went with the load would let the lag
    of v behind the load move the traction.
    """
    h[:] = 0.0
    slip, _ = slip_of(x[TRACTION] + by_load)
    _, steep = slip_of(x[TRACTION])
    h[V], h[W], h[TRACTION] = 1.0, slip - 1.0, rim * steep
    return float(x[V] - x[W] * (1.0 - slip))


@array_law
def no_slip(x: Array, rim: float, h: Array) -> float:
    """By how much the driven wheels turn more than the slip without load makes them [m/s].

    w (1 - zero) - v (1 + radius)
    """
    h[:] = 0.0
    h[W], h[V], h[RADIUS], h[ZERO] = 1.0 - x[ZERO], -1.0 - x[RADIUS], -rim, -rim
    return float(x[W] * (1.0 - x[ZERO]) - x[V] * (1.0 + x[RADIUS]))


@array_law
def wheel_speed(x: Array, rim: float, h: Array) -> float:
    """Speed of the driven wheels with their true radius: (w + rim swing) / (1 + radius)."""
    h[:] = 0.0
    scale = 1.0 / (1.0 + x[RADIUS])
    h[W], h[SWING], h[RADIUS] = scale, rim * scale, -rim * scale
    return float((x[W] + rim * x[SWING]) * scale)


@array_law
def one(state: int, h: Array) -> None:
    """The row of a state itself."""
    h[:] = 0.0
    h[state] = 1.0
