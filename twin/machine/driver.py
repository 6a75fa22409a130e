"""The driver: holds the line, lowers the plough after the approach, keeps its depth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

LOOKAHEAD_M = 5.0
"""Distance over which a lateral error is steered out [m]; assumed."""
STEER_GAIN_RAD_PER_MS = 0.02
"""How fast a lateral error that stays is steered out [rad/(m s)], slower than the look ahead."""
MOST_BIAS_RAD = 0.2
"""Largest steering angle held against a lateral force that stays [rad]."""
STEER_RATE_RADPS = 0.4
"""How fast the wheel is turned [rad/s]; assumed."""
LIFT_RATE_RADPS = 0.35
"""How fast the hitch is lowered or raised [rad/s]: about 0.3 m/s at the hitch points."""
DEPTH_GAIN_RAD_PER_MS = 0.4
"""Correction of the hitch per depth error and second [rad/(m s)]; a hitch of about 1 s... 3 s."""
DRAFT_GAIN_RADPS = 0.5
"""Rate of the hitch per relative error of the draft [rad/s]: a band width of 1 Hz; assumed."""
DRAFT_DEAD_BAND = 0.05
"""Relative error of the draft that is let be [-]; a few per cent in practice."""
FLOAT_RAD = -0.4
"""Command below any working position: the lift, which only lifts, carries nothing."""
FULL_DEPTH = 0.95
"""Share of the set depth that counts as full depth."""


@dataclass(frozen=True)
class Observed:
    """What the driver sees."""

    along_m: float
    """Distance along the line, or along the leg of a turn."""
    left_m: float
    """Lateral error, positive left of it."""
    heading_rad: float
    """Heading error, positive turned left."""
    depth_m: float
    draft_n: float = 0.0
    turning: bool = False
    """On a headland, the plough raised."""
    curvature_pm: float = 0.0
    """Of the way ahead, positive to the left [1/m]."""


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
    hitch: str = "depth"
    """Hitch control: depth, position, draft or float."""
    draft_n: float = 0.0
    """Draft that draft control holds."""


@dataclass(frozen=True)
class Hands:
    """The driver's controls and memory."""

    steer_rad: float = 0.0
    bias_rad: float = 0.0
    """Steering angle found so far against slope, furrow and plough."""
    lift_rad: float = 0.0
    trim_rad: float = 0.0
    """Correction of the hitch found so far."""
    full_depth_at_m: float = math.inf
    """Where the plough first reached full depth."""
    working: bool = False
    """In work, not on the headland: the differential may be locked."""


def drive(task: Task, hands: Hands, seen: Observed, dt_s: float) -> Hands:
    """The controls for the next interval."""
    bias = hands.bias_rad
    if not seen.turning:
        bias -= STEER_GAIN_RAD_PER_MS * seen.left_m * dt_s
        bias = max(-MOST_BIAS_RAD, min(MOST_BIAS_RAD, bias))
    known = bias + math.atan(task.wheelbase_m * seen.curvature_pm)
    angle = steer(task.wheelbase_m, hands.steer_rad, seen.left_m, seen.heading_rad, dt_s, known)
    trim, full = hands.trim_rad, hands.full_depth_at_m
    target, working = task.raised_rad, task.depth_m is None
    if task.depth_m is not None and seen.along_m >= task.approach_m and not seen.turning:
        lowered = hands.lift_rad <= task.work_rad + trim
        if not math.isfinite(full) and seen.depth_m >= FULL_DEPTH * task.depth_m:
            full = seen.along_m
        if lowered or math.isfinite(full):
            trim = max(-0.15, min(0.15, trim + _trim_radps(task, seen) * dt_s))
        working = True
        target = FLOAT_RAD if task.hitch == "float" else task.work_rad + trim
    lift = towards(hands.lift_rad, target, LIFT_RATE_RADPS * dt_s)
    return Hands(float(angle), float(bias), float(lift), trim, full, working)


def steer(
    wheelbase_m: float,
    now_rad: Any,
    left_m: Any,
    heading_rad: Any,
    dt_s: float,
    known_rad: Any = 0.0,
) -> Any:
    """The steering angle of a bicycle for the next interval; numbers, or arrays of one shape.

    Towards a point ahead, linearised (pure pursuit), beside the angle known to be needed:
        delta = known - (2 L / d**2) y - (2 L / d) psi
    """
    wanted = (
        known_rad
        - (2.0 * wheelbase_m / LOOKAHEAD_M**2) * left_m
        - (2.0 * wheelbase_m / LOOKAHEAD_M) * heading_rad
    )
    within = np.maximum(-0.6, np.minimum(0.6, wanted))
    return towards(now_rad, within, STEER_RATE_RADPS * dt_s)


def _trim_radps(task: Task, seen: Observed) -> float:
    """Rate at which the hitch is corrected: none inside the dead band, no faster than the valve."""
    if task.hitch == "depth" and task.depth_m is not None:
        rate = -DEPTH_GAIN_RAD_PER_MS * (task.depth_m - seen.depth_m)
    elif task.hitch == "draft":
        error = (seen.draft_n - task.draft_n) / max(task.draft_n, 1.0)
        rate = DRAFT_GAIN_RADPS * error if abs(error) > DRAFT_DEAD_BAND else 0.0
    else:
        rate = 0.0
    return max(-LIFT_RATE_RADPS, min(LIFT_RATE_RADPS, rate))


def ackermann(steer_rad: Any, wheelbase_m: float, track_m: float) -> tuple[Any, Any]:
    """Angles of the left and right front wheel for a bicycle's steering angle; numbers or arrays.

    tan(left) = L tan(delta) / (L - t/2 tan(delta)) ; right with the other sign of t
    """
    tangent = np.tan(steer_rad)
    half = 0.5 * track_m * tangent
    rise = wheelbase_m * tangent
    return np.arctan2(rise, wheelbase_m - half), np.arctan2(rise, wheelbase_m + half)


def towards(now: Any, wanted: Any, step: float) -> Any:
    """From `now` towards `wanted`, by `step` at most; numbers, or arrays of one shape."""
    return now + np.maximum(-step, np.minimum(step, wanted - now))
