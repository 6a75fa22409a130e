"""Means, intervals and paired differences over seeds."""

import numpy as np
import pytest
from matplotlib.text import Text

from twin.io import result_rows as rows_file
from twin.report.printed import write_png
from twin.studies import figures, groups, quantities, rows, summary

RNG = np.random.default_rng(0)


def row(seed, estimator, rmse, error=None, scenario="s", friction=0.6):
    return {
        "scenario": scenario, "seed": seed, "soil.friction": friction, "estimator": estimator,
        "error": error, "ended": "course driven", "slip.rmse": rmse, "sideslip_m.true_m": None,
    }  # fmt: skip


def test_groups_differ_in_all_but_the_seed():
    table = [row(s, e, 1.0, friction=f) for f in (0.6, 0.8) for s in (0, 1) for e in ("a", "b")]
    found = groups(table, ["soil.friction"])
    assert [(g.setting, g.estimator) for g in found] == [
        ("s, soil.friction = 0.6", "a"), ("s, soil.friction = 0.6", "b"),
        ("s, soil.friction = 0.8", "a"), ("s, soil.friction = 0.8", "b"),
    ]  # fmt: skip
    assert all(len(g.rows) == 2 for g in found)
    assert quantities(table, ["soil.friction"]) == ["slip.rmse"]


def test_failed_runs_are_counted_and_left_out_of_the_mean():
    table = [row(0, "a", 1.0), row(1, "a", 3.0), row(2, "a", None, "Diverged"), row(3, "a", np.nan)]
    found = {r["quantity"]: r for r in rows(groups(table, []), ["slip.rmse"])}
    assert (found["runs"]["ours"], found["failed"]["ours"]) == (4, 1)
    assert found["slip.rmse"]["ours"] == 2.0
    half = 12.706 * np.sqrt(2.0) / np.sqrt(2.0)  # t(0.975, 1)
    assert found["slip.rmse"]["high"] == pytest.approx(2.0 + half, rel=1e-4)


def test_differences_are_paired_by_seed():
    """A spread that both share is none of their difference."""
    common = RNG.normal(0.0, 5.0, 8)
    table = [row(s, "a", 1.0 + common[s]) for s in range(8)]
    table += [row(s, "b", common[s]) for s in range(1, 8)]
    found = {(r["case"], r["quantity"]): r for r in rows(groups(table, []), ["slip.rmse"], "b")}
    difference = found["s, a", "slip.rmse less that of b"]
    assert difference["ours"] == pytest.approx(1.0)
    assert difference["high"] - difference["low"] < 1e-9
    assert ("s, b", "slip.rmse less that of b") not in found
    rows_file.to_json(found.values())


@pytest.mark.parametrize(
    ("quantity", "unit"),
    [
        ("slip.rmse", "1"), ("sideslip_m.true_m", "m"), ("sideslip_m.rel_err", "1"),
        ("sideslip_angle_rad.rmse", "rad"), ("speed_mps.bias", "m/s"), ("speed_mps.nees_mean", "1"),
        ("truth.mean_speed_kmh", "km/h"), ("truth.draft_mean_kn", "kN"), ("truth.slip_sd", "1"),
    ],
)  # fmt: skip
def test_units_are_read_off_the_name(quantity, unit):
    table = [row(0, "a", 1.0) | {quantity: 2.0}]
    assert rows(groups(table, []), [quantity])[-1]["unit"] == unit


@pytest.mark.parametrize("swept", [[], ["soil.friction"]])
def test_a_figure_of_what_was_measured_and_none_of_what_was_not(tmp_path, swept):
    table = [row(s, e, 0.1 * s, friction=f) for s in range(3) for e in "ab" for f in (0.6, 0.8)]
    found = groups(table, swept)
    drawn = figures.picture(found, "slip.rmse", figures.Drawn("RMSE [%]", 100.0))
    assert drawn is not None
    write_png(drawn, tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert figures.picture(found, "sideslip_m.true_m", figures.Drawn("m", 1.0)) is None


@pytest.mark.parametrize("swept", [[], ["soil.friction"]])
def test_bars_end_at_zero_labels_are_whole_and_the_bound_is_drawn(swept):
    long = "a-scenario-of-a-rather-long-name-that-must-be-whole-on-its-axis"
    rmse = (0.001, 0.0, 0.05)  # the interval about their mean reaches below zero
    table = [
        row(s, "a", rmse[s], scenario=long, friction=f) | {"bound.slip_causal": 0.004}
        for s in range(3)
        for f in (0.6, 0.8)
    ]
    found = groups(table, swept)
    assert summary.mean_of(found[0], "slip.rmse").low == 0.0
    assert summary.mean_of(found[0], "slip.bias").n == 0
    how = figures.Drawn("RMSE of slip [%]", 100.0, "bound.slip_causal")
    drawn = figures.picture(found, "slip.rmse", how)
    figure = drawn.figure()
    figure.draw_without_rendering()
    axes = figure.axes[0]
    bars = [s for c in axes.collections for s in c.get_segments() if c.get_label() != "bound"]
    side = 1 if swept else 0
    assert min(np.min(bar[:, side]) for bar in bars) >= 0.0
    assert "bound" in axes.get_legend_handles_labels()[1]
    texts = [t for t in figure.findobj(Text) if t.get_text() and t.get_visible()]
    assert any(long in t.get_text().replace("\n", "") for t in texts)
    seen, size = figure.get_tightbbox(), figure.get_size_inches()
    assert seen.min.min() >= 0.0
    assert (seen.max <= size).all()
