"""The laws of motion over the ground, one row for each instant of a table or each machine of many.

Slip has one definition, per wheel and for the driven axle (means of w R and v over the driven
wheels):

    s = (w R - v) / max(|w R|, |v|, 0.05 m/s)

v is the wheel centre's velocity along its rolling direction on the ground, R the radius at which
the law's own slip is zero. The ground plane's axes are the body's x axis a projected on it, and
that of its left:

    x = unit(a - (a . n) n)        y = n x x        v_x = x . v        v_y = y . v

No row depends on the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.compute.compiled import inlined_law, law
from twin.physics import rigid
from twin.physics.tyre import SLOWEST_MPS

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)
Places = NDArray[np.int64]
"""Places of the driven wheels in `twin.streams.WHEELS`."""

x_axis = inlined_law(quaternion.x_axis)


class Wheels(NamedTuple):
    """Motion of the four wheels, in the order of `twin.streams.WHEELS`. Shapes (n, 4)."""

    spin_radps: Array
    """Wheel speed w [rad/s]."""
    rolling_radius_m: Array
    """Rolling radius R [m]."""
    hub_mps: Array
    """Speed v of the wheel centre along the rolling direction [m/s]."""


class DrivenAxle(NamedTuple):
    """Means over the driven wheels. Shapes (n,)."""

    wheel_speed_mps: Array
    """Mean of w R [m/s]."""
    hub_mps: Array
    """Mean speed v of the wheel centres along their rolling direction [m/s]."""
    axle_radps: Array
    """Mean wheel speed w [rad/s]."""


def slip_ratio(wheel_speed_mps: Number, speed_mps: Number) -> Number:
    """s = (w R - v) / max(|w R|, |v|, 0.05 m/s); of numbers, or elementwise."""
    largest = np.maximum(np.abs(wheel_speed_mps), np.abs(speed_mps))
    slip: Number = (wheel_speed_mps - speed_mps) / np.maximum(largest, SLOWEST_MPS)
    return slip


def slip_ratio_of(wheel_speed_mps: float, speed_mps: float) -> float:
    """Slip s [-] of two finite numbers, as `slip_ratio`, in a tenth of the time."""
    largest = max(abs(wheel_speed_mps), abs(speed_mps), SLOWEST_MPS)
    return (wheel_speed_mps - speed_mps) / largest


def ground_velocity(world_from_body: Array, normal_w: Array, velocity_w: Array) -> Array:
    """Velocities v_x (forward) and v_y (left) along the axes of the ground plane [m/s].

    Args:
        world_from_body: attitudes, quaternions wxyz (n, 4).
        normal_w: normals n of the ground planes (n, 3).
        velocity_w: velocities v of a point (n, 3) [m/s].

    Returns:
        Shape (2, n).
    """
    out = np.empty((2, len(velocity_w)))
    _ground_velocity(world_from_body, normal_w, velocity_w, out)
    return out


@law
def _ground_velocity(
    world_from_body: Array, normal_w: Array, velocity_w: Array, out: Array
) -> None:
    for i in range(len(velocity_w)):
        out[0, i], out[1, i] = ground_velocity_of(world_from_body, normal_w, velocity_w, i)


@inlined_law
def ground_velocity_of(
    world_from_body: Array, normal_w: Array, velocity_w: Array, i: int
) -> tuple[float, float]:
    """Velocities v_x and v_y of row i; see `ground_velocity`."""
    q = world_from_body[i]
    n, v = rigid.row3(normal_w, i), rigid.row3(velocity_w, i)
    body_x = x_axis(q[0], q[1], q[2], q[3])
    ahead = rigid.minus(body_x, rigid.scaled(rigid.dot(body_x, n), n))
    length = math.sqrt(rigid.dot(ahead, ahead))
    ahead = (ahead[0] / length, ahead[1] / length, ahead[2] / length)
    return rigid.dot(ahead, v), rigid.dot(rigid.cross(n, ahead), v)


def driven_axle(wheels: Wheels, driven: Places) -> DrivenAxle:
    """Means over the driven wheels."""
    spin, radius, hub = wheels
    out = np.empty((3, len(spin)))
    _driven_axle(spin, radius, hub, driven, out)
    return DrivenAxle(out[0], out[1], out[2])


@law
def _driven_axle(
    spin_radps: Array, radius_m: Array, hub_mps: Array, driven: Places, out: Array
) -> None:
    for i in range(len(spin_radps)):
        out[0, i], out[1, i], out[2, i] = driven_axle_of(spin_radps, radius_m, hub_mps, driven, i)


@inlined_law
def driven_axle_of(
    spin_radps: Array, radius_m: Array, hub_mps: Array, driven: Places, i: int
) -> tuple[float, float, float]:
    """The means of row i, in the order of DrivenAxle."""
    count = len(driven)
    rim = hub = spin = 0.0
    for wheel in driven:
        rim += spin_radps[i, wheel] * radius_m[i, wheel]
        hub += hub_mps[i, wheel]
        spin += spin_radps[i, wheel]
    return rim / count, hub / count, spin / count
