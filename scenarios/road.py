"""Driving on roads at steady speed, as in Zhang (2018)."""

from __future__ import annotations

from twin.scenario import Course, Drive, Scenario, Soil

ASPHALT_10 = Scenario(
    name="road-asphalt-10kmh",
    about="asphalt at 10 km/h, 200 m",
    soil=Soil(preset="asphalt"),
    drive=Drive(gear_ratio=52.0, engine_set_rpm=1700.0),
    course=Course(approach_m=15.0, length_m=200.0),
)
