"""The report of a recorded drive."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.synthetic_log import ESTIMATE, RUN, SCORES, SETUP, STREAMS, job
from twin.io.run_folder import Record
from twin.logs.activity import activity
from twin.logs.summary import PULLS, highest_slip
from twin.logs.timeline import timeline
from twin.pipeline.drive import findings
from twin.report import log_figures, log_maps
from twin.report.clock import time_axis
from twin.report.page import drawings, page
from twin.report.printed import write_print

PAGE = page(RUN, SCORES)


def axes_of(drawing):
    with mpl.rc_context({"backend": "svg"}):
        figure = drawing.figure()
        figure.draw_without_rendering()
    return figure.axes


def test_the_page_says_where_slip_was_high_what_an_hectare_took_and_what_was_assumed() -> None:
    assert "L/ha with the turns" in PAGE
    high = PAGE[PAGE.index("Where slip was highest") :]
    assert re.search(r"<td>1</td><td>0:03:(19|20|21)</td><td>(5|6)\d</td><td>20.0</td>", high)
    end = PAGE[PAGE.index("What was assumed") :]
    assert "engine load" not in end
    assert "with the draft above 10 kN" in end
    assert "gnss: &lt;gap&gt; of 5 s" in end
    assert PAGE.index("What was assumed") > PAGE.rindex("<svg")
    assert "a &lt;tractor&gt;" in PAGE


def test_without_a_width_the_page_says_that_litres_cannot_be_told() -> None:
    found = findings(STREAMS, RUN.estimates, None)
    assert "Litres per hectare cannot be told" in page(RUN, {**SCORES, **found})


def test_the_figures_of_a_log() -> None:
    figures = re.findall(r"<svg.*?</svg>", PAGE, re.DOTALL)
    titles = [ElementTree.fromstring(f).attrib["aria-label"] for f in figures]
    assert titles == [
        "Slip of the driven axle over time", "Slip on the field", "Path by activity",
        "Slip against draft", "Distribution of slip", "Engine and fuel over time",
        "Speeds over time",
    ]  # fmt: skip


def test_time_is_h_mm_on_every_axis_of_a_long_log() -> None:
    shown = drawings(RUN, SCORES)
    for name in ("slip", "engine-and-fuel", "speeds"):
        lowest = axes_of(shown[name])[-1]
        assert lowest.get_xlabel() == "time since start [h:mm]"
        assert re.fullmatch(r"\d:\d\d", lowest.get_xticklabels()[1].get_text())


@pytest.mark.parametrize("span_s", [600.0, 3600.0, 12_000.0, 90_000.0, 9e5])
def test_no_more_than_a_few_ticks(span_s: float) -> None:
    axes = Figure().add_subplot()
    axes.set_xlim(0.0, span_s)
    time_axis(axes, span_s)
    assert 3 <= len(axes.get_xticks()) <= 11


def test_maps_have_one_scale() -> None:
    shown = drawings(RUN, SCORES)
    for name in ("slip-on-the-field", "path"):
        axes = axes_of(shown[name])[0]
        box = axes.get_window_extent()
        (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
        assert box.width / (east - west) == pytest.approx(box.height / (north - south), rel=0.01)


def test_the_map_shows_the_field_and_not_the_road() -> None:
    rows = timeline(STREAMS, ESTIMATE)
    done = activity(rows)
    axes = axes_of(log_maps.slip_map(rows, done, highest_slip(rows, done)))[0]
    work_east = rows["east_m"][done[0]]
    west, east = axes.get_xlim()
    assert west < work_east.min() + 20.0
    assert east > work_east.max() - 20.0
    numbers = [text.get_text() for text in axes.texts]
    assert numbers == ["1", "2", "3", "4", "5"]


def lines(axes):
    return [np.asarray(line.get_ydata(), float) for line in axes.get_lines()]


def test_no_line_crosses_a_gap_of_a_map_or_over_time() -> None:
    streams, estimate, _ = job(passes=10)
    rows = timeline(streams, estimate)
    keep = (np.arange(len(rows["epoch_ns"])) < 300) | (np.arange(len(rows["epoch_ns"])) > 500)
    cut = {name: column[keep] for name, column in rows.items()}
    done = activity(cut)
    path = axes_of(log_maps.activity_map(cut, done))[0]
    for line in path.get_lines():
        x, y = (np.asarray(v, float) for v in line.get_data())
        if line.get_linestyle() != "None":
            assert np.nanmax(np.hypot(np.diff(x), np.diff(y)), initial=0.0) < 20.0
    table = {name: column[keep] for name, column in estimate.items()}
    drawn = axes_of(log_figures.slip(cut, done, {"ratio": table}, 0, None))[0]
    for line in drawn.get_lines():
        x, y = (np.asarray(v, float) for v in line.get_data())
        inside = (x > 305.0) & (x < 495.0)
        assert not np.isfinite(y[inside]).any()
        known = np.flatnonzero(np.isfinite(y))
        crossing = known[:-1][(x[known[:-1]] <= 305.0) & (x[known[1:]] >= 495.0)]
        assert len(crossing) == 1
        assert np.isnan(y[crossing[0] + 1 : known[known > crossing[0]][0]]).any()


def test_bins_of_equal_count_follow_the_slip() -> None:
    at = np.linspace(0.0, 20.0, 600)
    middle, level, below, above = log_figures.binned(at, 0.5 * at)
    np.testing.assert_allclose(level, 0.5 * middle, rtol=1e-6)
    assert np.all(below < level)
    assert np.all(above > level)


def test_blocks_of_a_long_log_keep_its_holes() -> None:
    time_s = np.arange(20_000.0)
    values = np.ones(20_000)
    values[5000:9000] = np.nan
    middle, level, *_ = log_figures.blocks(time_s, values, 20_000.0)
    np.testing.assert_array_equal(np.isnan(level), (middle > 5000.0) & (middle < 9000.0))


def test_slip_against_whatever_pull_there_is() -> None:
    for pull in ("draft_pin_n", "engine_load"):
        streams, estimate, _ = job(pull=pull)
        rows = timeline(streams, estimate)
        rows[pull] = rows[pull] * (1.0 + 0.05 * np.sin(np.arange(len(rows[pull]))))
        known = {p.column for p in PULLS if log_figures.slip_against(rows, activity(rows), p)}
        assert known == {pull}


def test_a_log_of_almost_nothing_has_a_page() -> None:
    n = 3
    epoch_ns = np.arange(n) * 10**9
    gnss = {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns, "east_m": np.full(n, np.nan)}
    streams = type(STREAMS)({"gnss": gnss})
    run = Record(setup=SETUP, streams=streams, estimates={})
    text = page(run, {"scenario": "log", "slip": {}, **findings(streams, {}, None)})
    assert "<table" in text


def test_its_figures_print(tmp_path: Path) -> None:
    names = write_print(drawings(RUN, SCORES), tmp_path)
    assert "slip-on-the-field.pdf" in names


def test_the_page_is_light() -> None:
    assert len(PAGE.encode()) < 1_500_000
