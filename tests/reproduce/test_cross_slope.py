from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("cv2")

from twin.pipeline.named import load
from twin.pipeline.run import run
from twin.reproduce import cross_slope, cross_slope_trial
from twin.reproduce.cross_slope import (
    CELLS,
    OWN,
    Limits,
    bound_sd_m,
    drive,
    error_rows,
    growth,
    total_rows,
)
from twin.reproduce.cross_slope_trial import Estimate, Trial


def made(slope, soil, error_m=0.002, sd_m=0.002):
    """Trials that slid as published and were estimated with an error of either sign."""
    total = -cross_slope.PUBLISHED_M[slope, soil, False]
    signs = np.tile([1.0, -1.0], 15)
    return [
        Trial(
            total_m=total,
            length_m=9.0,
            time_s=9.0,
            exit_heading_deg=-8.0,
            estimates={
                (method, masked): Estimate(told_m=total + s * error_m, true_m=total, sd_m=sd_m)
                for method in (OWN, "other")
                for masked in (False, True)
            },
        )
        for s in signs
    ]


def by_name(rows, quantity, case=None):
    return [r for r in rows if r["quantity"] == quantity and case in (None, r["case"])]


def test_rows_hold_where_all_is_as_published_and_not_where_sd_or_error_lie():
    cells = {cell: made(*cell) for cell in CELLS}
    assert all(r["passed"] for r in total_rows(cells) if "passed" in r)
    rows = error_rows(cells)
    assert all(r["passed"] for r in by_name(rows, f"{OWN}: median error") if "passed" in r)
    assert all(r["passed"] for r in by_name(rows, f"{OWN}: NEES"))
    lying = error_rows({cell: made(*cell, error_m=0.03) for cell in CELLS})
    assert not any(r["passed"] for r in by_name(lying, f"{OWN}: NEES"))
    assert not any(r["passed"] for r in by_name(lying, f"{OWN}: median error") if "passed" in r)


def test_the_bound_is_its_formula():
    """Each term by itself, the others' causes taken away."""
    none = Limits(frame_sd_mps=0.0, velocity_sd_mps=0.0, heading_sd_rad=0.0, gyro_radps_rthz=0.0,
                  gyro_wander_radps=0.0, gyro_scale=0.0)  # fmt: skip

    def bound(**causes):
        return bound_sd_m(0.33, 9.0, 0.14, replace(none, **causes))

    assert bound() == 0.0
    one = 1e-3
    assert bound(frame_sd_mps=one) == pytest.approx(one * np.sqrt(0.3 + 81 / 1200))
    seen_m = 0.33 + 0.63 * 0.14
    assert bound(velocity_sd_mps=one) == pytest.approx(seen_m * one / 0.98 / np.sqrt(800))
    assert bound(gyro_scale=one) == pytest.approx(0.63 * 0.14 * one)
    in_run, before = 0.63 * np.sqrt(9.0), 0.98 * 9.0 / np.sqrt(40.0)
    assert bound(gyro_radps_rthz=one) == pytest.approx(one * np.hypot(in_run, before))
    assert bound(gyro_wander_radps=one) == pytest.approx(0.63 * 9.0 * one * np.sqrt(0.22))
    t = (np.arange(400) - 199.5) / 20.0  # least squares of a slope through a leg's headings
    slope_sd = one / np.sqrt((t**2).sum()) / np.sqrt(2.0)
    assert bound(heading_sd_rad=one) == pytest.approx(0.35 * 9.0 * slope_sd, rel=1e-4)


def test_growth_is_one_for_a_steady_slide_whatever_the_speed():
    time_s = np.linspace(0.0, 9.0, 1000)
    table = {"epoch_ns": np.round(time_s * 1e9).astype(np.int64), "v_y_mps": 0.0 * time_s}
    speed = 1.0 + 0.1 * time_s
    driven = time_s + 0.05 * time_s**2
    steady = table | {"v_x_mps": speed, "sideslip_m": -0.03 * driven}
    assert growth(steady) == pytest.approx(1.0)
    slows = steady | {"sideslip_m": -np.sqrt(driven)}
    assert growth(slows) < 0.7


def test_true_totals_of_the_sweep_grow_with_the_slope_and_ever_slower():
    driven = [drive(load("scenario", f"slope-{s}-dry")) for s in cross_slope.SWEEP_DEG]
    totals = [abs(table["sideslip_m"][-1]) for table in driven]
    assert all(growth(table) < 1.0 for table in driven)
    assert np.all(np.diff(totals) > 0.03)
    assert totals[3] / totals[1] == pytest.approx(cross_slope.RATIO, rel=cross_slope.RATIO_WITHIN)


@pytest.mark.slow
def test_a_drive_is_estimated_open_and_masked(monkeypatch):
    named = load("scenario", "slope-18-wet")
    camera = replace(named.sensors.camera, binning=8)
    short = replace(
        named,
        course=replace(named.course, calibration_m=5.0, length_m=2.5),
        sensors=replace(named.sensors, camera=camera),
    )
    real = cross_slope_trial.load
    monkeypatch.setattr(
        cross_slope_trial, "load", lambda kind, n: short if kind == "scenario" else real(kind, n)
    )
    found, calibrated = cross_slope_trial.trial("slope-18-wet", 3, 18.0)
    again, same = cross_slope_trial.trial("", 3, 18.0, papers=False, before=calibrated)
    assert same is calibrated
    assert again.estimates == {k: e for k, e in found.estimates.items() if k[0] == OWN}
    whole = run(replace(short, seed=3), estimators={OWN: load("estimator", OWN)})
    told = whole.estimates[OWN]["sideslip_m"]
    assert found.estimates[OWN, False].told_m == told[np.isfinite(told)][-1] - told[0]
    assert found.total_m < -0.1
    for masked in (False, True):
        own = found.estimates[OWN, masked]
        assert own.true_m == pytest.approx(found.total_m, abs=0.01)
        assert own.relative < 0.08
        assert abs(own.error_m) < 4 * own.sd_m + 1e-3
        assert found.estimates["GNSS chain as printed", masked].told_m == pytest.approx(0, abs=1e-9)
