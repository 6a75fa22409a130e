"""The way over the field: passes up and down it, and the turns on the headlands between them.

A turn is a bulb: out of the line, back across both, into the next line,

    alpha right, pi + 2 alpha left, alpha right       cos(alpha) = (1 + w / 2 R) / 2

mirrored for a next line on the right; it ends where it began along the field, a width w aside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from twin.scenario.plough import FURROW_SIDES
from twin.scenario.scenario import Scenario

RADIUS_M = 6.5
"""Radius of a turn [m]: a steering angle of 21 degrees; assumed."""
CLEAR_M = 8.0
"""Straight way on which the plough is raised and clears the furrow [m]."""
BARE_SWATH_M = 3.0
"""Distance of the lines without an implement [m]; assumed."""
LOWERING_M = 30.0
"""Distance in which the plough must reach its depth; the length counts from there at most."""
MARGIN_M = 12.0
"""Ground beside a course that is worth a map [m]."""
LEAST_WIDTH_M, MOST_WIDTH_M = 50.0, 100.0
"""Width of a map [m]: its longest waves must find room across it too; wider ground repeats it."""
LONGEST_MAP_M = 400.0
"""Length of a map, which then repeats [m]."""


@dataclass(frozen=True)
class Leg:
    """A straight or an arc on the ground."""

    s_m: float
    """Where it begins."""
    t_m: float
    heading_rad: float
    """Its direction there, from the ground's s towards t."""
    length_m: float = math.inf
    curvature_pm: float = 0.0
    """Positive to the left [1/m]."""
    back: bool = False
    """Driven backwards; direction, curvature and errors are those of who looks along the way."""


def on_leg(leg: Leg, s_m: float, t_m: float, heading_rad: float) -> tuple[float, float, float]:
    """Distance along a leg, lateral error (left positive) and heading error of a place.

    On an arc of radius R about c, with r = |p - c| and phi the angle from its start:
        along = R phi       left = +-(R - r)      heading error = psi - psi_0 - along curvature
    """
    cosine, sine = math.cos(leg.heading_rad), math.sin(leg.heading_rad)
    ahead = cosine * (s_m - leg.s_m) + sine * (t_m - leg.t_m)
    left = cosine * (t_m - leg.t_m) - sine * (s_m - leg.s_m)
    turned = heading_rad - leg.heading_rad + (math.pi if leg.back else 0.0)
    if leg.curvature_pm != 0.0:
        radius, way = 1.0 / abs(leg.curvature_pm), math.copysign(1.0, leg.curvature_pm)
        inward = radius - way * left
        angle = math.atan2(ahead, inward)
        ahead, left = radius * angle, way * (radius - math.hypot(ahead, inward))
        turned -= way * angle
    return ahead, left, math.atan2(math.sin(turned), math.cos(turned))


def end_of(leg: Leg) -> Leg:
    """A straight without end that goes on where a leg ends."""
    heading, angle = leg.heading_rad, leg.curvature_pm * leg.length_m
    ahead, left = leg.length_m, 0.0
    if leg.curvature_pm != 0.0:
        ahead = math.sin(angle) / leg.curvature_pm
        left = (1.0 - math.cos(angle)) / leg.curvature_pm
    return Leg(
        leg.s_m + math.cos(heading) * ahead - math.sin(heading) * left,
        leg.t_m + math.sin(heading) * ahead + math.cos(heading) * left,
        heading + angle,
    )


def turn(start: Leg, width_m: float, side: int) -> list[Leg]:
    """Legs from the end of a pass to the next line.

    Args:
        start: where the turn begins; its length is not looked at.
        width_m: distance of the next line, less than 2 RADIUS_M.
        side: +1 for a next line on the left, -1 on the right.
    """
    alpha = math.acos(0.5 * (1.0 + 0.5 * width_m / RADIUS_M))
    half = 0.5 * (math.pi + 2.0 * alpha)  # the long arc in two, each less than a half turn
    out = [Leg(start.s_m, start.t_m, start.heading_rad, CLEAR_M)]
    for way, angle in ((-side, alpha), (side, half), (side, half), (-side, alpha)):
        begin = end_of(out[-1])
        arc = Leg(begin.s_m, begin.t_m, begin.heading_rad, RADIUS_M * angle, way / RADIUS_M)
        out.append(arc)
    return out


def backed_turn(start: Leg, width_m: float, side: int, backings: int = 1) -> list[Leg]:
    """Legs from the end of a pass to the next line, backing up between the parts of a half turn.

    n ways backwards stand between n + 1 arcs of radius R and angle alpha. The turn ends where it
    began along the field, a width w aside:

        alpha = pi / (n + 1)        straight back (2 R - w) tan(alpha / 2) each

    Args:
        start: where the turn begins; its length is not looked at.
        width_m: distance of the next line, less than 2 RADIUS_M.
        side: +1 for a next line on the left, -1 on the right.
        backings: n.
    """
    angle, bend = math.pi / (backings + 1), side / RADIUS_M
    back_m = (2.0 * RADIUS_M - width_m) * math.tan(0.5 * angle)
    out = [Leg(start.s_m, start.t_m, start.heading_rad, CLEAR_M)]
    for part in range(backings + 1):
        heading = start.heading_rad + side * part * angle
        begin = end_of(out[-1])
        if part:
            out.append(Leg(begin.s_m, begin.t_m, heading + math.pi, back_m, back=True))
            begin = end_of(out[-1])
        out.append(Leg(begin.s_m, begin.t_m, heading, RADIUS_M * angle, bend))
    return out


def land_side(scenario: Scenario) -> int:
    """Side on which the next line lies: that of the land; +1 left of the first pass."""
    plough = scenario.plough
    return 1 if plough is None else (-FURROW_SIDES[plough.furrow] or 1)


def width_m(scenario: Scenario, numbers: dict[str, float]) -> float:
    """Distance of the lines: what the plough turns in a pass."""
    if scenario.plough is None:
        return BARE_SWATH_M
    return numbers["plough.bodies"] * numbers["plough.body_width_m"]


def length_m(scenario: Scenario) -> float:
    """Least length of the way, lines and turns."""
    course = scenario.course
    alpha = math.acos(0.5)
    between = CLEAR_M + RADIUS_M * (math.pi + 4.0 * alpha)
    road_m = 2.0 * course.road_m + (course.approach_m if course.road_m else 0.0)
    field_m = course.passes * (course.approach_m + course.length_m) + (course.passes - 1) * between
    return field_m + road_m


def extent_m(scenario: Scenario) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ground that a map should cover: from, to along the course; from, to across it [m]."""
    course = scenario.course
    headland = 0.0 if course.passes == 1 else CLEAR_M + 3.0 * RADIUS_M
    end = course.approach_m + LOWERING_M + course.length_m + headland + MARGIN_M
    start = -headland - MARGIN_M
    wanted = MARGIN_M + BARE_SWATH_M * course.passes
    half = 0.5 * max(LEAST_WIDTH_M, min(2.0 * wanted, MOST_WIDTH_M))
    return (start, min(end, start + LONGEST_MAP_M)), (-half, half)
