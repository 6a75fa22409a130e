from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest
from synthetic_run import synthetic_run

from twin import report, scores
from twin.report.page import flat, page
from twin.runfolder import Record

RUN = synthetic_run(duration_s=20.0)
SCORES = scores.score(RUN.truth, RUN.estimates, scenario="stub", seed=1)
PAGE = page(RUN, SCORES)


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
    checker = _Balance()
    checker.feed(PAGE)
    checker.close()
    assert checker.open == []


def test_nothing_is_fetched() -> None:
    without_names = PAGE.replace("http://www.w3.org/", "")  # names of namespaces, not addresses
    assert not re.findall(
        r"""(?:src|href)=["'](?!data:|#)[^"']*|url\((?!#)|https?://""", without_names
    )


def test_all_figures_are_there_and_are_whole() -> None:
    figures = re.findall(r"<svg.*?</svg>", PAGE, re.DOTALL)
    titles = [ElementTree.fromstring(f).attrib["aria-label"] for f in figures]
    assert titles == [
        "Slip of the driven axle over time",
        "Distribution of the slip error",
        "Sideslip at the centre of gravity over time",
        "Path, east and north",
        "Draft and depth of ploughing over time",
        "Speeds over time",
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
    assert "slip median 0.070" in text
    assert "a &lt;gap&gt;" in text


def test_nested_values_get_dotted_names() -> None:
    assert flat({"a": {"b": 0.25}, "c": None}) == [("a.b", "0.25"), ("c", "None")]
