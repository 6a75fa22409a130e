"""The driver: holds the line, lowers the plough after the approach, keeps its depth."""

from __future__ import annotations

import math
from dataclasses import dataclass

LOOKAHEAD_M = 5.0
"""Distance over which a lateral error is steered out [m]; assumed."""
STEER_RATE_RADPS = 0.4
"""How fast the wheel is turned [rad/s]; assumed."""
LIFT_RATE_RADPS = 0.35
"""How fast the hitch is lowered or raised [rad/s]: about 0.3 m/s at the hitch points."""
DEPTH_GAIN_RAD_PER_MS = 0.4
"""Correction of the hitch per depth error and second [rad/(m s)]; a hitch of about 1 s... 3 s."""
FULL_DEPTH = 0.95
"""Share of the set depth that counts as full depth."""


@dataclass(frozen=True)
class Observed:
    """What the driver sees."""

    along_m: float
    """Distance along the course."""
    left_m: float
    """Lateral error, positive left of the line."""
    heading_rad: float
    """Heading error, positive turned left."""
    depth_m: float


@dataclass(frozen=True)
class Task:
    """What the driver is to do."""

    wheelbase_m: float
    approach_m: float
    depth_m: float | None
    """Working depth, None without a plough."""
    raised_rad: float
    work_rad: float
    throttle: float


@dataclass(frozen=True)
class Hands:
    """The driver's controls and memory."""

    steer_rad: float = 0.0
    lift_rad: float = 0.0
    trim_rad: float = 0.0
    """Correction of the hitch found so far."""
    full_depth_at_m: float = math.inf
    """Where the plough first reached full depth."""


def drive(task: Task, hands: Hands, seen: Observed, dt_s: float) -> Hands:
    """The controls for the next interval.

    Steering towards a point ahead, linearised (pure pursuit):
        delta = -(2 L / d**2) y - (2 L / d) psi
    """
    wanted = (
        -(2.0 * task.wheelbase_m / LOOKAHEAD_M**2) * seen.left_m
        - (2.0 * task.wheelbase_m / LOOKAHEAD_M) * seen.heading_rad
    )
    steer = _towards(hands.steer_rad, max(-0.6, min(0.6, wanted)), STEER_RATE_RADPS * dt_s)
    trim, full = hands.trim_rad, hands.full_depth_at_m
    target = task.raised_rad
    if task.depth_m is not None and seen.along_m >= task.approach_m:
        if math.isfinite(full):
            error_m = task.depth_m - seen.depth_m
            trim = max(-0.15, min(0.15, trim - DEPTH_GAIN_RAD_PER_MS * error_m * dt_s))
        elif seen.depth_m >= FULL_DEPTH * task.depth_m:
            full = seen.along_m
        target = task.work_rad + trim
    lift = _towards(hands.lift_rad, target, LIFT_RATE_RADPS * dt_s)
    return Hands(steer, lift, trim, full)


def ackermann(steer_rad: float, wheelbase_m: float, track_m: float) -> tuple[float, float]:
    """Angles of the left and right front wheel for a bicycle's steering angle.

    tan(left) = L tan(delta) / (L - t/2 tan(delta)) ; right with the other sign of t
    """
    tangent = math.tan(steer_rad)
    half = 0.5 * track_m * tangent
    rise = wheelbase_m * tangent
    return math.atan2(rise, wheelbase_m - half), math.atan2(rise, wheelbase_m + half)


def _towards(now: float, wanted: float, step: float) -> float:
    return now + max(-step, min(step, wanted - now))
