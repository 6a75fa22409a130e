"""The experiment of `sideslip-ekf`: what its rows make of drives, and a short drive."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from twin.reproduce import ABOUT, REGISTRY, STORIES, sideslip_ekf
from twin.reproduce.sideslip_ekf_drive import Drive, drive

HONEST = Drive(
    total_m=0.5, error_m=0.01, bound_m=0.012, run_error_m=0.01, run_sd_m=0.012,
    total_covered=0.95, angle_rms_rad=1e-3, angle_covered=0.95,
)  # fmt: skip


def test_it_is_among_the_experiments():
    assert REGISTRY["sideslip-ekf"] == "twin.reproduce.sideslip_ekf:rows"
    assert ABOUT.keys() == REGISTRY.keys()
    assert STORIES["sideslip-ekf"] == "twin.reproduce.sideslip_ekf:said"
    assert "calibration" in sideslip_ekf.said([]).paragraphs[0]


def made(monkeypatch, rows, **changed):
    """Rows by case and quantity, of drives that are all alike but for a sign."""

    def told(scenario, seed):
        each = replace(HONEST, **changed)
        return replace(each, error_m=each.error_m * (-1) ** seed)

    monkeypatch.setattr(sideslip_ekf, "drive", told)
    return {(r["case"], r["quantity"]): r for r in rows()}


def blind_rows():
    return sideslip_ekf.bound_rows("all", {"a": None, "b": None}, 4, 1)


def test_a_total_is_measured_by_its_bound_and_the_shares_are_pooled(monkeypatch):
    rows = made(monkeypatch, blind_rows)
    over = rows["a", "median error over the bound's"]
    assert over["ours"] == pytest.approx(0.01 / (0.6745 * 0.012), rel=1e-3)
    assert over["passed"]
    pooled = rows["all", "total within 2 sd, share of time"]
    assert (pooled["ours"], pooled["passed"]) == (pytest.approx(0.95), True)
    assert rows["b", "its NEES"]["ours"] == pytest.approx((0.01 / 0.012) ** 2)


@pytest.mark.parametrize(
    ("changed", "broken"),
    [
        ({"error_m": 0.03}, ["median error over the bound's"] * 2),
        ({"total_covered": 1.0}, ["total within 2 sd, share of time"]),
        ({"angle_covered": 0.8}, ["angle within 2 sd, share of time"]),
    ],
)
def test_what_is_not_reached_is_printed_as_failing(monkeypatch, changed, broken):
    rows = made(monkeypatch, blind_rows, **changed)
    assert [q for (_, q), row in rows.items() if not row.get("passed", True)] == broken


def test_a_single_run_has_no_interval_and_no_row_of_it(monkeypatch):
    rows = made(monkeypatch, lambda: sideslip_ekf.bound_rows("all", {"a": None}, 1, 1))
    assert not any("interval" in quantity for _, quantity in rows)


def test_under_a_camera_totals_and_angles_have_limits_of_their_own(monkeypatch):
    rows = made(monkeypatch, lambda: sideslip_ekf.camera_rows(2, 1), bound_m=np.nan)
    case = "ploughing under a camera, 5 degrees"
    assert rows[case, "median error of the total"]["passed"]
    assert rows[case, "angle, rms"]["ours"] == pytest.approx(np.degrees(1e-3))
    worse = made(monkeypatch, lambda: sideslip_ekf.camera_rows(2, 1), angle_rms_rad=2e-3)
    assert not worse[case, "angle, rms"]["passed"]


def test_drives_without_a_camera_begin_with_a_calibration_and_masks_end_within_them():
    cases = {**sideslip_ekf.ploughing(), **sideslip_ekf.along_slope()}
    assert len(cases) == 11
    for scenario in cases.values():
        assert scenario.sensors.camera is None
        assert scenario.course.calibration_m == sideslip_ekf.CALIBRATION_M
    masked = [s.sensors.gnss.outages[0] for s in cases.values() if s.sensors.gnss.outages]
    assert sorted(outage.duration_s for outage in masked) == [10.0, 10.0, 60.0, 60.0]
    assert {s.field.cross_slope_deg for s in sideslip_ekf.along_slope().values()} == {8.0}


@pytest.mark.slow
def test_a_short_drive_is_compared_with_its_truth():
    scenario = sideslip_ekf.along_slope()["driving along 8 degrees"]
    short = replace(scenario, course=replace(scenario.course, approach_m=5.0, length_m=20.0))
    found = drive(short, 1)
    assert found == drive(short, 1)
    assert 0.2 < abs(found.total_m) < 1.5
    assert abs(found.run_error_m) < 4.0 * found.run_sd_m
    assert 0.0 < found.bound_m < 1.5 * found.run_sd_m
    assert all(np.isfinite(each) for each in dataclasses.astuple(found))
