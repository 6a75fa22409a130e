"""Slides across a slope whose amount is known, with and without camera and GNSS."""

import dataclasses

import numpy as np
import pytest
from slides import LEG_S, SETUP, slides

from estimators.sideslip_ekf import SideslipEkf
from estimators.sideslip_ekf.layout import BIAS_Y, MISALIGNED, PITCH, ROLL
from twin.streams import Streams
from twin.testing import check_estimator


def estimated(without=(), **how):
    """Slides told since the pause, the true ones, and the table."""
    streams, cg_m, rear_m, begin_s = slides(**how)
    own = SideslipEkf()
    seen = {n: t for n, t in streams.tables.items() if n not in without}
    _, table = own.run(own.init(SETUP), Streams(seen))
    late = table["epoch_ns"] >= begin_s * 1e9
    told = [table[c][late][-1] - table[c][late][0] for c in ("sideslip_m", "sideslip_rear_m")]
    return told, (cg_m, rear_m), table["sideslip_sd_m"][-1], table


def test_what_holds_for_every_estimator():
    check_estimator(SideslipEkf())


@pytest.mark.parametrize("masked", [False, True])
def test_the_slide_is_told_to_a_per_cent_open_or_masked(masked):
    errors, ratios = [], []
    for seed in range(3):
        told, true, sd, _ = estimated(seed=seed, masked=masked)
        errors.append(np.subtract(told, true) / true)
        ratios.append((told[0] - true[0]) / sd)
    assert np.abs(errors).max() < 0.015
    assert np.mean(np.square(ratios)) < 3.8  # chi-square, three degrees of freedom, 99 %


def test_its_angle_is_that_of_the_centre_of_gravity():
    *_, table = estimated(masked=True)
    assert table["sideslip_rad"][-1] == pytest.approx(np.arctan2(-0.037, 1.0), abs=2e-3)
    assert table["sideslip_rear_rad"][-1] == pytest.approx(np.arctan2(-0.03, 1.0), abs=2e-3)
    assert table["v_y_mps"][-1] == pytest.approx(-0.037, abs=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_without_a_usable_frame_it_goes_on_and_says_how_badly(seed):
    told, true, sd, _ = estimated(seed=seed, blind=True)
    assert abs(told[0] - true[0]) < 3 * sd
    assert 0.003 < sd < 0.1


def test_without_a_heading_course_gyro_and_the_law_of_sliding_tell_it():
    streams, _, _, begin_s = slides(blind=True)
    gnss = {n: c for n, c in streams["gnss"].items() if n != "heading_rad"}
    own = SideslipEkf()
    _, table = own.run(own.init(SETUP), Streams({**streams.tables, "gnss": gnss}))
    late = table["epoch_ns"] >= begin_s * 1e9
    angle, sd = table["sideslip_rear_rad"][late][-1], table["sideslip_sd_rad"][late][-1]
    assert abs(angle - np.arctan2(-0.03, 1.0)) < 3 * sd
    assert sd < 0.03


def test_with_neither_camera_nor_gnss_the_slide_is_unknown():
    streams, *_ = slides(blind=True)
    own = SideslipEkf()
    less = {n: t for n, t in streams.tables.items() if n != "gnss"}
    _, table = own.run(own.init(SETUP), Streams(less))
    assert np.isnan(table["sideslip_m"]).all()
    assert np.isnan(table["sideslip_rad"]).all()


def test_one_stretch_alone_does_not_tell_askew_antennas_from_a_slope():
    """On a slope of a degree nothing but its direction against the body tells the two."""
    streams, *_, begin_s = slides(blind=True)
    alone = {
        name: {c: v[t["epoch_ns"] >= begin_s * 1e9] for c, v in t.items()}
        for name, t in streams.tables.items()
    }
    own = SideslipEkf()
    state, _ = own.run(own.init(SETUP), Streams(alone))
    both, _ = own.run(own.init(SETUP), streams)
    sd = [float(np.sqrt(s.memory["p"][0][MISALIGNED, MISALIGNED])) for s in (state, both)]
    assert sd[0] > np.radians(0.15)
    assert sd[1] < np.radians(0.1)


@pytest.mark.parametrize("seed", range(3))
def test_antennas_askew_by_a_degree_are_found_there_and_back(seed):
    streams, *_, begin_s = slides(seed=seed, blind=True)
    before = {
        name: {c: v[t["epoch_ns"] < (begin_s - 1) * 1e9] for c, v in t.items()}
        for name, t in streams.tables.items()
    }
    heading = before["gnss"]["heading_rad"]
    own = SideslipEkf()
    found = []
    for askew in (0.0, np.radians(1.0)):
        turned = Streams({**before, "gnss": before["gnss"] | {"heading_rad": heading + askew}})
        state, _ = own.run(own.init(SETUP), turned)
        found.append(state.memory["x"][0][MISALIGNED])
    assert found[1] - found[0] == pytest.approx(np.radians(1.0), abs=np.radians(0.1))


@pytest.mark.parametrize("lean_rad", [0.005, 0.02])
def test_ground_that_is_not_quite_level_is_told_from_a_bias_there_and_back(lean_rad):
    """Half a degree changes its sign on the way back; what leans more is no level ground."""
    streams, *_, begin_s = slides(blind=True)
    before = {
        name: {c: v[t["epoch_ns"] < (begin_s - 1) * 1e9] for c, v in t.items()}
        for name, t in streams.tables.items()
    }
    out = before["imu"]["epoch_ns"] < (LEG_S + 1) * 1e9
    leans = 9.81 * lean_rad * np.where(out, 1.0, -1.0)
    own = SideslipEkf()
    found = []
    for more in (0.0, leans):
        imu = before["imu"] | {"accel_y_mps2": before["imu"]["accel_y_mps2"] + more}
        state, _ = own.run(own.init(SETUP), Streams({**before, "imu": imu}))
        memory = state.memory[0]
        found.append((memory["x"][BIAS_Y], memory["x"][ROLL], memory["level"]))
    (bias, _, _), (moved, roll, level) = found
    assert level == (lean_rad < 0.01)
    if level:
        assert moved == pytest.approx(bias, abs=0.005)
        assert roll == pytest.approx(-lean_rad, abs=5e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_steep_slope_is_felt_from_the_first_sample(seed):
    told, true, sd, _ = estimated(seed=seed, slope_deg=18.0)
    assert abs(told[0] - true[0]) < 3 * sd
    assert told[0] == pytest.approx(true[0], rel=0.01)


def test_a_first_position_does_not_tell_how_the_body_leans():
    """Before a force is felt the antenna's place tells the axle's; after it the arm leans, too."""
    gnss_setup = dataclasses.replace(SETUP.gnss, lever_arm_m=(0.4, 0.28, 3.0), position_sd_m=0.01)
    setup = dataclasses.replace(SETUP, gnss=gnss_setup)
    streams, *_ = slides(blind=True)
    tables = {
        name: {column: values[table["epoch_ns"] < 1e9] for column, values in table.items()}
        for name, table in streams.tables.items()
    }
    tables["imu"] = {c: v[tables["imu"]["epoch_ns"] > 0.3e9] for c, v in tables["imu"].items()}
    time_s = tables["gnss"]["epoch_ns"] * 1e-9
    tables["gnss"] |= {"east_m": 0.4 + time_s, "north_m": np.full(len(time_s), 0.28)}
    own = SideslipEkf()
    state, _ = own.run(own.init(setup), Streams(tables))
    sd = np.degrees(np.sqrt(state.memory["p"][0][PITCH, PITCH]))
    assert sd > 0.4  # that of the accelerometer's bias is 0.6


def test_frames_that_are_missing_for_a_while_are_got_over():
    streams, cg_m, _, begin_s = slides()
    camera = {name: column.copy() for name, column in streams["camera"].items()}
    hole = (camera["epoch_ns"] > (begin_s + 3) * 1e9) & (camera["epoch_ns"] < (begin_s + 4) * 1e9)
    camera["used"][hole] = False
    camera["v_y_mps"][hole] = np.nan
    own = SideslipEkf()
    _, table = own.run(own.init(SETUP), Streams({**streams.tables, "camera": camera}))
    late = table["epoch_ns"] >= begin_s * 1e9
    told = table["sideslip_m"][late][-1] - table["sideslip_m"][late][0]
    assert told == pytest.approx(cg_m, rel=0.03)


def test_innovations_are_as_large_as_their_variances_say():
    """The first of each, before a heading and a speed are known, is left out."""
    streams, *_ = slides(blind=True)
    found = SideslipEkf().innovations(SETUP, streams)
    assert set(found["sensor"]) == {"gnss"}
    assert len(found["epoch_ns"]) > 2.9 * len(streams["gnss"]["epoch_ns"]) - 10
    square = found["innovation"] ** 2 / found["variance"]
    assert 0.8 < np.mean(square[100:]) < 1.2


def test_chunks_of_a_camera_stream_change_no_bit():
    streams, *_ = slides()
    part = streams.samples(0, 900)
    own = SideslipEkf()
    _, whole = own.run(own.init(SETUP), part)
    state, tables = own.init(SETUP), []
    for chunk in part.chunks(37):
        state, table = own.run(state, chunk)
        tables.append(table)
    for name, column in whole.items():
        np.testing.assert_array_equal(np.concatenate([t[name] for t in tables]), column, name)
