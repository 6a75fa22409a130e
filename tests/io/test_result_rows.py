from __future__ import annotations

import json
from pathlib import Path

import pytest

from twin.errors import BadInput
from twin.io import result_rows as rows

ROW = {"case": "plough-25cm", "quantity": "real-time factor", "ours": 41.0, "low": 30.0}


def test_rows_are_written_as_they_are(tmp_path: Path) -> None:
    rows.write([ROW], tmp_path / "rows.json")
    assert json.loads((tmp_path / "rows.json").read_text()) == {"rows": [ROW]}


def test_a_row_without_its_value_is_refused() -> None:
    with pytest.raises(BadInput, match="row 0 has no 'ours'"):
        rows.to_json([{"case": "a", "quantity": "b"}])


def test_a_misspelt_key_is_refused() -> None:
    with pytest.raises(BadInput, match="row 1 has an unknown key 'publshed'"):
        rows.to_json([ROW, {**ROW, "publshed": 1.0}])
