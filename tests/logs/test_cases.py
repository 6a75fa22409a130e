"""Logs that were once read wrongly, and what each of them must do."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from twin.errors import BadInput
from twin.logs import Log, read
from twin.pipeline.log import estimate, slip_summary
from twin.pipeline.public import by_name

CASES = Path(__file__).parents[3] / "shared" / "cases" / "logs"
pytestmark = pytest.mark.skipif(not CASES.exists(), reason="the cases are not beside the checkout")


def log_of(name: str, column_map: str | None = None) -> Log:
    return read(CASES / name, None if column_map is None else CASES / column_map)


def slip_of(name: str, column_map: str, estimator: str = "ratio") -> float | None:
    result = estimate(CASES / name, CASES / column_map, estimators=by_name([estimator]))
    return slip_summary(result.estimates[estimator])["median"]


def noted(log: Log, part: str) -> bool:
    return any(part in note for note in log.notes)


@pytest.mark.parametrize("name", ["gnss_1hz_carried_forward.csv", "gnss_1hz_blank_between.csv"])
@pytest.mark.slow
def test_a_value_carried_forward_is_one_measurement(name):
    result = estimate(CASES / name, CASES / "carried.toml", estimators=by_name(["slip-ekf"]))
    score = result.scores["estimators"]["slip-ekf"]["slip"]
    assert 100 * score["rmse"] < 0.6
    assert len(result.streams["gnss"]["epoch_ns"]) == 60


@pytest.mark.slow
def test_a_start_in_a_curve_does_not_teach_the_wheels_a_wrong_scale():
    found = slip_of("launch_in_a_curve.csv", "launch_in_a_curve.toml", "slip-ekf")
    assert found == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("name", "column_map", "slip", "part"),
    [
        ("wheel_mph_as_kmh.csv", "map.toml", -0.347, "mph taken for km/h would give +0.048"),
        ("wheel_cutoff.csv", "map.toml", None, "below the sensor's cut-off"),
        ("latlon_swapped.csv", "map.toml", 0.0, "are latitude and longitude swapped"),
        ("time_s_as_ms.csv", "map_ms.toml", 0.0, "s taken for ms"),
        ("sparse_rows.csv", "map.toml", 0.0, "heading brought to the times of latitude"),
        ("position_only.csv", "position_only.toml", 0.1, "velocity made of the positions"),
        ("sideslip_no_wheels.csv", "sideslip_no_wheels.toml", None, "no wheel speed"),
        ("one_speed_spike.csv", "map.toml", 0.0, "1 of 60 rows left out"),
        ("wheel_ffff.csv", "map.toml", 0.0, "as 255.996, are holes"),
        ("decimal_comma.csv", "map.toml", 0.0, "decimal comma"),
        ("cut_last_row.csv", "map.toml", 0.0, "row 60 has 4 cells"),
        ("latin1_header.csv", "map.toml", 0.0, "text read as cp1252"),
        ("bearing_ffff.csv", "map_course.toml", 0.0, "as 511.992, are holes"),
        ("ticks_12bit_wrap.csv", "ticks.toml", 0.045, "a counter of 12 bits unwrapped 9 times"),
    ],
)
def test_the_slip_of_a_table_and_what_is_noted(name, column_map, slip, part):
    assert slip_of(name, column_map) == (None if slip is None else pytest.approx(slip, abs=0.005))
    assert noted(log_of(name, column_map), part), log_of(name, column_map).notes


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("underscore_number.csv", "'7_2' is not a number; 30 of 60 rows are bad"),
        ("header_commas.csv", "no column is called 'v'; there are: hdg, deg, lat, lon, t, v, m/s"),
    ],
)
def test_what_is_refused_says_why(name, part):
    with pytest.raises(BadInput) as caught:
        log_of(name, "map.toml")
    assert part in str(caught.value)


def test_a_bearing_of_512_degrees_is_none():
    v_north = log_of("bearing_ffff.csv", "map_course.toml").streams["gnss"]["v_north_mps"]
    assert np.flatnonzero(np.isnan(v_north)).tolist() == [10, 11, 12]
    np.testing.assert_allclose(v_north[np.isfinite(v_north)], 2.0)


@dataclass(frozen=True)
class Receiver:
    name: str
    rows: int
    v_north_mps: tuple[float, ...] = ()
    heading_deg: float | None = None
    north_m: tuple[float, ...] = ()
    starts_s: float | None = None


@pytest.mark.parametrize(
    "case",
    [
        Receiver("n01_vtg_first.nmea", 20, v_north_mps=(0.0, 1 / 3.6, 2 / 3.6)),
        Receiver("n04_coldstart_date.nmea", 5, starts_s=1_718_359_200.0),
        Receiver("n08_two_talkers.nmea", 5),
        Receiver("n11_ths.nmea", 10, heading_deg=5.0),
        Receiver("n14_midline_start.log", 10, v_north_mps=(2.058,)),
        Receiver("n15_bom.txt", 10, v_north_mps=(2.058,)),
        Receiver("n28_tagblock.nmea", 5),
        Receiver("n30_rmc_lowres_pos.nmea", 20, north_m=(0.0, 2.04, 4.08)),
        Receiver("n31_panda.nmea", 20, heading_deg=90.0),
        Receiver("n39_vtg_empty_letters.nmea", 10, v_north_mps=(7.4 / 3.6,)),
    ],
    ids=lambda case: case.name,
)
def test_receivers(case):
    gnss = log_of(case.name).streams["gnss"]
    assert len(gnss["epoch_ns"]) == case.rows
    for column, values in (("v_north_mps", case.v_north_mps), ("north_m", case.north_m)):
        np.testing.assert_allclose(gnss.get(column, np.empty(0))[: len(values)], values, atol=1e-2)
    if case.heading_deg is not None:
        assert gnss["heading_rad"][0] == pytest.approx(np.radians(90.0 - case.heading_deg))
    if case.starts_s is not None:
        assert gnss["epoch_ns"][0] == case.starts_s * 1e9


def test_a_receiver_without_a_fix_has_no_velocity():
    with pytest.raises(BadInput, match="says it has no fix"):
        log_of("n33_rmcV_vtgN_nogga.nmea")
