"""Scores while driving and by phase, on a drive that works, turns, stands and backs up."""

import numpy as np
import pytest

from twin.scores import scores
from twin.scores.phases import phases
from twin.scores.table import left_out_lines, phase_rows
from twin.trajectory.phase import Phase

HZ = 50


def drive():
    """20 s of work, a stop of 10 s, 10 s of turning backward, 10 s of road."""
    t = np.arange(50 * HZ) / HZ
    stands, turns, road = (t >= 20) & (t < 30), (t >= 30) & (t < 40), t >= 40
    speed = np.select([stands, turns, road], [0.0, -1.0, 3.0], 1.5)
    slip = np.select([stands, turns, road], [0.0, -0.05, 0.02], 0.12)
    kept = 1.0 - np.abs(slip)
    return {
        "epoch_ns": np.round(t * 1e9).astype(np.int64),
        "speed_mps": speed,
        "wheel_speed_mps": speed / kept,
        "slip": slip,
        "depth_m": np.where(t < 20, 0.25, 0.0),
        "yaw_rate_radps": np.where(turns, 0.2, 0.0),
        "sideslip_rad": np.where(turns, np.pi - 0.01, np.where(stands, np.nan, 0.0)),
    }


def estimate(truth):
    """Right within 0.01 at work, 0.02 on the turn and 0.005 on the road; noise at rest."""
    off = np.select(
        [truth["speed_mps"] == 0.0, truth["speed_mps"] < 0.0, truth["speed_mps"] > 2.0],
        [0.9, -0.02, 0.005],
        0.01,
    )
    return {
        "epoch_ns": truth["epoch_ns"],
        "slip": truth["slip"] + off,
        "slip_sd": np.full(len(off), 0.008),
        "speed_mps": truth["speed_mps"],
        "sideslip_rad": np.where(truth["speed_mps"] < 0.0, -np.pi + 0.01, 0.0),
    }


def scored(truth, **columns):
    made = {"a": {**estimate(truth), **columns}}
    return scores.score(truth, made, scenario="s", seed=0, window=(0.0, 60.0))


def test_phases_are_told_by_depth_curve_and_speed():
    truth = drive()
    found = phases(truth)
    t = truth["epoch_ns"] * 1e-9
    for phase, first, last in (
        (Phase.WORK, 0, 19.9), (Phase.STOP, 20.1, 29.9), (Phase.TURN, 30.1, 39.9),
        (Phase.ROAD, 40.1, 49),
    ):  # fmt: skip
        assert set(found.code[(t > first) & (t < last)]) == {phase}
    assert "narrower than 25 m" in found.rule


def test_the_drivers_own_phases_are_taken_where_the_truth_has_them():
    truth = drive()
    truth["phase"] = np.full(len(truth["epoch_ns"]), Phase.ROAD)
    assert set(phases(truth).code) == {Phase.ROAD}
    assert set(scored(truth)["estimators"]["a"]["phases"]) == {"road"}


def test_scores_are_those_of_driving_and_count_what_they_leave_out():
    slip = scored(drive())["estimators"]["a"]["slip"]
    assert slip["n_slow"] == 10 * HZ
    assert slip["n"] == 40 * HZ
    assert slip["max"] == pytest.approx(0.02)


def test_each_phase_has_its_own_error_and_coverage():
    by = scored(drive())["estimators"]["a"]["phases"]
    assert list(by) == ["work", "turn", "road"]
    for phase, bias, inside in (("work", 0.01, 1.0), ("turn", -0.02, 0.0), ("road", 0.005, 1.0)):
        slip = by[phase]["slip"]
        assert slip["bias"] == pytest.approx(bias)
        assert slip["rmse"] == pytest.approx(abs(bias))
        assert slip["coverage_2sd"] == inside
    assert sum(by[p]["slip"]["n"] for p in by) == 40 * HZ


def test_an_angle_on_the_other_side_of_180_degrees_is_near():
    by = scored(drive())["estimators"]["a"]["phases"]
    assert by["turn"]["sideslip_angle_rad"]["max"] == pytest.approx(0.02)


def test_a_truth_that_crosses_180_degrees_is_not_interpolated_through_zero():
    truth = {"epoch_ns": np.array([0, 10]), "sideslip_rad": np.array([3.1, -3.1])}
    between = {"epoch_ns": np.array([5]), "sideslip_rad": np.array([np.pi])}
    assert scores.errors(truth, between, "sideslip_rad") == pytest.approx(0.0, abs=1e-9)


def test_spinning_on_the_spot_is_driving_and_standing_is_not():
    truth = drive()
    truth["wheel_speed_mps"] = np.where(truth["speed_mps"] == 0.0, 1.0, truth["wheel_speed_mps"])
    assert scored(truth)["estimators"]["a"]["slip"]["n_slow"] == 0


def test_tables_say_the_phases_and_what_is_left_out():
    found = scored(drive())
    rows = phase_rows(found)
    assert [row[:2] for row in rows] == [["a", "work"], ["a", "turn"], ["a", "road"]]
    assert rows[1][3:6] == ["2.000", "-2.000", "0.0"]
    assert left_out_lines(found) == [
        "slips left out where ground and wheels are slower than 0.3 m/s: 500 of 2500 (a)"
    ]


def test_one_phase_needs_no_table_and_nothing_left_out_no_line():
    truth = {name: column[: 20 * HZ] for name, column in drive().items()}
    found = scored(truth)
    assert phase_rows(found) == []
    assert left_out_lines(found) == []


def test_estimates_without_a_value_are_told_with_their_names():
    truth = drive()
    gone = np.where(truth["epoch_ns"] < 1e9, np.nan, truth["slip"])
    made = {"a": {**estimate(truth), "slip": gone}, "b": estimate(truth)}
    found = scores.score(truth, made, scenario="s", seed=0, window=(0.0, 60.0))
    slow, unknown = left_out_lines(found)
    assert slow.endswith("500 of 2500 (a, b)")
    assert unknown.endswith("the estimate or the truth has no value: 50 of 2500 (a)")


def test_without_a_speed_there_are_no_phases_and_all_is_scored():
    truth = {k: v for k, v in drive().items() if k in ("epoch_ns", "slip")}
    entry = scores.score(truth, {"a": estimate(drive())}, scenario="s", seed=0)["estimators"]["a"]
    assert phases(truth) is None
    assert "phases" not in entry
    assert entry["slip"]["n_slow"] == 0
