from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.synthetic_run import STUB, Scenario, estimate_table, truth_table
from twin.scores import scores
from twin.trajectory.end import End, Outcome


def test_errors_of_a_known_series() -> None:
    found = scores.error_scores(np.array([3.0, -4.0, np.nan, 0.0]))
    assert found["rmse"] == pytest.approx(np.sqrt(25.0 / 3.0))
    assert found["mae"] == pytest.approx(7.0 / 3.0)
    assert found["bias"] == pytest.approx(-1.0 / 3.0)
    assert (found["max"], found["n"], found["n_nan"]) == (4.0, 3, 1)


def test_honest_gaussian_errors_have_their_coverage_and_unit_nees() -> None:
    n = 40_000
    sd = np.full(n, 0.3)
    found = scores.error_scores(0.3 * np.random.default_rng(3).standard_normal(n), sd)
    assert found["nees_mean"] == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / n))
    assert found["coverage_2sd"] == pytest.approx(0.9545, abs=4.0 * np.sqrt(0.9545 * 0.0455 / n))
    assert found["p999"] == pytest.approx(3.29 * 0.3, rel=0.1)


def test_overconfident_errors_show_in_both() -> None:
    found = scores.error_scores(np.full(10, 1.0), np.full(10, 0.25))
    assert (found["coverage_2sd"], found["nees_mean"]) == (0.0, 16.0)


def test_only_nan_leaves_no_number_and_counts_them() -> None:
    found = scores.error_scores(np.full(5, np.nan), np.ones(5))
    assert (found["rmse"], found["n"], found["n_nan"]) == (None, 0, 5)


def test_window_starts_five_metres_after_full_depth() -> None:
    truth = truth_table()  # 1.5 m/s, at depth from 6 s
    start, end = scores.window_s(truth)
    assert start == pytest.approx(6.0 + 5.0 / 1.5, abs=0.021)
    assert end == 20.0


def test_window_without_ploughing_starts_at_five_seconds() -> None:
    truth = truth_table()
    truth["ploughing"] = np.zeros_like(truth["ploughing"])
    assert scores.window_s(truth) == (5.0, 20.0)


def test_window_of_a_run_too_short_to_be_scored_is_its_last_instant() -> None:
    assert scores.window_s(truth_table(duration_s=7.0)) == (7.0, 7.0)


def test_truth_is_matched_at_the_estimate_s_own_epoch() -> None:
    truth = {"epoch_ns": np.array([0, 10, 20]), "slip": np.array([0.0, 1.0, np.nan])}
    at = scores.at(truth, "slip", np.array([-1, 5, 10, 15, 21]))
    np.testing.assert_allclose(at, [np.nan, 0.5, 1.0, np.nan, np.nan])


def test_matching_is_exact_far_from_the_epoch_s_origin() -> None:
    start = 1_700_000_000_000_000_000
    truth = {"epoch_ns": start + np.array([0, 10]), "slip": np.array([0.0, 1.0])}
    assert scores.at(truth, "slip", np.array([start + 3]))[0] == pytest.approx(0.3)


def test_total_is_the_change_inside_the_window() -> None:
    epoch = np.arange(5)
    truth = {"epoch_ns": epoch, "sideslip_m": np.array([9.0, 9.0, 9.5, 10.0, 10.0])}
    estimate = {"epoch_ns": epoch, "sideslip_m": np.array([0.0, 1.0, 1.4, 2.1, np.nan])}
    found = scores.total_scores(truth, estimate, "sideslip_m")
    assert found == {
        "true_m": pytest.approx(1.0), "est_m": pytest.approx(2.1), "rel_err": pytest.approx(1.1),
    }  # fmt: skip


def test_small_totals_have_no_relative_error() -> None:
    epoch = np.arange(2)
    truth = {"epoch_ns": epoch, "sideslip_m": np.array([0.0, -0.049])}
    estimate = {"epoch_ns": epoch, "sideslip_m": np.array([0.0, 1.0])}
    assert scores.total_scores(truth, estimate, "sideslip_m")["rel_err"] is None


def test_an_error_before_the_window_does_not_count() -> None:
    truth = truth_table()
    estimate = estimate_table(truth, seed=1, slip_sd=0.01)
    spoilt = {**estimate, "slip": np.where(estimate["epoch_ns"] < 5e9, 9.0, estimate["slip"])}
    same = [
        scores.score(truth, {"a": t}, scenario="s", seed=0)["estimators"]["a"]["slip"]
        for t in (estimate, spoilt)
    ]
    assert same[0] == same[1]


def test_truth_summary_of_a_known_drive() -> None:
    summary = scores.truth_summary(truth_table(), (10.0, 20.0))
    assert summary["mean_speed_kmh"] == pytest.approx(5.4)
    assert summary["distance_m"] == pytest.approx(15.0)
    assert summary["draft_mean_kn"] == pytest.approx(18.0, rel=0.02)
    assert summary["draft_cv"] == pytest.approx(0.05 / np.sqrt(2.0), rel=0.1)
    assert summary["sideslip_m"] == pytest.approx(0.2)


def test_no_draft_is_none_and_not_zero() -> None:
    truth = truth_table()
    truth["draft_n"] = np.zeros_like(truth["draft_n"])
    summary = scores.truth_summary(truth, (10.0, 20.0))
    assert (summary["draft_mean_kn"], summary["draft_cv"]) == (None, None)


def test_without_truth_nothing_is_scored() -> None:
    found = scores.score(None, {"a": {"epoch_ns": np.arange(2)}}, scenario="log", seed=None)
    assert (found["window_s"], found["estimators"]) == (None, {"a": {}})


def test_a_run_that_ended_early_is_scored_where_there_is_enough_of_it() -> None:
    stuck = End(outcome=Outcome.STUCK, time_s=20.0, along_m=9.0, left_m=0.0, measured=0.9)
    ploughed = truth_table(duration_s=20.0)
    begins_s, _ = scores.window_s(ploughed)
    bare = replace(STUB, plough=None)

    def why(duration_s: float, scenario: Scenario) -> str | None:
        truth = truth_table(duration_s=duration_s)
        truth["ploughing"] &= scenario.plough is not None
        return scores.why_unscored(truth, scenario, stuck)

    assert why(begins_s + 1.1, STUB) is None
    assert why(begins_s + 0.5, STUB) == "it drove less than 1 s beyond the first 5 m at full depth"
    assert why(6.5, bare) is None
    assert why(5.5, bare) == "it drove less than 1 s beyond the first 5 s"
    never = {**ploughed, "ploughing": np.zeros_like(ploughed["ploughing"])}
    assert "full depth" in str(scores.why_unscored(never, STUB, stuck))
    planned = replace(stuck, outcome=Outcome.DRIVEN)
    for end in (planned, replace(stuck, outcome=Outcome.SHALLOW), None):
        assert scores.why_unscored(never, STUB, end) is None
