"""Which way is up in the ground plane, and whether the ground is level: from the accelerometer."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from estimators.layout import GRAVITY_MPS2
from estimators.sideslip_ekf import plane
from estimators.sideslip_ekf.plane import Array

MEAN_S = 4.0
"""Time over which the vertical is averaged [s]."""
BIAS_S = 60.0
"""Time over which level driving tells the accelerometer's bias and the unit's mounting [s]."""
LEVEL = math.sin(math.radians(2.5))
"""A tilt less than this, the bias's own included, is level ground."""


@dataclass(frozen=True)
class Tilt:
    """The mean vertical; components of a unit vector."""

    plane_up: tuple[float, float] = (0.0, 0.0)
    """Along the plane's own axes, less the bias."""
    body_up: tuple[float, float] = (0.0, 0.0)
    """Ahead and to the left, as felt."""
    seen_s: float = 0.0
    bias: tuple[float, float] = (0.0, 0.0)
    """What is felt on level ground."""
    bias_s: float = 0.0

    @property
    def level(self) -> bool:
        """Whether the ground is level; unknown is not."""
        return self.seen_s > 0.0 and math.hypot(*self.body_up) < LEVEL

    @property
    def rotation(self) -> Array:
        """`plane.world_from_plane` of the ground."""
        return plane.world_from_plane(plane.tilted(np.array(self.plane_up)))


def forget(tilt: Tilt) -> Tilt:
    """Other ground; the bias stays."""
    return Tilt(bias=tilt.bias, bias_s=tilt.bias_s)


def felt(tilt: Tilt, ahead: float, left: float, heading_rad: float, dt: float) -> Tilt:
    """Add a sample: specific force ahead and to the left without what turning adds [m/s2]."""
    if not (math.isfinite(ahead) and math.isfinite(left)):
        return tilt
    u_x, u_y = ahead / GRAVITY_MPS2, left / GRAVITY_MPS2
    gain = _gain(tilt.seen_s, dt, MEAN_S)
    body = _towards(tilt.body_up, (u_x, u_y), gain)
    bias, bias_s = tilt.bias, tilt.bias_s
    if math.hypot(*body) < LEVEL:
        bias = _towards(bias, (u_x, u_y), _gain(bias_s, dt, BIAS_S))
        bias_s += dt
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    a, b = u_x - bias[0], u_y - bias[1]
    flat = _towards(tilt.plane_up, (cos * a - sin * b, sin * a + cos * b), gain)
    return replace(
        tilt,
        plane_up=flat,
        body_up=body,
        seen_s=tilt.seen_s + dt,
        bias=bias,
        bias_s=bias_s,
    )


def _gain(seen_s: float, dt: float, mean_s: float) -> float:
    """A plain mean at first, then one that forgets."""
    return dt / min(seen_s + dt, mean_s)


def _towards(
    old: tuple[float, float], new: tuple[float, float], gain: float
) -> tuple[float, float]:
    return old[0] + gain * (new[0] - old[0]), old[1] + gain * (new[1] - old[1])
