"""Slip of a tractor whose four wheels are driven, on a headland: steered wheels go a longer way."""

from dataclasses import replace

import pytest

import twin


@pytest.mark.slow
def test_slip_on_the_headland_of_four_driven_wheels():
    part = twin.load("field-day-cultivating-part")
    course = replace(part.course, length_m=20.0, road_m=30.0)
    day = replace(part, course=course, events=(), seed=11)
    phases = twin.run(day, estimators=["slip-ekf"]).scores["estimators"]["slip-ekf"]["phases"]
    turn, work = phases["turn"]["slip"], phases["work"]["slip"]
    assert turn["rmse"] < 0.016
    assert turn["coverage_2sd"] > 0.9
    assert abs(work["bias"]) < 0.006
