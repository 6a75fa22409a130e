"""Columns as a reader finds them, turned into numbers and labels. Rows count from 1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.streams import Array

LARGEST = 1e30
"""No measurement is beyond this, in any unit; infinities are, and what would overflow."""
MISSING = frozenset({
    "", "na", "n/a", "n.a.", "#n/a", "#n/a n/a", "#na", "#nv", "null", "none", "nan", "-nan",
    "+nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#ind", "1.#ind", "nil", "nat", "-", "--", "---",
    "?", "missing", "invalid", "undefined", "#value!", "#div/0!", "#ref!", "#num!", "#name?", "\\n",
    "not available", "no data", "nodata",
})  # fmt: skip
"""What tables write for a value that was not measured, in lower case."""
NUMBER = r"^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,4})?$"
_AROUND = " \t\x00\"'\u00a0"
"""What may stand around a cell and says nothing."""
_LABEL_LENGTH = 64


@dataclass(frozen=True)
class Text:
    """Cells of text, as an Arrow array of strings."""

    cells: Plain
    decimal: str = "."
    """The decimal sign."""

    @classmethod
    def of(cls, cells: Sequence[str]) -> Text:
        """From strings; what is no Unicode becomes a question mark."""
        import pyarrow as pa  # lazily: 0.1 s

        clean = [c.encode("utf-8", "replace").decode() for c in cells]
        return cls(pa.chunked_array([pa.array(clean, pa.string())]))

    def __len__(self) -> int:
        return len(self.cells)

    def at(self, row: int) -> str:
        """One cell."""
        return str(self.cells[row].as_py() or "")

    def kept(self, rows: NDArray[np.bool_]) -> Text:
        """The chosen rows."""
        import pyarrow as pa

        return Text(self.cells.filter(pa.array(rows)), self.decimal)


Cells = Text | Array
"""One column: text cells, or an array of numbers or datetime64."""


def side_by_side(columns: Sequence[Cells]) -> Text:
    """The cells of several columns as one text, with blanks between."""
    parts = [
        [c or "" for c in column.cells.to_pylist()] if isinstance(column, Text)
        else [str(c) for c in column.tolist()]
        for column in columns
    ]  # fmt: skip
    return Text.of([" ".join(cells).strip() for cells in zip(*parts, strict=True)])


def quoted(cell: object) -> str:
    """A cell as a message shows it: one line, not too long."""
    text = repr(str(cell))
    return text if len(text) <= 40 else f"{text[:36]}...'"


def kept(cells: Cells, rows: NDArray[np.bool_]) -> Cells:
    """The chosen rows of a column."""
    if rows.all():
        return cells
    return cells.kept(rows) if isinstance(cells, Text) else cells[rows]


def numbers(name: str, cells: Cells) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The cells as floats, NaN where blank, and which cells hold no number. Raises BadInput."""
    if isinstance(cells, Text):
        values, wrong = _text_numbers(cells)
    elif cells.dtype.kind in "iufb":
        values = np.asarray(cells, np.float64)
        wrong = np.zeros(len(values), bool)
    else:
        raise BadInput(f"column {quoted(name)} holds {cells.dtype} values, not numbers")
    with np.errstate(invalid="ignore"):
        huge = np.abs(values) > LARGEST
    if huge.any():
        values = np.where(huge, np.nan, values)
        wrong = wrong | huge
    return values, wrong


def _text_numbers(text: Text) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    import pyarrow as pa
    import pyarrow.compute as pc

    if text.decimal == ".":
        try:
            return _floats(pc.cast(text.cells, pa.float64())), np.zeros(len(text), bool)
        except pa.ArrowInvalid:
            pass
    trimmed = pc.utf8_trim(text.cells, _AROUND)
    absent = pc.is_in(pc.utf8_lower(trimmed), pa.array(sorted(MISSING)))
    if text.decimal != ".":
        trimmed = pc.replace_substring(trimmed, text.decimal, ".")
    right = pc.and_(pc.match_substring_regex(trimmed, NUMBER), pc.invert(absent))
    number = pc.if_else(right, pc.utf8_ltrim(trimmed, "+"), pa.scalar(None, pa.string()))
    wrong = pc.fill_null(pc.invert(pc.or_(right, absent)), False)
    return _floats(pc.cast(number, pa.float64())), np.asarray(wrong)


def _floats(column: Plain) -> NDArray[np.float64]:
    values: NDArray[np.float64] = column.to_numpy()
    return values


def labels(name: str, cells: Cells) -> NDArray[np.str_]:
    """The cells as text. Raises BadInput for a label over 64 characters."""
    raw = cells.cells.to_pylist() if isinstance(cells, Text) else cells
    text = ["" if c is None else str(c).strip(_AROUND) for c in raw]
    for row, label in enumerate(text, 1):
        if len(label) > _LABEL_LENGTH:
            raise BadInput(
                f"column {quoted(name)}, row {row}: a label of {len(label)} characters;"
                f" at most {_LABEL_LENGTH} will do"
            )
    return np.array(text, dtype=np.str_)


def cell_text(cells: Cells, row: int) -> str:
    """The text of a cell."""
    return cells.at(row) if isinstance(cells, Text) else str(cells[row])
