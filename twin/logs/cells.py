"""Columns as a reader finds them, turned into numbers, stamps and labels. Rows count from 1."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.units import UNITS
from twin.streams import Array

Cells = list[str] | Array
"""One column: text cells (CSV), or an array of numbers or datetime64 (Parquet)."""

TIMESTAMP = "timestamp"
"""The unit of a time column that holds ISO 8601 text or Parquet timestamps."""
LARGEST = 1e30
"""No measurement is beyond this, in any unit; infinities are, and what would overflow."""
_MISSING = {"", "na", "n/a", "null", "none", "nan"}
_LABEL_LENGTH = 64
_MAX_NS = 2**62
"""Half the int64 range (146 years), so that a difference of two stamps cannot overflow."""
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def quoted(cell: object) -> str:
    """A cell as a message shows it: one line, not too long."""
    text = repr(str(cell))
    return text if len(text) <= 40 else f"{text[:36]}...'"


def numbers(name: str, cells: Cells) -> NDArray[np.float64]:
    """The cells as floats; blank is NaN. Raises BadInput for text and beyond LARGEST."""
    if isinstance(cells, list):
        values = np.array([_number(name, row, c) for row, c in enumerate(cells, 1)], np.float64)
    elif cells.dtype.kind in "iufb":
        values = cells.astype(np.float64)
    else:
        raise BadInput(f"column {quoted(name)} holds {cells.dtype} values, not numbers")
    huge = np.abs(values) > LARGEST
    if huge.any():
        row = int(np.argmax(huge))
        raise BadInput(f"column {quoted(name)}, row {row + 1}: {values[row]} is not a measurement")
    return values


def labels(name: str, cells: Cells) -> NDArray[np.str_]:
    """The cells as text. Raises BadInput for a label over 64 characters."""
    text = [str(c).strip() for c in cells]
    for row, label in enumerate(text, 1):
        if len(label) > _LABEL_LENGTH:
            raise BadInput(
                f"column {quoted(name)}, row {row}: a label of {len(label)} characters;"
                f" at most {_LABEL_LENGTH} will do"
            )
    return np.array(text, dtype=np.str_)


def stamps_ns(name: str, cells: Cells, unit: str) -> NDArray[np.int64]:
    """The cells as strictly increasing int64 nanoseconds. Raises BadInput that says where not."""
    if unit == TIMESTAMP:
        stamps = _timestamps_ns(name, cells)
    elif (exact := _integers(cells)) is not None:
        stamps = _scaled_integers(name, exact, round(UNITS["time"][unit] * 1e9))
    else:
        stamps = _scaled_floats(name, numbers(name, cells), UNITS["time"][unit])
    check_times(name, stamps)
    return stamps


def check_times(name: str, stamps: NDArray[np.int64]) -> None:
    """Raise BadInput unless times rise strictly, within 146 years of zero."""
    if len(stamps) and max(abs(int(stamps.min())), abs(int(stamps.max()))) > _MAX_NS:
        raise _too_far(name, int(np.argmax(np.abs(stamps / 2)) + 1), f"{np.abs(stamps).max()} ns")
    step = np.diff(stamps)
    if np.all(step > 0):
        return
    row = int(np.argmax(step <= 0)) + 1
    was_s, is_s = stamps[row - 1] * 1e-9, stamps[row] * 1e-9
    what = "is repeated" if step[row - 1] == 0 else f"comes after {was_s:.9g} s: out of order"
    raise BadInput(f"column {quoted(name)}, row {row + 1}: time {is_s:.9g} s {what}; sort the rows")


def _number(name: str, row: int, cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        if cell.strip().lower() in _MISSING:
            return float("nan")
        hint = " (the decimal sign is a point)" if cell.count(",") == 1 else ""
        raise BadInput(
            f"column {quoted(name)}, row {row}: {quoted(cell)} is not a number{hint}"
        ) from None


def _integers(cells: Cells) -> list[int] | None:
    """The cells as integers if all are, so that nanoseconds since 1970 keep their last digits."""
    if not isinstance(cells, list):
        return cells.tolist() if cells.dtype.kind in "iu" else None
    try:
        return [int(c) for c in cells]
    except ValueError:
        return None


def _scaled_integers(name: str, values: list[int], factor: int) -> NDArray[np.int64]:
    for row, value in enumerate(values, 1):
        if abs(value * factor) > _MAX_NS:
            raise _too_far(name, row, value)
    return np.array([v * factor for v in values], np.int64)


def _scaled_floats(name: str, values: NDArray[np.float64], factor: float) -> NDArray[np.int64]:
    missing = np.isnan(values)
    if missing.any():
        raise BadInput(f"column {quoted(name)}, row {int(np.argmax(missing)) + 1}: no time")
    far = np.abs(values) > _MAX_NS / 1e9 / factor
    if far.any():
        row = int(np.argmax(far))
        raise _too_far(name, row + 1, values[row])
    return np.round(values * (factor * 1e9)).astype(np.int64)


def _too_far(name: str, row: int, value: object) -> BadInput:
    return BadInput(
        f"column {quoted(name)}, row {row}: time {quoted(value)} is more than 146 years from zero;"
        " is the unit right?"
    )


def _timestamps_ns(name: str, cells: Cells) -> NDArray[np.int64]:
    if isinstance(cells, list):
        stamps = [_iso_ns(name, row, c) for row, c in enumerate(cells, 1)]
        return _scaled_integers(name, stamps, 1)
    if cells.dtype != np.dtype("datetime64[ns]"):
        raise BadInput(f"column {quoted(name)} holds {cells.dtype} values, not timestamps")
    if np.isnat(cells).any():
        raise BadInput(f"column {quoted(name)}, row {int(np.argmax(np.isnat(cells))) + 1}: no time")
    return _scaled_integers(name, cells.astype(np.int64).tolist(), 1)


def _iso_ns(name: str, row: int, cell: str) -> int:
    """Nanoseconds since 1970; a stamp without a zone is UTC."""
    try:
        stamp = datetime.fromisoformat(cell.strip())
        stamp = stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)
        return (stamp - _EPOCH) // timedelta(microseconds=1) * 1000
    except (ValueError, OverflowError):
        raise BadInput(
            f"column {quoted(name)}, row {row}: {quoted(cell)} is not an ISO 8601 time"
        ) from None
