"""Driving along a cross-slope without an implement."""

from __future__ import annotations

from twin.scenario import Course, Drive, Field, Scenario

TAISHAN_8 = Scenario(
    name="slope-8-taishan",
    about="the tractor alone along an 8 degree cross-slope, 100 m, line held",
    field=Field(cross_slope_deg=8.0),
    drive=Drive(gear_ratio=66.0, engine_set_rpm=1628.0),
    course=Course(approach_m=15.0, length_m=100.0),
)
