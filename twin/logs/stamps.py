"""A column of times as rising nanoseconds; rows whose time is no time, or out of order, leave."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.cells import Cells, Text, cell_text, numbers, quoted
from twin.logs.losses import Loss
from twin.logs.signals import MAX_NS
from twin.logs.units import UNITS

TIMESTAMP = "timestamp"
"""The unit of a time column that holds date and time: ISO 8601, a stated format, or Arrow's."""
SETTINGS, SET_BACK_S = 3, 10.0
"""A clock is set back at most so often in a log, and by at most so much [s]; else it is cut."""
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_ZONE = r"(Z|z|[+-][0-9]{2}:?[0-9]{2}|[+-][0-9]{2})$"
Numbered = NDArray[np.int64] | None
"""Number in the file of each row, None for 1, 2, 3, ..."""


@dataclass(frozen=True)
class Stamps:
    """Times of the rows that have one."""

    epoch_ns: NDArray[np.int64]
    """Rising, shape (m,)."""
    kept: NDArray[np.bool_]
    """Which rows of the column they are of, shape (n,)."""
    losses: tuple[Loss, ...]


def stamps(
    name: str, cells: Cells, unit: str, layout: str = "", row: Numbered = None, table: str = ""
) -> Stamps:
    """The cells of a time column in nanoseconds.

    Args:
        name: of the column, for messages.
        cells: its cells.
        unit: of `UNITS["time"]`, or `TIMESTAMP`.
        layout: strftime's format of a timestamp; empty for ISO 8601.
        row: number in the file of each row.
        table: what the rows are of.
    """
    if unit == TIMESTAMP:
        ns, right, wrong = _timestamps(name, cells, layout)
    else:
        ns, right, wrong = _counted(name, cells, UNITS["time"][unit])
    at = np.arange(1, len(ns) + 1) if row is None else row
    losses = []
    absent = ~right
    last = int(np.flatnonzero(right)[-1]) if right.any() else -1
    absent[last + 1 :] &= wrong[last + 1 :]  # blank rows at the end of a table are no rows
    if absent.any():
        first = int(np.argmax(absent))
        losses.append(Loss(table, at[absent], len(ns), _says(name, cells, at[first], first, unit)))
    kept = right.copy()
    ordered, loss = in_order(name, ns[kept], at[kept], table, len(ns))
    kept[np.flatnonzero(kept)[~ordered]] = False
    return Stamps(ns[kept], kept, (*losses, *loss))


def in_order(
    name: str, ns: NDArray[np.int64], at: NDArray[np.int64], table: str, of: int
) -> tuple[NDArray[np.bool_], list[Loss]]:
    """The longest part of times that rises strictly, and what had to be left out for it."""
    if len(ns) and np.all(np.diff(ns) > 0):
        return np.ones(len(ns), bool), []
    kept = np.zeros(len(ns), bool)
    kept[_longest_rise(ns.tolist())] = True
    if kept.all():
        return kept, []
    row = int(np.argmax(~kept))
    set_back_s = _set_back_s(ns)
    if set_back_s is not None:
        told = (
            f"column {quoted(name)}, row {at[row]}: the clock is set back by {set_back_s:.3g} s;"
            " the rows until it has caught up"
        )
        return kept, [Loss(table, at[~kept], of, told, checked=True)]
    before = ns[:row][kept[:row]]
    was, is_ = (before[-1] if len(before) else ns[kept][0]) * 1e-9, ns[row] * 1e-9
    what = "is repeated" if is_ == was else f"beside {was:.9g} s: out of order"
    says = f"column {quoted(name)}, row {at[row]}: time {is_:.9g} s {what}"
    if (~kept).sum() > 1:
        says += _restart(ns)
    return kept, [Loss(table, at[~kept], of, says)]


def _set_back_s(ns: NDArray[np.int64]) -> float | None:
    """By how much a clock that else runs evenly is set back, at most; None for any other disorder.

    At most SETTINGS times, by at most SET_BACK_S, and the next row follows by a usual step.
    """
    step = np.diff(ns)
    back = np.flatnonzero(step < 0)
    if (
        not 0 < len(back) <= SETTINGS
        or len(ns) < 100
        or np.any(step == 0)
        or back[-1] + 1 >= len(step)
    ):
        return None
    usual = float(np.median(step))
    by_s = float(usual - step[back].min()) * 1e-9
    goes_on = np.all(np.abs(step[back + 1]) < 2.0 * usual)
    return by_s if goes_on and by_s <= SET_BACK_S else None


def _restart(ns: NDArray[np.int64]) -> str:
    """What a user may do about many bad times."""
    step = np.diff(ns)
    if np.mean(step == 0) > 0.2:
        return f"; each stamp stands on {len(ns) / len(np.unique(ns)):.2g} rows: give finer stamps"
    if (step < 0).sum() <= 3 and len(ns) > 100:
        return f"; the clock goes back at row {int(np.argmax(step < 0)) + 2}: cut the log there"
    return "; sort the rows"


def _longest_rise(values: list[int]) -> list[int]:
    """Places of a longest strictly rising part (patience sorting).

    From the end on, so that of two rows that exclude each other the first stays.
    """
    tails: list[int] = []
    places: list[int] = []
    after = [-1] * len(values)
    for i in range(len(values) - 1, -1, -1):
        falling = -values[i]
        pile = bisect_left(tails, falling)
        if pile == len(tails):
            tails.append(falling)
            places.append(i)
        else:
            tails[pile], places[pile] = falling, i
        after[i] = places[pile - 1] if pile else -1
    rise, i = [], places[-1] if places else -1
    while i >= 0:
        rise.append(i)
        i = after[i]
    return rise


_Read = tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.bool_]]
"""Nanoseconds, which rows have a time, which hold something that is none."""


def _counted(name: str, cells: Cells, factor: float) -> _Read:
    whole, per_ns = _integers(cells), factor * 1e9
    if whole is not None and per_ns == round(per_ns):
        near = np.abs(whole.astype(np.float64)) * per_ns <= MAX_NS
        return np.where(near, whole, 0) * round(per_ns), near, ~near
    values, wrong = numbers(name, cells)
    near = np.abs(values) <= MAX_NS / per_ns  # a NaN is not
    ns = np.round(np.where(near, values, 0.0) * per_ns).astype(np.int64)
    return ns, near, wrong | ~(near | np.isnan(values))


def _integers(cells: Cells) -> NDArray[np.int64] | None:
    """The cells as integers if all are, so that nanoseconds since 1970 keep their last digits."""
    if not isinstance(cells, Text):
        return cells.astype(np.int64) if cells.dtype.kind in "iu" else None
    import pyarrow as pa
    import pyarrow.compute as pc

    try:
        column = pc.cast(cells.cells, pa.int64())
    except pa.ArrowInvalid:
        return None
    return None if column.null_count else np.asarray(column.to_numpy())


def _timestamps(name: str, cells: Cells, layout: str) -> _Read:
    """Nanoseconds since 1970; a stamp without a zone is UTC."""
    if not isinstance(cells, Text):
        if cells.dtype.kind != "M":
            raise BadInput(f"column {quoted(name)} holds {cells.dtype} values, not timestamps")
        right = ~np.isnat(cells)
        ns = np.where(right, cells.astype("datetime64[ns]").astype(np.int64), 0)
        return ns, right, np.zeros(len(cells), bool)
    fast = None if layout else _arrow_stamps(cells)
    if fast is not None:
        return fast, np.ones(len(fast), bool), np.zeros(len(fast), bool)
    read = _iso_ns if not layout else lambda cell: _formatted_ns(cell, layout)
    return _each(cells, read)


def _arrow_stamps(text: Text) -> NDArray[np.int64] | None:
    """All cells by Arrow, which knows ISO 8601; None where one of them is anything else."""
    import pyarrow as pa
    import pyarrow.compute as pc

    cells: Plain = pc.replace_substring(text.cells, ",", ".")
    zoned = pc.match_substring_regex(cells, _ZONE)
    zone = "UTC" if pc.any(zoned).as_py() and pc.all(zoned).as_py() else None
    try:
        return np.asarray(pc.cast(pc.cast(cells, pa.timestamp("ns", zone)), pa.int64()).to_numpy())
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
        return None


def _each(text: Text, read: Callable[[str], int]) -> _Read:
    ns, right, wrong = (np.zeros(len(text), k) for k in (np.int64, bool, bool))
    for i, cell in enumerate(text.cells.to_pylist()):
        clean = (cell or "").strip(" \t\x00\"'")
        try:
            stamp = read(clean) if clean else None
        except (ValueError, OverflowError):
            stamp, wrong[i] = None, True
        if stamp is not None and abs(stamp) <= MAX_NS:
            ns[i], right[i] = stamp, True
        elif stamp is not None:
            wrong[i] = True
    return ns, right, wrong


def _iso_ns(cell: str) -> int:
    return _since_1970(datetime.fromisoformat(cell))


def _formatted_ns(cell: str, layout: str) -> int:
    return _since_1970(datetime.strptime(cell, layout))


def _since_1970(stamp: datetime) -> int:
    stamp = stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)
    return (stamp - _EPOCH) // timedelta(microseconds=1) * 1000


def _says(name: str, cells: Cells, at: int, row: int, unit: str) -> str:
    """What is wrong with a time."""
    cell = cell_text(cells, row)
    place = f"column {quoted(name)}, row {at}"
    if unit == TIMESTAMP and cell.strip(" \t\x00\"'"):
        hint = 'say it as format = "%d.%m.%Y %H:%M:%S", or whatever it is'
        return f"{place}: {quoted(cell)} is not an ISO 8601 time; {hint}"
    if unit == TIMESTAMP:
        return f"{place}: no time"
    only = _only(len(cells), row)
    value, wrong = numbers(name, cells.kept(only) if isinstance(cells, Text) else cells[only])
    if wrong[0]:
        return f"{place}: {quoted(cell)} is not a number"
    if np.isnan(value[0]):
        return f"{place}: no time"
    return f"{place}: time {quoted(cell)} is more than 146 years from zero; is the unit right?"


def _only(count: int, row: int) -> NDArray[np.bool_]:
    return np.asarray(np.arange(count) == row)
