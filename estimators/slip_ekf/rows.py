"""What each source measures: h(x), and its row H = dh/dx filled in place.

One function per kind of measurement, and none knows how the state moves.
"""

from __future__ import annotations

from estimators.kalman import Array
from estimators.slip_ekf.brixius import slip_of
from estimators.slip_ekf.layout import (
    BIAS,
    CAMERA,
    GNSS_BIAS,
    LATENCY,
    PITCH_SLIP,
    PITCH_SLIP_RATE,
    RADIUS,
    READ_DELAY,
    TOWED,
    TOWED_FAST,
    TRACTION,
    UNLOADED_SLIP,
    W_RATE,
    WHEEL_BIAS,
    A,
    V,
    W,
)
from estimators.slip_ekf.motion import front_path
from twin.compute.compiled import array_law


@array_law
def gnss(x: Array, age: float, h: Array) -> float:
    """Ground speed of `age` ago: v - a (age + late) + receiver [m/s]."""
    lag = age + x[LATENCY]
    h[:] = 0.0
    h[V], h[A], h[LATENCY], h[GNSS_BIAS] = 1.0, -lag, -x[A], 1.0
    return float(x[V] - lag * x[A] + x[GNSS_BIAS])


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
def towed(x: Array, age: float, front_turn_mps: float, h: Array) -> float:
    """Speed of the towed wheels as their nominal radius gives it, `age` ago.

    hypot(v - a age, wheelbase yaw rate) (1 + towed + quick)
    """
    h[:] = 0.0
    v, scale = x[V] - age * x[A], 1.0 + x[TOWED] + x[TOWED_FAST]
    path_ratio, by_v = front_path(v, front_turn_mps)
    h[V], h[A], h[TOWED], h[TOWED_FAST] = (
        by_v * scale,
        -age * by_v * scale,
        path_ratio * v,
        path_ratio * v,
    )
    return float(path_ratio * v * scale)


@array_law
def driven(x: Array, rim: float, age: float, h: Array) -> float:
    """Speed of the driven wheels as their nominal radius gives it, `age` ago.

    w + rim p - age (r + rim p')
    """
    h[:] = 0.0
    h[W], h[W_RATE], h[PITCH_SLIP], h[PITCH_SLIP_RATE] = 1.0, -age, rim, -age * rim
    return float(x[W] + rim * x[PITCH_SLIP] - age * (x[W_RATE] + rim * x[PITCH_SLIP_RATE]))


@array_law
def travel(x: Array, state: int, speed: float, h: Array) -> float:
    """Counted travel since the last count [m]: REAR or FRONT + speed reading.

    Both axles are read at once: by how much too late is one unknown.
    """
    h[:] = 0.0
    h[state], h[READ_DELAY] = 1.0, speed
    return float(x[state] + speed * x[READ_DELAY])


@array_law
def wheel_accel(x: Array, h: Array) -> float:
    """Acceleration of the driven rims: r + bias [m/s2]."""
    h[:] = 0.0
    h[W_RATE] = h[WHEEL_BIAS] = 1.0
    return float(x[W_RATE] + x[WHEEL_BIAS])


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
    h[W], h[V], h[RADIUS], h[UNLOADED_SLIP] = 1.0 - x[UNLOADED_SLIP], -1.0 - x[RADIUS], -rim, -rim
    return float(x[W] * (1.0 - x[UNLOADED_SLIP]) - x[V] * (1.0 + x[RADIUS]))


@array_law
def wheel_speed(x: Array, rim: float, h: Array) -> float:
    """Speed of the driven wheels with their true radius: (w + rim p) / (1 + radius)."""
    h[:] = 0.0
    scale = 1.0 / (1.0 + x[RADIUS])
    h[W], h[PITCH_SLIP], h[RADIUS] = scale, rim * scale, -rim * scale
    return float((x[W] + rim * x[PITCH_SLIP]) * scale)


@array_law
def one(state: int, h: Array) -> None:
    """The row of a state itself."""
    h[:] = 0.0
    h[state] = 1.0
