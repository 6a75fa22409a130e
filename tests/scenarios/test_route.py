"""Passes up and down a field, and the turns between: geometry, and driven by the tractor."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.simulation.rigs import PLOUGHING, driven
from twin.errors import TwinError
from twin.scenario import Course, Plough
from twin.scenario.route import CLEAR_M, RADIUS_M, Leg, end_of, on_leg, turn
from twin.simulation.passes import turned_over


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("heading_rad", [0.0, math.pi, 0.7])
@pytest.mark.parametrize("width_m", [1.4, 3.0, 9.0])
def test_a_turn_ends_on_the_next_line_going_back(side, heading_rad, width_m):
    legs = turn(Leg(3.0, -2.0, heading_rad), width_m, side)
    end = end_of(legs[-1])
    aside = side * np.array([-math.sin(heading_rad), math.cos(heading_rad)])
    ahead = np.array([math.cos(heading_rad), math.sin(heading_rad)])
    place = np.array([3.0, -2.0]) + CLEAR_M * ahead + width_m * aside
    assert (end.s_m, end.t_m) == pytest.approx(tuple(place))
    back = end.heading_rad - heading_rad - math.pi
    assert math.remainder(back, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("curvature_pm", [0.0, 1.0 / RADIUS_M, -0.2])
def test_a_place_beside_a_leg_is_found_by_its_way_and_its_error(curvature_pm):
    leg = Leg(1.0, 2.0, 0.4, 9.0, curvature_pm)
    for along in (0.0, 2.5, 8.0):
        for left in (-0.5, 0.0, 0.3):
            at = end_of(replace(leg, length_m=along))
            s = at.s_m - math.sin(at.heading_rad) * left
            t = at.t_m + math.cos(at.heading_rad) * left
            found = on_leg(leg, s, t, at.heading_rad + 0.1)
            assert found == pytest.approx((along, left, 0.1), abs=1e-9)


@cache
def headland():
    return driven(replace(PLOUGHING, course=Course(length_m=25.0, passes=3)))


def passes(columns):
    """Index ranges at full depth."""
    full = np.concatenate([[False], columns["depth_m"] > 0.2, [False]])
    edges = np.flatnonzero(np.diff(full))
    spans = edges.reshape(-1, 2)
    return [slice(a, b) for a, b in spans if b - a > 2000]


def test_three_passes_are_ploughed_side_by_side_at_the_same_depth_and_draft():
    columns = headland()
    spans = passes(columns)
    assert len(spans) == 3
    for k, span in enumerate(spans):
        steady = slice(span.start + 2000, span.stop - 200)
        place = columns["position_w"][steady]
        assert place[:, 1] == pytest.approx(1.4 * k, abs=0.12)
        assert np.sign(np.diff(place[[0, -1], 0]))[0] == (1.0 if k % 2 == 0 else -1.0)
        assert columns["depth_m"][steady].mean() == pytest.approx(0.25, abs=0.01)
    drafts = [columns["draft_n"][span].mean() for span in spans]
    assert np.ptp(drafts) < 0.1 * np.mean(drafts)


def test_on_the_headland_the_plough_is_out_and_the_tractor_leans_to_the_other_side_after_it():
    columns = headland()
    first, second, third = passes(columns)
    between = slice(first.stop + 1500, second.start - 1500)
    assert np.all(columns["depth_m"][between] == 0.0)
    w, x, y, z = np.moveaxis(columns["world_from_body"], -1, 0)
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    means = [roll[span.start + 1500 : span.stop].mean() for span in (first, second, third)]
    assert means[0] == pytest.approx(-means[1], abs=0.012)
    assert means[0] == pytest.approx(means[2], abs=0.012)
    assert abs(math.degrees(means[0])) > 7.0


def test_the_run_ends_after_its_last_pass():
    assert passes(headland())[-1].stop > len(headland()["depth_m"]) - 50


def test_a_reversible_plough_is_turned_over():
    right = replace(PLOUGHING, plough=Plough(furrow="right"))
    assert turned_over(right).plough.furrow == "left"
    assert turned_over(turned_over(right)) == right


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"approach_m": 5.0}, r"course.approach_m = 5 is outside \[15, 500\]"),
        ({"hold_line": False}, "course.passes = 2 needs a driver"),
        ({"passes": 0}, r"course.passes = 0 is outside \[1, 1000\]"),
    ],
)
def test_passes_that_cannot_be_driven_are_refused(given, message):
    with pytest.raises(TwinError, match=message):
        Course(**{"passes": 2} | given)
