"""The page: verdicts, tolerances and the committed file's rows."""

import re
from pathlib import Path

import pytest

from twin.validate import page, suite
from twin.validate.check import Basis, near, within

PAGE = Path(__file__).parents[2] / "VALIDATION.md"
WORDS = {"source": "a law", "why": "because", "grade": "derived"}
ROW = re.compile(r"^\| ([A-G])(\d+) \| (.*?) \| (.*?) \| ")


def rows_of(text):
    """Layer's letter, case and quantity of every row, in order."""
    return [m.group(1, 3, 4) for line in text.splitlines() if (m := ROW.match(line))]


def test_a_figure_passes_within_its_tolerance_and_not_beyond():
    assert near("a", "b", 10.19, "N", 10.0, relative=0.02, basis=Basis(**WORDS)).passed
    assert not near("a", "b", 10.21, "N", 10.0, relative=0.02, basis=Basis(**WORDS)).passed
    assert near("a", "b", -10.19, "N", -10.0, relative=0.02, basis=Basis(**WORDS)).passed
    assert not near("a", "b", float("nan"), "N", 10.0, relative=0.02, basis=Basis(**WORDS)).passed
    assert not within("a", "b", 1.0, "N", high=0.9, basis=Basis(**WORDS)).passed


def test_an_unknown_grade_is_refused():
    with pytest.raises(ValueError, match="grade = guessed"):
        Basis(source="", why="", grade="guessed")


def test_the_page_says_what_fails_and_why():
    bad = within(
        "case|x", "quantity", 2.0, "mm", high=1.0, basis=Basis(note="known reason", **WORDS)
    )
    good = near("other", "quantity", 1e-17, "1", 0.0, absolute=0.1, basis=Basis(**WORDS))
    text = page.text({layer: [bad, good] for layer in suite.LAYERS})
    assert text.count("**FAIL**") == len(suite.LAYERS) == text.count("* A1: known reason.") * 7
    assert "14 rows: 7 pass, 7 fail" in text
    assert "case\\|x" in text
    assert "| 2 mm | - | at most 1: because |" in text
    assert "## What is not validated" in text


def test_the_committed_page_has_at_least_forty_rows_over_all_layers():
    found = rows_of(PAGE.read_text(encoding="utf-8"))
    assert len(found) >= 40
    assert {letter for letter, _, _ in found} == set("ABCDEFG")
    assert len(set(found)) == len(found)


def test_the_committed_pages_words_are_those_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    assert text.startswith(page.INTRODUCTION)
    assert text.endswith(page.NOT_VALIDATED)
