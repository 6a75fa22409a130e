"""The paper's chains on a slide with a closed form; the slope rises to the north."""

import numpy as np
import pytest
from slides import SETUP, slides

from estimators.cross_slope import CameraChain, GnssChain, WeightedFusion
from twin.streams import Streams


def run_of(masked=False, **how):
    """The slide alone, without the calibration; with satellites and quality of a masking."""
    streams, cg_m, _, begin_s = slides(seed=2, masked=False, **how)
    tables = {}
    for name, table in streams.tables.items():
        rows = table["epoch_ns"] >= begin_s * 1e9
        tables[name] = {column: values[rows] for column, values in table.items()}
    count = len(tables["gnss"]["epoch_ns"])
    hidden = np.arange(count) > 20 if masked else np.zeros(count, bool)
    tables["gnss"] |= {
        "quality": np.where(hidden, 5, 4),
        "satellites_main": np.where(hidden, 6, 28),
        "heading_rad": np.where(hidden, np.nan, tables["gnss"]["heading_rad"]),
    }
    return Streams(tables), cg_m


def total(chain, streams):
    _, table = chain.run(chain.init(SETUP), streams)
    return table["sideslip_m"][-1]


def test_the_printed_chain_yields_zero_whatever_slides():
    streams, cg_m = run_of()
    assert abs(total(GnssChain(slope_deg=9.0, printed=True), streams)) < 1e-12
    assert abs(cg_m) > 0.2


@pytest.mark.parametrize("masked", [False, True])
def test_put_right_it_slides_with_the_biases_it_does_not_know(masked):
    streams, cg_m = run_of(masked)
    told = total(GnssChain(slope_deg=9.0), streams)
    assert abs(told - cg_m) < 8.0 * np.radians(0.7) + 0.03
    assert abs(told) > 0.1


def test_w_on_both_q_and_r_changes_nothing_and_on_r_alone_does():
    streams, _ = run_of(masked=True)
    plain, both, sensor = (
        total(WeightedFusion(slope_deg=9.0, weight=w), streams) for w in ("none", "both", "sensor")
    )
    assert both == pytest.approx(plain, abs=2e-4)
    assert abs(sensor - plain) > 5 * abs(both - plain)


def test_with_a_fix_there_is_no_fusion():
    streams, _ = run_of()
    chain = total(GnssChain(slope_deg=9.0), streams)
    assert total(WeightedFusion(slope_deg=9.0), streams) == chain


def test_the_camera_alone_has_its_mounting_in_the_total():
    streams, cg_m = run_of()
    yaw_rad = np.radians(np.random.default_rng(2).standard_normal(2)[1])
    assert total(CameraChain(), streams) == pytest.approx(cg_m - 8.0 * yaw_rad, abs=0.02)
