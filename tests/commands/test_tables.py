"""Tables as wide as the terminal: columns are left out, nothing is cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from twin.commands import bench, compare_controllers, measured, score_table, study
from twin.commands import list as names
from twin.commands.tables import Column, fit, print_table
from twin.io.result_rows import row
from twin.scores.table import HEADERS
from twin.studies import groups

ENTRY = {
    "slip": {"rmse": 0.012, "mae": 0.0101, "max": 1.2345, "bias": -0.0012, "coverage_2sd": 0.954},
    "sideslip_angle_rad": {"rmse": 0.0021},
    "sideslip_m": {"est_m": 12.345, "true_m": -12.311, "rel_err": 0.051},
}
SCORES = {
    "scenario": "plough-25cm", "seed": 1, "window_s": [10.0, 90.0],
    "truth": {"mean_speed_kmh": 5.44, "slip_mean": 0.151, "draft_mean_kn": 31.2},
    "estimators": dict.fromkeys(("ratio", "four-state-printed"), ENTRY),
    "bound": {"slip_causal": 0.0011, "slip_offline": 0.0007, "sideslip_causal_rad": 0.001},
}  # fmt: skip
ROWS = [
    row("physics step, ploughing, sensors off", "time with the soil law", 4.512, "us", high=10.25),
    row("time", "ratio", 0.4444, "1", low=0.12, high=0.8, published=0.1234, reference=0.5151),
]
CURVE = {name: np.linspace(-1.2345, 1234.5, 4) for name in ("load_n", *"abcdefghijkl", "slip")}
STUDY = [
    {
        "scenario": "plough-25cm", "seed": seed, "soil.friction": 0.6, "estimator": estimator,
        "error": None, "slip.rmse": 0.0123 * (seed + 1), "slip.mae": 0.01, "slip.max": 0.1,
        "slip.bias": -0.01, "sideslip_angle_rad.rmse": 0.001 * seed, "sideslip_m.rel_err": 0.5,
    }
    for seed in range(3)
    for estimator in ("ratio", "four-state-printed")
]  # fmt: skip
COMPARED = [
    {**row(case, quantity, 0.123, "1"), "low": 0.1, "high": 0.2}
    for case in ("pi", "a-saved-policy")
    for quantity in ("reward", "work_done", "fuel_used", "slip_error", "speed", "depth_kept")
]
PRINTED: dict[str, Callable[[], Any]] = {
    "scores": lambda: score_table.print_scores(SCORES),
    "rows": lambda: bench.print_rows(ROWS),
    "rig": lambda: measured.print_columns(CURVE),
    "study": lambda: study.print_means(groups(STUDY, ["soil.friction"]), "ratio"),
    "compared": lambda: compare_controllers.print_comparison(COMPARED, ["pi", "a-saved-policy"], 9),
    "list": lambda: names.main([]),
}


@pytest.fixture
def printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    def at(what: str, columns: int | None) -> str:
        if columns is None:
            monkeypatch.delenv("COLUMNS", raising=False)
        else:
            monkeypatch.setenv("COLUMNS", str(columns))
        PRINTED[what]()
        return capsys.readouterr().out

    return at


@pytest.mark.parametrize("what", PRINTED)
@pytest.mark.parametrize("columns", [60, 80])
def test_what_is_printed_fits_the_columns_and_nothing_is_cut(
    printed: Callable[..., str], what: str, columns: int
) -> None:
    text, whole = printed(what, columns), printed(what, None)
    assert max(map(len, text.splitlines())) <= columns
    assert "…" not in text
    table = [word for word in text.partition("left out")[0].split() if set(word) != {"─"}]
    assert set(table) <= set(whole.split())


def test_a_wide_terminal_and_a_file_have_every_column(printed: Callable[..., str]) -> None:
    for columns in (200, None):
        text = printed("scores", columns)
        assert all(heading in text for heading in HEADERS)
        assert "left out" not in text


def test_what_is_left_out_is_said(printed: Callable[..., str]) -> None:
    last = printed("scores", 80).splitlines()[-1]
    assert last == "left out to fit 80 columns: MAE [%], max [%]"


def test_the_least_important_is_left_out_first_and_rank_0_never() -> None:
    columns = [
        Column(heading=name, cells=["1.234567"], rank=rank)
        for name, rank in (("a", 0), ("b", 2), ("c", 1), ("d", 0))
    ]
    for width, kept in ((38, "abcd"), (37, "acd"), (28, "acd"), (27, "ad"), (3, "ad")):
        found, widths = fit(columns, width)
        assert "".join(column.heading for column in found) == kept
        assert widths == [8] * len(kept)


def test_text_breaks_between_words_before_a_column_is_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    about = "a case of many words that does not fit beside a number"
    print_table(
        [
            Column(heading="case", cells=[about], text=True),
            Column(heading="ours", cells=["12.3456"], rank=1),
        ]
    )
    out = capsys.readouterr().out
    assert "12.3456" in out
    assert set(about.split()) <= set(out.split())
    assert max(map(len, out.splitlines())) <= 40
