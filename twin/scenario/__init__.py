"""What a run is made of: machine, ground, implement, course, sensors and a seed."""

from twin.scenario.course import Course, Drive
from twin.scenario.driver import Driver
from twin.scenario.events import Event
from twin.scenario.field import Field, Patch
from twin.scenario.plough import Plough
from twin.scenario.scenario import Scenario
from twin.scenario.soil import Soil

__all__ = ["Course", "Drive", "Driver", "Event", "Field", "Patch", "Plough", "Scenario", "Soil"]
