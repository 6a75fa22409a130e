"""Which events a scenario's machine, implement and course allow."""

from __future__ import annotations

from typing import TYPE_CHECKING

from twin.errors import BadInput, OutOfRange, TwinError, check_range
from twin.scenario.events import Event, check_order

if TYPE_CHECKING:
    from twin.scenario.scenario import Scenario

LEAST_DEPTHS = ("lift", "lower", "depth")


def refuse_impossible(scenario: Scenario) -> None:
    """Refuse what the machine cannot do, and where the course does not lead.

    Raises:
        BadInput, OutOfRange: names the event by its place, what it asks for, and what would do.
    """
    course = scenario.course
    if course.road_m > 0.0 and course.passes % 2:
        raise BadInput(
            f"course.road_m = {course.road_m:g} leads back, but after course.passes = "
            f"{course.passes} the machine stands at the other end; an even number would do"
        )
    check_order(scenario.events)
    for i, event in enumerate(scenario.events):
        try:
            _check(scenario, event)
        except TwinError as error:
            raise BadInput(f"events.{i}: {event.do} {event.time}: {error}") from None


def _check(scenario: Scenario, event: Event) -> None:
    facts, box, course = scenario.facts, scenario.gearbox, scenario.course
    if event.at_m is not None:
        if (event.in_pass or 1) > course.passes:
            raise OutOfRange("in_pass", event.in_pass, f"[1, {course.passes}], course.passes")
        least_m = course.approach_m + course.length_m
        if event.at_m > least_m:
            raise OutOfRange("at_m", f"{event.at_m:g}", f"[0, {least_m:g}], the length of a pass")
    if event.engine_rpm is not None:
        idle, top = (facts.numbers[f"engine.{n}_rpm"] for n in ("idle", "no_load"))
        check_range("engine_rpm", event.engine_rpm, idle, top)
    if event.do == "shift":
        if box.kind == "electric" and len(box.ratios) == 1:
            raise BadInput(f"{facts.name} has one gear; throttle with engine_rpm would do")
        if event.gear is not None:
            box.of_gear(event.gear, facts.name)
        if event.by is not None and box.stepless:
            raise BadInput(f"by = {event.by}: {facts.name} has no gears; kmh would do")
    if event.do == "clutch" and box.kind == "electric":
        raise BadInput(f"{facts.name} has a motor without a clutch pedal; throttle would do")
    if event.engine_off and not facts.diesel:
        raise BadInput(f"engine_off = true needs a diesel, which {facts.name} has not")
    if event.do in LEAST_DEPTHS:
        _check_implement(scenario, event)
    if event.do == "front_drive" and not scenario.drives_front:
        raise BadInput(f"{facts.name} has two driven wheels")
    if event.do == "lock" and not facts.lock:
        raise BadInput(f"{facts.name} has no differential lock")


def _check_implement(scenario: Scenario, event: Event) -> None:
    plough, part = scenario.plough, scenario.implement_file
    if plough is None or part is None:
        raise BadInput("there is no implement; a scenario with a plough would do")
    if event.depth_m is None:
        return
    if plough.hitch == "float":
        raise BadInput("plough.hitch = float leaves the depth to its wheel; depth would do")
    low, high = part.depths_m
    if not low <= event.depth_m <= high:
        raise OutOfRange(
            "depth_m", f"{event.depth_m:g}", f"[{low:g}, {high:g}], the depths of {part.name}"
        )
