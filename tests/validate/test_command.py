"""The command: what it writes, its status, what it refuses."""

import json

import pytest

from twin.cli import main
from twin.validate import suite
from twin.validate.check import Basis, within

WORDS = {"source": "a law", "why": "because", "grade": "derived"}


@pytest.fixture
def two_checks(monkeypatch):
    """The suite replaced by one row that passes and, where asked, one that fails."""

    def put(*, high):
        first = within("one", "figure", 1.0, "m", high=2.0, basis=Basis(**WORDS))
        second = within("two", "figure", 1.0, "m", high=high, basis=Basis(**WORDS))
        found = {layer: [] for layer in suite.LAYERS} | {"table": [first, second]}
        monkeypatch.setattr(suite, "checks", lambda **_: found)

    return put


@pytest.mark.parametrize(("high", "status"), [(2.0, 0), (0.5, 1)])
def test_the_status_is_1_while_a_row_fails(two_checks, tmp_path, high, status):
    two_checks(high=high)
    page, rows = tmp_path / "V.md", tmp_path / "rows.json"
    assert main(["validate", "--out", str(page), "--json", str(rows)]) == status
    written = json.loads(rows.read_text())["rows"]
    assert [r["passed"] for r in written] == [True, status == 0]
    assert ("**FAIL**" in page.read_text(encoding="utf-8")) is (status == 1)


def test_what_cannot_be_written_is_refused_before_the_work(capsys, tmp_path):
    assert main(["validate", "--out", str(tmp_path / "none" / "V.md")]) == 2
    assert "--out" in capsys.readouterr().err
    assert main(["validate", "--jobs", "0"]) == 2
    assert "jobs = 0" in capsys.readouterr().err
