import re

import pytest

from twin.scores.hours import hours, hours_seconds, start_text
from twin.scores.log_table import activity_rows, assumptions, fuel_sentences, number, slip_rows
from twin.scores.table import hidden_notes

SHARE = {
    "activity": "working", "time_s": 3600.0, "distance_m": 7200.0, "speed_kmh": 7.2,
    "slip_median": 0.0731, "slip_p05": -0.0001, "slip_p95": 0.12, "slip_n": 3600,
    "engine_rpm": 2000.0, "engine_load": 0.9, "fuel_lph": 25.0, "fuel_l": 25.0,
}  # fmt: skip
AREA = {
    "width_m": 3.0, "area_ha": 2.16, "ha_per_h": 2.16,
    "fuel_at_work_l_per_ha": 11.57, "fuel_with_turns_l_per_ha": 12.5,
}  # fmt: skip
DRIVE = {
    "span_s": 3600.0, "start_ns": 0, "estimator": "ratio", "rule": "Working is work.",
    "shares": [SHARE, {**SHARE, "activity": "all"}], "area": AREA, "width_m": 3.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (-0.13, "{:.2f}", "-0.13"), (-0.04, "{:.1f}", "0.0"), (-0.4, "{:.0f}", "0"),
        (-0.05, "{:.2f}", "-0.05"), (-10.0, "{:.0f}", "-10"), (-0.001, "{:.1f} %", "0.0 %"),
        (None, "{:.1f}", None),
    ],
)  # fmt: skip
def test_only_what_rounds_to_zero_loses_its_sign(value, form, text):
    assert number(value, form) == text


def test_time_is_in_hours_and_minutes():
    assert [hours(s) for s in (0, 59, 3600, 11795)] == ["0:00", "0:01", "1:00", "3:17"]
    assert hours_seconds(11795) == "3:16:35"
    assert start_text(0) == "0:00 is 0 s of the log's clock"
    assert start_text(1_698_045_125_000_000_000) == "0:00 is 2023-10-23 07:12:05 UTC"


def test_slip_is_in_percent_in_every_cell():
    row = activity_rows({"drive": DRIVE})[0]
    assert row[:7] == ["working", "1:00", "100", "7.20", "7.2", "7.3", "0.0 to 12.0"]
    slip = {"median": 0.07, "p05": -0.01, "p95": 0.1, "n": 9}
    silent = {"median": None, "p05": None, "p95": None, "n": 0}
    scores = {"slip": {"ratio": slip, "mute": silent}, "work_slip": {"ratio": slip}}
    assert slip_rows(scores) == [
        ["ratio", "while driving", "7.00", "-1.00", "10.00", "9"],
        ["ratio", "at work", "7.00", "-1.00", "10.00", "9"],
    ]


def test_litres_per_hectare_or_why_not():
    assert "11.6 L/ha at work, 12.5 L/ha with the turns" in fuel_sentences({"drive": DRIVE})[0]
    unknown = {**DRIVE, "width_m": None, "area": None}
    assert "implement's width is unknown" in fuel_sentences({"drive": unknown})[0]
    dry = {**DRIVE, "shares": [{**SHARE, "activity": "all", "fuel_lph": None}]}
    assert "no fuel rate" in fuel_sentences({"drive": dry})[0]
    assert "no work was found" in fuel_sentences({"drive": {**DRIVE, "area": None}})[0]
    assert fuel_sentences({"drive": None}) == []


def test_a_rule_of_the_map_says_where_slip_is_zero_in_one_line():
    slip = {"median": 0.07, "p05": -0.01, "p95": 0.1, "n": 9}
    scale = {"scale": 0.9933, "low": 0.99, "high": 1.0, "n": 50, "rule": "state in {M}"}
    told = {"slip": {"ratio": slip}, "zero_slip": "unknown", "zero_slip_scale": scale}
    (line,) = (line for line in assumptions(told) if "zero" in line)
    assert "50 rows of the log where state in {M}" in line
    assert "scale 0.9933 (95 % interval: 0.990 to 1.000)" in line
    assert "not stated" not in line
    (line,) = (a for a in assumptions({**told, "zero_slip_scale": None}) if "zero" in a)
    assert line == "slip is zero at: not stated"
    from_set_up = {**told, "zero_slip_scale": None, "zero_slip_from": "zero slip: as logged"}
    assert assumptions(from_set_up) == ["zero slip: as logged"]


def test_what_a_dash_means_and_who_ran_away_without_gnss():
    row = {"estimator": "ratio", "hidden_s": 60.0, "n": 4, "speed_rms_mps": None,
           "slip_rms": None, "in_2sd": None}  # fmt: skip
    away = {**row, "estimator": "four-state", "speed_rms_mps": 11.0, "slip_rms": 0.8}
    fine = {**away, "estimator": "slip-ekf", "speed_rms_mps": 0.1, "in_2sd": 0.9}
    notes = hidden_notes({"hidden": [row, away, fine], "drive": DRIVE})
    assert notes[0].startswith("a dash: ratio gives nothing without GNSS")
    assert "states no slip_sd" in notes[1]
    assert notes[2].startswith(
        "four-state: a speed RMS above the log's own mean speed while driving, 2.00"
    )
    assert "ran away" in notes[2]
    assert hidden_notes({"hidden": [fine], "drive": DRIVE}) == []
    assert hidden_notes({}) == []


def test_what_was_assumed_ends_with_the_notes():
    steady = {
        "slip_median": 0.07, "slip_low": 0.05, "slip_high": 0.08, "n": 9, "rule": "r",
        "scale": 0.99,
        "scale_low": 0.98, "scale_high": 1.0, "scale_n": 5, "scale_rule": "q", "lag_s": None,
    }  # fmt: skip
    lines = assumptions({"drive": DRIVE, "steady": steady, "notes": ["last"], "protocol": None})
    assert lines[-1] == "last"
    assert any(
        re.match(r"steady work: median slip 7.0 % \(95 % interval: 5.0 to 8.0 %\)", line)
        for line in lines
    )
    assert "Working is work." in lines
