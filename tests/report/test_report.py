from __future__ import annotations

import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.synthetic_run import synthetic_run
from twin import report
from twin.io.result_rows import row
from twin.io.run_folder import Record
from twin.report import draw, errors, figures
from twin.report.page import drawings, flat, page
from twin.report.palette import looks
from twin.report.printed import WIDTHS_MM, write_print
from twin.report.rows import place_of, write_checks, write_intervals
from twin.reproduce import story
from twin.scores import scores

RUN = synthetic_run(duration_s=20.0)
SCORES = scores.score(RUN.truth, RUN.estimates, scenario="stub", seed=1)
PAGE = page(RUN, SCORES)
MEASURED = [
    row("coasting", "deceleration", 0.64, "m/s2", low=0.63, high=0.66, reference=0.65),
    row("<slope>", "creep", 0.4, "m", high=0.1),
]
SPREAD = [
    {**row(case, "reward", value, "1"), "low": value - 0.1, "high": value + 0.2}
    for case, value in (("pi", 0.5), ("constant", 0.4))
]


def written(write: Callable[..., None], *args: Any) -> str:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        write(file, *args)
        return file.read_text(encoding="utf-8")


def shown(drawing: draw.Drawing | None) -> str:
    assert drawing is not None
    return drawing.svg()


CHECKS = written(write_checks, "Checks", "About.", {"Analytic": MEASURED}, "twin validate")
MEANS = written(write_intervals, "Means", "About.", SPREAD, "twin compare-controllers")


def test_a_page_of_checks_puts_what_fails_first() -> None:
    assert "2 rows, 1 pass, 1 fail" in CHECKS
    failing = CHECKS[CHECKS.index("Failed checks") : CHECKS.index("<figure>")]
    assert "&lt;slope&gt;" in failing
    assert "coasting" not in failing
    assert "0.63 to 0.66" in CHECKS
    assert "at most 0.1" in failing


def test_a_page_of_means_gives_half_the_interval() -> None:
    assert "0.500 ± 0.150" in MEANS
    assert 'aria-label="reward"' in MEANS


@pytest.mark.parametrize(
    ("ours", "low", "high", "place"),
    [(2.0, 1.0, 3.0, 0.0), (3.5, 1.0, 3.0, 1.5), (0.0, None, 1.0, -1.0), (1.2, None, 1.0, 1.4),
     (5.0, 1.0, None, 1.0), (0.9, 1.0, None, -1.2)],
)  # fmt: skip
def test_a_dot_is_in_the_grey_just_where_its_row_passes(
    ours: float, low: float | None, high: float | None, place: float
) -> None:
    made = row("c", "q", ours, "1", low=low, high=high)
    assert place_of(made) == pytest.approx(place)
    assert (abs(place) <= 1.0) is made["passed"]


def test_an_experiment_without_figures_of_its_own_has_those_of_its_rows() -> None:
    made = [
        row("15 cm", "speed", 6.2, "km/h", low=6.3, high=6.6, published=6.48),
        row("15 cm", "slip <sd>", 0.00012, "1"),
    ]
    text = story.page("paper", made, story.Story(paragraphs=("What it is.",)), "twin reproduce x")
    titles = re.findall(r'aria-label="([^"]*)"', text)
    assert titles == ["Ours over published", "Rows within their tolerance"]
    assert "15 cm, speed" in text
    assert "slip &lt;sd&gt;" in text
    assert all(cell in text for cell in (">0.0001<", ">6.2<", ">km/h<", "twin reproduce x"))
    assert "at least 6.3 and at most 6.6: not reached" in text


def test_power_that_goes_adds_up_in_its_figure() -> None:
    n = len(RUN.truth["epoch_ns"])  # type: ignore[index]
    parts = {"engine": 60e3, "drawbar": 36e3, "slip_long": 24e3}
    truth = {**(RUN.truth or {}), **{f"power_{k}_w": np.full(n, v) for k, v in parts.items()}}
    drawn = shown(figures.power(truth, (6.0, 20.0)))
    assert all(text in drawn for text in ("36.0 kW, 60%", "24.0 kW, 40%", "of 60.0 kW"))
    falling = {**truth, "potential_j": -15e3 * (truth["epoch_ns"] * 1e-9)}
    drawn = shown(figures.power(falling, (6.0, 20.0)))
    assert "of 75.0 kW: engine 60.0, height and speed lost 15.0" in drawn
    assert "36.0 kW, 48%" in drawn


def test_bounds_are_lines_among_the_errors() -> None:
    given: Any = (RUN.truth, RUN.estimates, (6.0, 20.0))
    bound = {"slip_causal": 0.002, "slip_offline": 0.001, "sideslip_causal_rad": 0.003}
    slip = shown(errors.slip_error(*given, bound))
    assert all(f"bound, {when}" in slip for when in ("causal", "offline"))
    angle = shown(errors.angle_error(*given, bound))
    assert "bound, causal" in angle
    assert "bound, offline" not in angle
    assert "bound" not in shown(errors.slip_error(*given, {}))


def test_no_line_is_drawn_across_a_gap_of_time() -> None:
    epoch_ns = np.delete(np.arange(2000, dtype=np.int64) * 10_000_000, slice(800, 1200))
    table = {
        "epoch_ns": epoch_ns,
        "slip": np.ones(len(epoch_ns)),
        "flags": np.ones(len(epoch_ns), int),
    }
    for most in (100, 700, 5000):
        rows = draw.thinned(table, most)
        assert np.isnan(rows["slip"]).sum() == 1
        assert len(rows["flags"]) == len(rows["slip"]) == len(rows["epoch_ns"])
        apart = np.diff(rows["epoch_ns"][np.isfinite(rows["slip"])]) > 3e9
        assert apart.sum() == 1
    whole = {name: column[:700] for name, column in table.items()}
    assert np.isfinite(draw.thinned(whole)["slip"]).all()


def test_an_estimator_has_one_look_whatever_stands_beside_it() -> None:
    alone = looks(["four-state"])["four-state"]
    assert looks(["mine", "slip-ekf", "four-state", "ratio"])["four-state"] == alone
    many = looks([f"mine{i}" for i in range(20)] + ["ratio", "four-state"])
    assert len(set(many.values())) == 22


def test_every_figure_of_a_report_has_a_file_at_print_size(tmp_path: Path) -> None:
    drawn = drawings(RUN, SCORES)
    names = write_print(drawn, tmp_path / "printed")
    assert names == sorted(f"{name}.{kind}" for name in drawn for kind in ("pdf", "svg"))
    for name, each in drawn.items():
        root = ElementTree.parse(tmp_path / "printed" / f"{name}.svg").getroot()
        width_mm = float(root.get("width", "").removesuffix("pt")) * 25.4 / 72.0
        assert width_mm == pytest.approx(WIDTHS_MM[each.columns], abs=0.1)


def test_errors_in_blocks_are_those_of_the_scores() -> None:
    assert RUN.truth is not None
    table, window = RUN.estimates["ekf4"], (6.0, 16.0)
    error = errors.error_of(RUN.truth, table, "slip")
    assert error is not None
    _, means = errors.block_means(table, error**2, window)
    table_of = scores.score(RUN.truth, RUN.estimates, scenario="stub", seed=1, window=window)
    assert np.sqrt(np.mean(means)) == pytest.approx(
        table_of["estimators"]["ekf4"]["slip"]["rmse"], rel=0.02
    )


class _Balance(HTMLParser):
    void = frozenset({"meta", "link", "br"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in self.void:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_every_element_is_closed() -> None:
    for text in (PAGE, CHECKS, MEANS):
        checker = _Balance()
        checker.feed(text)
        checker.close()
        assert checker.open == []


def test_nothing_is_fetched() -> None:
    without_names = (PAGE + CHECKS + MEANS).replace(
        "http://www.w3.org/", ""
    )  # names of namespaces, not addresses
    assert not re.findall(
        r"""(?:src|href)=["'](?!data:|#)[^"']*|url\((?!#)|https?://""", without_names
    )


def test_all_figures_are_there_and_are_whole() -> None:
    figures = re.findall(r"<svg.*?</svg>", PAGE, re.DOTALL)
    titles = [ElementTree.fromstring(f).attrib["aria-label"] for f in figures]
    assert titles == [
        "Slip of the driven axle over time",
        "RMS of the slip error over time",
        "Distribution of the slip error",
        "Sideslip at the centre of gravity over time",
        "RMS of the error of the sideslip angle over time",
        "Path, east and north",
        "Draft and depth of ploughing over time",
        "Speeds over time",
        "Where power goes",
        "Squared slip error over reported variance",
    ]


def test_the_numbers_are_those_of_the_scores(tmp_path: Path) -> None:
    report.write(RUN, SCORES, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{100 * SCORES['estimators']['ekf4']['slip']['rmse']:.3f}" in text
    assert "twin run stub --seed 1" in text


def test_the_page_is_light() -> None:
    assert len(page(synthetic_run(duration_s=150.0), SCORES).encode()) < 2_000_000


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", 'a"b'])
def test_names_are_escaped(name: str) -> None:
    text = page(RUN, {**SCORES, "scenario": name})
    assert name not in text.replace('class="figure"', "")


def test_a_log_without_truth_has_a_page() -> None:
    log = Record(setup=RUN.setup, streams=RUN.streams, estimates=RUN.estimates)
    slip = {"ekf4": {"median": 0.07, "p05": 0.03, "p95": 0.1, "n": 9}}
    text = page(log, {"scenario": "log", "estimators": {}, "slip": slip, "notes": ["a <gap>"]})
    assert ">7.00<" in text
    assert "a &lt;gap&gt;" in text


def test_nested_values_get_dotted_names() -> None:
    assert flat({"a": {"b": 0.25}, "c": None}) == [("a.b", "0.25"), ("c", "None")]
