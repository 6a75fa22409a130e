"""The other checkout that `twin bench --against` measures against."""

from __future__ import annotations

from pathlib import Path

import pytest

from twin.bench import against
from twin.errors import BadInput, UnknownName


def test_a_checkout_against_itself() -> None:
    found = {row["quantity"]: row["ours"] for row in against.rows(against.ROOT, ["list"], rounds=2)}
    assert 0.02 < found["ours"] < 5.0
    assert found["ratio, least"] <= found["ratio, median"] <= found["ratio, greatest"]
    assert found["ratio, median"] == pytest.approx(1.0, abs=0.8)


def test_what_cannot_be_compared_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="there is no twin"):
        against.rows(tmp_path)
    with pytest.raises(UnknownName, match="did you mean 'long'"):
        against.rows(against.ROOT, ["lang"])
    package = tmp_path / "twin"
    package.mkdir()
    (package / "__init__.py").write_text("")
    with pytest.raises(BadInput, match="fails: "):
        against.rows(tmp_path, ["list"])
