"""Rows of measured figures, as `bench` and the studies write them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from twin.errors import BadInput
from twin.io.atomic import write_text

Row: TypeAlias = dict[str, Any]
"""A measured figure by the keys below."""
Rows: TypeAlias = list[Row]

REQUIRED = ("case", "quantity", "ours")
OPTIONAL = ("published", "reference", "low", "high", "unit", "passed")


def row(
    case: str,
    quantity: str,
    ours: float,
    unit: str,
    *,
    low: float | None = None,
    high: float | None = None,
    published: float | None = None,
    reference: float | None = None,
) -> Row:
    """One row; with a bound it says whether it passed (NaN does not)."""
    given = {"published": published, "reference": reference, "low": low, "high": high}
    out: Row = {"case": case, "quantity": quantity, "ours": ours, "unit": unit}
    out |= {name: value for name, value in given.items() if value is not None}
    if low is not None or high is not None:
        above = low is None or ours >= low
        out["passed"] = bool(above and (high is None or ours <= high))
    return out


def to_json(rows: Iterable[Mapping[str, object]]) -> str:
    """`{"rows": [...]}` as JSON text.

    Raises:
        BadInput: a row lacks `case`, `quantity` or `ours`, or has a key of another name.
    """
    checked = [_checked(number, row) for number, row in enumerate(rows)]
    return json.dumps({"rows": checked}, indent=1, allow_nan=False)


def write(rows: Iterable[Mapping[str, object]], path: Path) -> None:
    """Write rows to a JSON file. Raises BadInput as `to_json`, or when the file cannot be made."""
    write_text(path, to_json(rows) + "\n")


def _checked(number: int, row: Mapping[str, Any]) -> Row:
    missing = [key for key in REQUIRED if key not in row]
    if missing:
        raise BadInput(f"row {number} has no '{missing[0]}'; it needs {', '.join(REQUIRED)}")
    for key in row:
        if key not in (*REQUIRED, *OPTIONAL):
            allowed = ", ".join((*REQUIRED, *OPTIONAL))
            raise BadInput(f"row {number} has an unknown key '{key}'; there are: {allowed}")
    return dict(row)
