"""Statistics of a drive at 1 Hz against closed forms, and the constants that are kept of a log."""

import csv
import importlib.util
from pathlib import Path

import numpy as np
import pytest

from twin.logs.drive_statistics import drive_statistics, ratios

ROOT = Path(__file__).parents[2]
LOG = ROOT.parent / "shared" / "data" / "t7165s_field.csv"


def test_steady_driving_changes_nothing():
    found = drive_statistics(np.full(100, 2.0), np.full(100, 1.8), np.full(100, 2000.0))
    assert found.pop("standing") == found.pop("stops_per_h") == 0.0
    assert set(found.values()) == {0.0}


def test_a_wave_has_the_rms_of_its_changes():
    t = np.arange(36000.0)
    wheel = 2.0 + np.sin(2.0 * np.pi * t / 61.7)
    found = drive_statistics(wheel, wheel, 1500.0 + 0.0 * t)
    for step in (1, 20):
        expected = 2.0 * np.sin(np.pi * step / 61.7)  # amplitude of the change
        assert found[f"wheel_mps_rms_{step}s"] == pytest.approx(expected / np.sqrt(2.0), rel=1e-3)
        assert found[f"wheel_mps_mad_{step}s"] == pytest.approx(expected / np.sqrt(2.0), rel=0.02)
    assert found["slip_rms_1s"] == 0.0


def test_stops_and_standing_are_counted():
    wheel = np.tile([2.0, 2.0, 2.0, 0.0], 900)
    found = drive_statistics(wheel, wheel, np.where(wheel > 0.0, 1500.0, 0.0))
    assert found["standing"] == 0.25
    assert found["stops_per_h"] == 900.0
    running = drive_statistics(wheel, wheel, np.where(wheel > 0.0, 1500.0, 0.0), engine_on=True)
    assert running["standing"] == running["stops_per_h"] == 0.0


def test_ratios_leave_out_what_the_other_has_not():
    assert ratios({"a": 3.0, "b": 1.0, "c": 0.0}, {"a": 2.0, "b": 0.0, "c": 0.0}) == {
        "a": 1.5, "c": 1.0,
    }  # fmt: skip


@pytest.mark.skipif(not LOG.exists(), reason="the log is not here")
def test_what_is_kept_of_the_log_is_its_own():
    path = ROOT / "docs" / "field_day_picture.py"
    spec = importlib.util.spec_from_file_location("field_day_picture", path)
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    with LOG.open() as file:
        rows = list(csv.DictReader(file))
    wheel, ground, engine = (
        np.array([float(row[name]) for row in rows])
        for name in ("wheel_speed_kmh", "gnss_speed_mps", "engine_speed_rpm")
    )
    wheel *= 0.993 / 3.6
    for kept, engine_on in ((page.LOG, False), (page.LOG_ON, True)):
        found = drive_statistics(wheel, ground, engine, engine_on=engine_on)
        assert found == pytest.approx(kept, rel=0.01, abs=1e-4)
