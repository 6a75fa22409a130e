"""The driver: holds the line, lowers the plough after the approach, keeps its depth."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from twin.machine.hitch import FLOAT_RAD
from twin.scenario.plough import DRAFT_MODES

LOOKAHEAD_M = 5.0
"""Distance over which a lateral error is steered out [m]; assumed."""
STEER_GAIN_RAD_PER_MS = 0.02
"""How fast a lateral error that stays is steered out [rad/(m s)], slower than the look ahead."""
MOST_BIAS_RAD = 0.2
"""Largest steering angle held against a lateral force that stays [rad]."""
STEER_RATE_RADPS = 0.4
"""How fast the wheel is turned [rad/s]; assumed."""
LIFT_RATE_RADPS = 0.35
"""How fast the hitch is raised [rad/s]: about 0.3 m/s at the hitch points."""
DEPTH_GAIN_RAD_PER_MS = 0.4
"""Correction of the hitch per depth error and second [rad/(m s)]; a hitch of about 1 s... 3 s."""
VALVE_GAIN_PER_S = 4.0
"""Rate of the lift per error of its angle [1/s]: a position is found in half a second; assumed."""
VALVE_DEAD_BAND_RAD = 0.0005
"""Error that leaves the valve shut [rad]: 0.5 mm at the hitch points; assumed."""
DRAFT_FILTER_S = 0.1
"""Time constant of the draft as the pins feel it [s]: shear failure's 3 to 9 Hz moves no valve;
assumed."""
SLACK_RAD = 0.05
"""How far the lift is lowered below links that something else carries [rad]; assumed."""
FULL_DEPTH = 0.95
"""Share of the set depth that counts as full depth."""
AT_WORK = 0.5
"""The same where the depth follows the draft."""


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
    hitch_rad: float = 0.0
    """Angle of the lower links."""
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
    """Upper limit of the lift."""
    work_rad: float
    """Angle of the lower links that the lever asks for in work."""
    throttle: float
    hitch: str = "depth"
    """Hitch control: depth, position, draft, mix or float."""
    mix: float = 0.0
    """What the lift follows: 0 the lever's position, 1 the draft."""
    draft_n: float = 0.0
    """Draft that is held."""
    sensitivity_rad: float = 0.0
    """Error of the angle that a draft of twice what is held counts as."""
    lowest_rad: float = FLOAT_RAD
    """Lower limit of the lift."""
    drop_rate_radps: float = LIFT_RATE_RADPS
    """How fast it lowers at most."""


@dataclass(frozen=True)
class Hands:
    """The driver's controls and memory."""

    steer_rad: float = 0.0
    bias_rad: float = 0.0
    """Steering angle found so far against slope, furrow and plough."""
    lift_rad: float = 0.0
    trim_rad: float = 0.0
    """Correction of the hitch found so far."""
    felt_n: float = 0.0
    """Draft as the pins feel it."""
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
    felt = hands.felt_n + (seen.draft_n - hands.felt_n) * dt_s / DRAFT_FILTER_S
    now = replace(hands, steer_rad=float(angle), bias_rad=float(bias), felt_n=float(felt))
    if task.depth_m is None or seen.along_m < task.approach_m or seen.turning:
        raised = _lifted(task, hands.lift_rad, task.raised_rad, dt_s)
        return replace(now, lift_rad=raised, working=task.depth_m is None)
    return _work(task, now, seen, task.depth_m, dt_s)


def _work(task: Task, hands: Hands, seen: Observed, depth_m: float, dt_s: float) -> Hands:
    """Lower the plough and hold it as the hitch is told to."""
    trim, full = hands.trim_rad, hands.full_depth_at_m
    if not math.isfinite(full) and seen.depth_m >= full_depth_m(depth_m, task.hitch):
        full = seen.along_m
    if task.hitch == "depth":
        if hands.lift_rad <= task.work_rad + trim or math.isfinite(full):
            rate = DEPTH_GAIN_RAD_PER_MS * (seen.depth_m - depth_m)
            rate = max(-LIFT_RATE_RADPS, min(LIFT_RATE_RADPS, rate))
            trim = max(-0.15, min(0.15, trim + rate * dt_s))
        lift = _lifted(task, hands.lift_rad, task.work_rad + trim, dt_s)
    elif task.hitch == "float":
        lift = _lifted(task, hands.lift_rad, FLOAT_RAD, dt_s)
    else:  # lowered to the lever's angle before there is a draft to hold
        held = task if math.isfinite(full) else replace(task, mix=0.0)
        lift = hands.lift_rad + valve_radps(held, seen.hitch_rad, hands.felt_n) * dt_s
        lift = max(lift, seen.hitch_rad - SLACK_RAD)
    return replace(hands, lift_rad=float(lift), trim_rad=trim, full_depth_at_m=full, working=True)


def full_depth_m(depth_m: float, hitch: str) -> float:
    """Depth from which a plough that is set to a depth counts as at work."""
    return (AT_WORK if hitch in DRAFT_MODES else FULL_DEPTH) * depth_m


def valve_radps(task: Task, hitch_rad: float, felt_n: float) -> float:
    """Rate of the lift in position and draft control and their mix, as an electronic hitch has it.

        rate = g [(1 - m) (lever - angle) + m S (D - D_0) / D_0]

    Between the limits of the lift, where it is a control of position; no rate within the dead band,
    and none above the lift's rate or the drop rate.

    Args:
        task: g is VALVE_GAIN_PER_S, m the mix, S the sensitivity, D_0 the draft that is held.
        hitch_rad: angle of the lower links.
        felt_n: D.
    """
    position = task.work_rad - hitch_rad
    draft = task.sensitivity_rad * (felt_n - task.draft_n) / max(task.draft_n, 1.0)
    error = (1.0 - task.mix) * position + task.mix * draft
    if abs(error) < VALVE_DEAD_BAND_RAD:
        error = 0.0
    error = max(task.lowest_rad - hitch_rad, min(task.raised_rad - hitch_rad, error))
    return max(-task.drop_rate_radps, min(LIFT_RATE_RADPS, VALVE_GAIN_PER_S * error))


def _lifted(task: Task, now_rad: float, wanted_rad: float, dt_s: float) -> float:
    """The lift on its way to an angle, no faster than it rises or drops."""
    step = max(-task.drop_rate_radps * dt_s, min(LIFT_RATE_RADPS * dt_s, wanted_rad - now_rad))
    return now_rad + step


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
