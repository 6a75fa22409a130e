"""The three-point hitch in its own plane: where lower links and top link put the plough."""

from __future__ import annotations

import math
from dataclasses import dataclass

FLOAT_RAD = -0.4
"""Lower-link angle [rad] commanded for floating: so low that the lift carries nothing."""


@dataclass(frozen=True, kw_only=True)
class Hitch:
    """Points of the three-point linkage in the vertical x-z plane, as (x, z).

    Tractor points are measured from the rear axle's centre. Angles of the lower links are 0 where
    the links are level and positive where their rear ends are higher.
    """

    lower_front: tuple[float, float]
    """Front pivot of the lower links [m]."""
    lower_length_m: float
    top_front: tuple[float, float]
    """Front pivot of the top link [m]."""
    mast: tuple[float, float]
    """Top-link pin on the plough, from its lower hitch points [m]."""

    def hitch_point(self, lift_rad: float) -> tuple[float, float]:
        """Rear end (x, z) of the lower links from the rear axle [m], at a link angle."""
        return (
            self.lower_front[0] - self.lower_length_m * math.cos(lift_rad),
            self.lower_front[1] + self.lower_length_m * math.sin(lift_rad),
        )

    def plough_point(
        self, lift_rad: float, top_length_m: float, point: tuple[float, float]
    ) -> tuple[float, float]:
        """A point of the plough from the rear axle [m]; `point` is given from its hitch points."""
        angle = lift_rad + self.pitch_rad_at(lift_rad, top_length_m)
        x, z = self.hitch_point(lift_rad)
        return (
            x + point[0] * math.cos(angle) + point[1] * math.sin(angle),
            z - point[0] * math.sin(angle) + point[1] * math.cos(angle),
        )

    def top_length_m(self, lift_rad: float, pitch_rad: float) -> float:
        """Length of the top link; `pitch_rad` is the plough's pitch less the angle of the links."""
        angle = lift_rad + pitch_rad
        x, z = self.hitch_point(lift_rad)
        x += self.mast[0] * math.cos(angle) + self.mast[1] * math.sin(angle)
        z += -self.mast[0] * math.sin(angle) + self.mast[1] * math.cos(angle)
        return math.hypot(x - self.top_front[0], z - self.top_front[1])

    def lift_rad_at(self, hitch_height_m: float, axle_height_m: float) -> float:
        """Lower-link angle at which the links' rear ends are `hitch_height_m` above the ground.

        `axle_height_m` is the height of the rear axle's centre above the ground. A height out of
        reach gives -pi/2 or pi/2.
        """
        rise = hitch_height_m - axle_height_m - self.lower_front[1]
        return math.asin(max(-1.0, min(1.0, rise / self.lower_length_m)))

    def pitch_rad_at(self, lift_rad: float, top_length_m: float) -> float:
        """The `pitch_rad` of `top_length_m` at which the top link has this length (bisection)."""
        low, high = -lift_rad - 0.7, -lift_rad + 0.7
        for _ in range(60):
            middle = 0.5 * (low + high)
            if self.top_length_m(lift_rad, middle) > top_length_m:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
