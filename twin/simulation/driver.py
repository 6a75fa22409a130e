"""The driver: holds the line, lowers the plough after the approach, keeps its depth."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from twin.compute.compiled import law
from twin.machine.hitch import FLOAT_RAD
from twin.scenario.plough import DRAFT_MODES
from twin.simulation.controls import lagged, towards, within

LOOKAHEAD_M = 5.0
"""Distance over which a lateral error is steered out at a slow pace [m]; assumed."""
LOOKAHEAD_S = 1.5
"""Time ahead that a driver looks at a fast pace [s], more than LOOKAHEAD_M above 12 km/h; assumed.
A fixed distance makes the machine swing about its line at 20 km/h."""
STEER_GAIN_RAD_PER_MS = 0.02
"""Integral gain at a slow pace on a lateral error that stays [rad/(m s)]; slower than the rest."""
MOST_BIAS_RAD = 0.2
"""Largest steering angle held against a lateral force that stays [rad]."""
MOST_STEER_RAD = 0.6
"""Largest steering angle [rad]."""
STEER_RATE_RADPS = 0.4
"""How fast the wheel is turned [rad/s]; assumed."""
LIFT_RATE_RADPS = 0.35
"""How fast the hitch is raised [rad/s]: about 0.3 m/s at the hitch points."""
DEPTH_GAIN_RAD_PER_MS = 0.4
"""Correction of the hitch per depth error and second [rad/(m s)]; a hitch of about 1 s... 3 s."""
MOST_TRIM_RAD = 0.15
"""Largest correction of the hitch [rad]."""
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


class HitchControl(IntEnum):
    """What the lift follows."""

    RAISED = 0
    """Nothing: it stays up."""
    SET = 1
    """The angle it is given, from the start on."""
    DEPTH = 2
    """The plough's depth."""
    VALVE = 3
    """Position, draft or their mix."""
    FLOAT = 4
    """Nothing: it carries nothing."""


class Observation(NamedTuple):
    """What the driver sees."""

    along_m: float = 0.0
    """Distance along the line, or along the leg of a turn."""
    left_m: float = 0.0
    """Lateral error, positive left of it."""
    heading_rad: float = 0.0
    """Heading error, positive turned left."""
    depth_m: float = 0.0
    draft_n: float = 0.0
    hitch_rad: float = 0.0
    """Angle of the lower links."""
    speed_mps: float = 0.0
    """Speed of the rear-axle centre, without a sign."""
    turning: bool = False
    """On a headland, the plough raised."""
    curvature_pm: float = 0.0
    """Of the way ahead, positive to the left [1/m]."""
    backing: bool = False
    """The way is driven backwards; then the three errors and the curvature are those of who looks
    along it."""


class DriverTask(NamedTuple):
    """What the driver is to do."""

    wheelbase_m: float
    track_m: float
    """Distance of the front wheels' steering axes."""
    approach_m: float
    raised_rad: float
    """Upper limit of the lift."""
    work_rad: float
    """Angle of the lower links that the lever asks for in work."""
    throttle: float
    hitch: int = HitchControl.RAISED
    """A HitchControl."""
    depth_m: float = 0.0
    """Working depth."""
    full_depth_m: float = 0.0
    """Depth from which the plough counts as at work."""
    mix: float = 0.0
    """What the valve follows: 0 the lever's position, 1 the draft."""
    draft_n: float = 0.0
    """Draft that is held."""
    sensitivity_rad: float = 0.0
    """Error of the angle that a draft of twice what is held counts as."""
    lowest_rad: float = FLOAT_RAD
    """Lower limit of the lift."""
    drop_rate_radps: float = LIFT_RATE_RADPS
    """How fast it lowers at most."""
    hold_line: bool = True
    """False leaves the wheels straight."""
    steer_gain_rad_per_ms: float = STEER_GAIN_RAD_PER_MS
    """Integral gain on a lateral error; 0 for none."""
    differential_lock: bool = False
    """Locked in work."""
    front_drive: bool = False
    clutch_pedal: float = 0.0
    brakes: bool = True
    """False leaves the brake pedal alone."""
    brake_pedal: float = 0.0
    """At least so far down."""
    lifted: bool = False
    """Keeps the implement up where it would be at work."""


class DriverState(NamedTuple):
    """The driver's controls and memory."""

    steer_rad: float = 0.0
    bias_rad: float = 0.0
    """Integral term: steering angle found so far against slope, furrow and plough."""
    lift_rad: float = 0.0
    trim_rad: float = 0.0
    """Integral term: correction of the hitch found so far."""
    felt_n: float = 0.0
    """Draft as the pins feel it, low-pass filtered."""
    full_depth_at_m: float = math.inf
    """Where the plough first reached full depth."""
    working: bool = False
    """In work, not on the headland: the differential may be locked."""


def full_depth_m(depth_m: float, hitch: str) -> float:
    """Depth from which a plough that is set to a depth counts as at work."""
    return (AT_WORK if hitch in DRAFT_MODES else FULL_DEPTH) * depth_m


@law
def drive(task: DriverTask, last: DriverState, seen: Observation, dt_s: float) -> DriverState:
    """The controls for the next interval."""
    bias = last.bias_rad
    if not (seen.turning or seen.backing):
        gain = task.steer_gain_rad_per_ms * (LOOKAHEAD_M / lookahead_m(seen.speed_mps)) ** 2
        change = gain * seen.left_m * dt_s
        bias = within(-MOST_BIAS_RAD, bias - change, MOST_BIAS_RAD)
    steer_rad = 0.0
    if task.hold_line:
        steer_rad = steer(task, last.steer_rad, seen, bias, dt_s)
    felt = lagged(last.felt_n, seen.draft_n, DRAFT_FILTER_S, dt_s)
    lift, trim, full = last.lift_rad, last.trim_rad, last.full_depth_at_m
    working = True
    if task.hitch == HitchControl.SET:
        lift = lifted(task, lift, task.work_rad, dt_s)
    elif (
        task.hitch == HitchControl.RAISED
        or seen.along_m < task.approach_m
        or seen.turning
        or task.lifted
    ):
        full = math.inf if task.lifted else full
        lift = lifted(task, lift, task.raised_rad, dt_s)
        working = task.hitch == HitchControl.RAISED
    else:
        if not math.isfinite(full) and seen.depth_m >= task.full_depth_m:
            full = seen.along_m
        lift, trim = work(task, lift, trim, felt, math.isfinite(full), seen, dt_s)
    return DriverState(steer_rad, bias, lift, trim, felt, full, working)


@law
def work(
    task: DriverTask,
    lift_rad: float,
    trim_rad: float,
    felt_n: float,
    at_depth: bool,
    seen: Observation,
    dt_s: float,
) -> tuple[float, float]:
    """Lift and trim while the plough is lowered, then by the hitch's mode."""
    if task.hitch == HitchControl.DEPTH:
        if at_depth or lift_rad <= task.work_rad + trim_rad:
            rate = DEPTH_GAIN_RAD_PER_MS * (seen.depth_m - task.depth_m)
            rate = within(-LIFT_RATE_RADPS, rate, LIFT_RATE_RADPS)
            trim_rad = within(-MOST_TRIM_RAD, trim_rad + rate * dt_s, MOST_TRIM_RAD)
        return lifted(task, lift_rad, task.work_rad + trim_rad, dt_s), trim_rad
    if task.hitch == HitchControl.FLOAT:
        return lifted(task, lift_rad, FLOAT_RAD, dt_s), trim_rad
    mix = task.mix if at_depth else 0.0  # lowered to the lever's angle before there is a draft
    moved = lift_rad + valve_radps(task, mix, seen.hitch_rad, felt_n) * dt_s
    return max(moved, seen.hitch_rad - SLACK_RAD), trim_rad


@law
def valve_radps(task: DriverTask, mix: float, hitch_rad: float, felt_n: float) -> float:
    """Rate of an electronic hitch's lift under position control, draft control or a mix of both.

        rate = g [(1 - m) (lever - angle) + m S (D - D_0) / D_0]

    The bracket is limited to [lowest - angle, highest - angle], so that the lift stops at its
    limits. The rate is 0 within the dead band, and limited to the lift rate and the drop rate.

    Args:
        task: g is VALVE_GAIN_PER_S, lever is `work_rad`, S the sensitivity, D_0 the draft held.
        mix: m, 0 for position and 1 for draft.
        hitch_rad: angle of the lower links.
        felt_n: D.
    """
    position = task.work_rad - hitch_rad
    draft = task.sensitivity_rad * (felt_n - task.draft_n) / max(task.draft_n, 1.0)
    error = (1.0 - mix) * position + mix * draft
    if abs(error) < VALVE_DEAD_BAND_RAD:
        error = 0.0
    error = within(task.lowest_rad - hitch_rad, error, task.raised_rad - hitch_rad)
    return within(-task.drop_rate_radps, VALVE_GAIN_PER_S * error, LIFT_RATE_RADPS)


@law
def lifted(task: DriverTask, now_rad: float, wanted_rad: float, dt_s: float) -> float:
    """The lift on its way to an angle, no faster than it rises or drops."""
    low, high = -task.drop_rate_radps * dt_s, LIFT_RATE_RADPS * dt_s
    return now_rad + within(low, wanted_rad - now_rad, high)


@law
def lookahead_m(speed_mps: float) -> float:
    """How far ahead the driver looks: d = max(d_0, T v)."""
    return max(LOOKAHEAD_M, LOOKAHEAD_S * speed_mps)


@law
def steer(
    task: DriverTask, now_rad: float, seen: Observation, bias_rad: float, dt_s: float
) -> float:
    """The steering angle of a bicycle for the next interval.

    Towards a point d ahead, linearised (pure pursuit), beside the angle known to be needed:
        delta = bias + atan(L curvature) - (2 L / d**2) y - (2 L / d) psi
    """
    ahead_m = lookahead_m(seen.speed_mps)
    wanted = (
        bias_rad
        + math.atan(task.wheelbase_m * seen.curvature_pm)
        - (2.0 * task.wheelbase_m / ahead_m**2) * seen.left_m
        - (2.0 * task.wheelbase_m / ahead_m) * seen.heading_rad
    )
    if seen.backing:  # seen along the way, the machine drives its rear axle first
        wanted = bias_rad - (wanted - bias_rad)
    wanted = within(-MOST_STEER_RAD, wanted, MOST_STEER_RAD)
    return towards(now_rad, wanted, STEER_RATE_RADPS * dt_s)


@law
def ackermann(steer_rad: float, wheelbase_m: float, track_m: float) -> tuple[float, float]:
    """Angles of the left and right front wheel for a bicycle's steering angle.

    tan(left) = L tan(delta) / (L - t/2 tan(delta)) ; right with the other sign of t
    """
    tangent = math.tan(steer_rad)
    half = 0.5 * track_m * tangent
    rise = wheelbase_m * tangent
    return math.atan2(rise, wheelbase_m - half), math.atan2(rise, wheelbase_m + half)
