"""Every scenario that is shipped drives its course, to its end or to the edge of its platform."""

from dataclasses import replace

import pytest

from twin.pipeline import named as registry
from twin.scenario import Scenario
from twin.sensors import Sensors
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.trajectory.end import Outcome

SCENARIOS = {name: registry.load("scenario", name) for name in registry.names("scenario")}


def distinct():
    """One name for each drive: what it is called and what measures it changes nothing of it."""
    found = {}
    for name, scenario in SCENARIOS.items():
        if isinstance(scenario, Scenario):
            found.setdefault(repr(replace(scenario, name="", about="", sensors=Sensors())), name)
    return list(found.values())


@pytest.mark.parametrize("name", distinct())
def test_a_shipped_scenario_drives_its_course(name):
    scenario = SCENARIOS[name]
    for last in simulate(build(scenario)):  # noqa: B007  # hours are not held in memory
        pass
    course = scenario.course
    assert last.end.as_planned
    if last.end.outcome is Outcome.DRIVEN:
        assert last.end.along_m >= course.approach_m + course.length_m
        assert last.end.way == ("the course" if course.passes == 1 else f"pass {course.passes}")
    else:
        assert course.edge_m is not None
