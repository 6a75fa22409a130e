import numpy as np
import pytest
from slides import SETUP, slides

from estimators.sideslip_ekf import SideslipEkf
from twin.streams import Streams


def estimated(**how):
    """Slides told since the pause, their sd, and the true ones."""
    streams, cg_m, rear_m, begin_s = slides(**how)
    own = SideslipEkf()
    _, table = own.run(own.init(SETUP), streams)
    late = table["epoch_ns"] >= begin_s * 1e9
    told = [table[c][late][-1] - table[c][late][0] for c in ("sideslip_m", "sideslip_rear_m")]
    return told, (cg_m, rear_m), table["sideslip_sd_m"][-1], table


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


def test_without_a_usable_frame_gnss_goes_on_alone_and_says_how_badly():
    told, true, sd, _ = estimated(blind=True)
    assert abs(told[0] - true[0]) < 3 * sd
    assert 0.01 < sd < 0.1


def test_with_neither_the_slide_is_unknown():
    streams, *_ = slides(blind=True)
    own = SideslipEkf()
    less = {n: t for n, t in streams.tables.items() if n != "gnss"}
    _, table = own.run(own.init(SETUP), type(streams)(less))
    assert np.isnan(table["sideslip_m"]).all()
    assert np.isnan(table["sideslip_rad"]).all()


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


def test_slip_in_a_masking_is_the_cameras():
    *_, table = estimated(masked=True)
    late = table["epoch_ns"] > 28e9  # the slide begins at 26 s
    assert np.abs(table["slip"][late]).max() < 0.03
    assert np.abs(table["speed_mps"][late] - 1.0).max() < 0.02
    assert np.mean(np.abs(table["slip"][late]) < 2 * table["slip_sd"][late]) > 0.9
