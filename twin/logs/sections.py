"""From a log's signals to the SI columns of one section of a map, on one row of times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, UnknownName
from twin.logs.cells import kept, quoted, side_by_side
from twin.logs.checks import carried
from twin.logs.checks.counters import unwrapped
from twin.logs.checks.spikes import spikes
from twin.logs.column_map import BEARINGS, ColumnMap, Source
from twin.logs.gaps import between
from twin.logs.losses import Loss
from twin.logs.quantities import QUANTITIES
from twin.logs.quantity_columns import Remarks, as_counts, si_values
from twin.logs.signals import Found, Signal, brought
from twin.logs.stamps import Stamps, in_order, stamps
from twin.streams import Array, Table

SPARSE = 0.5
"""Share of a column's rows that must be rows of the section's first, or it has times of its own."""


@dataclass(frozen=True)
class Timed:
    """A column's rows that have a time."""

    signal: Signal
    epoch_ns: NDArray[np.int64]
    at: NDArray[np.int64]
    """Number of each row in the log."""


class Columns:
    """The signals of one file, each with the times that a map gives it."""

    def __init__(self, file: str, found: Found, columns_of: ColumnMap, remarks: Remarks) -> None:
        self.file, self.found, self._map, self._remarks = file, found, columns_of, remarks
        self.shift_ns = 0
        """What is taken off the file's clock."""
        self._stamps: dict[str, Stamps] = {}
        self._clocks: dict[int, NDArray[np.int64]] = {}
        self._uses = Counter(
            s.column for section in columns_of.columns.values() for s in section.values()
        )
        self._uses.update(columns_of.labels.values())

    def __contains__(self, name: str) -> bool:
        return name in self.found.signals

    def timed(self, name: str, section: str = "") -> Timed:
        """A signal with its times. Raises BadInput."""
        signal = self.found.signals[name]
        if signal.epoch_ns is None:
            table = self._rows(section)
            if len(table.kept) != len(signal.values):
                raise BadInput(
                    f"column {quoted(name)} has {len(signal.values)} rows and"
                    f" {len(table.kept)} times"
                )
            rows = Signal(kept(signal.cells, table.kept))
            return Timed(rows, table.epoch_ns - self.shift_ns, self._numbers(table.kept))
        numbered = np.arange(1, len(signal.epoch_ns) + 1)
        rising, losses = in_order(name, signal.epoch_ns, numbered, name, len(numbered))
        if id(signal.epoch_ns) not in self._clocks:  # signals of one source share their times
            self._clocks[id(signal.epoch_ns)] = signal.epoch_ns
            self._remarks.losses += losses
        rows = Signal(kept(signal.cells, rising), signal.epoch_ns[rising])
        return Timed(rows, signal.epoch_ns[rising] - self.shift_ns, numbered[rising])

    def used(self, column: str, name: str) -> None:
        """Forget a signal that no other key of the map asks for: a long log fills the memory."""
        self._uses[column] -= 1
        if self._uses[column] == 0 and isinstance(self.found.signals, dict):
            self.found.signals[name] = Signal(np.empty(0))

    def table_ns(self) -> NDArray[np.int64] | None:
        """Times of the rows of the table; None where the map names no column of this file."""
        if self._map.time is None or self._map.time.column not in self:
            return None
        return self._rows("").epoch_ns - self.shift_ns

    def _numbers(self, rows: NDArray[np.bool_]) -> NDArray[np.int64]:
        row = self.found.row
        return (np.arange(1, len(rows) + 1) if row is None else row)[rows]

    def _rows(self, section: str) -> Stamps:
        time = self._map.times.get(section, self._map.time)
        if time is None:
            raise BadInput('the column map has no [log] time = {column = "...", unit = "s"}')
        if time.column not in self._stamps:
            parts = [
                named(column, self.found.signals, "log.time").cells
                for column in (time.column, *time.more)
            ]
            cells = parts[0] if len(parts) == 1 else side_by_side(parts)
            made = stamps(time.column, cells, time.unit, time.layout, self.found.row, "log")
            self._remarks.losses += made.losses
            self._stamps[time.column] = made
        return self._stamps[time.column]


def named(name: str, signals: Mapping[str, Signal], where: str) -> Signal:
    """A signal by its name. Raises BadInput."""
    if f"{name} (1)" in signals:
        raise BadInput(f"{where}: two columns are called {quoted(name)}; say '{name} (1)' or (2)")
    if name not in signals:
        raise BadInput(f"{where}: {UnknownName('column', name, signals)}")
    return signals[name]


def holder(column: str, files: list[Columns], where: str) -> tuple[Columns, str]:
    """The file that has a column, and its name there; `file:column` says which. Raises BadInput."""
    stem, colon, rest = column.partition(":")
    if colon:
        for file in files:
            if stem in (file.file, file.file.rpartition(".")[0]) and rest in file:
                return file, rest
    having = [file for file in files if column in file]
    if len(having) > 1:
        names = " or ".join(f"'{file.file}:{column}'" for file in having)
        raise BadInput(f"{where}: {quoted(column)} is in {len(having)} files; name it {names}")
    if not having:
        named(column, {n: s for file in files for n, s in file.found.signals.items()}, where)
    return having[0], column


def section_table(
    section: str,
    sources: Mapping[str, Source],
    files: list[Columns],
    columns_of: ColumnMap,
    remarks: Remarks,
) -> Table:
    """SI columns of a section of the map, at the times of its first signal.

    Other signals are brought to these times: quality, numbers of satellites and direction keep
    their last value, all others are interpolated linearly, except in gaps. Ticks must have these
    times already. Rows that a slower source carried forward are then left out, and single spikes
    become NaN.

    Args:
        section: "gnss", "wheels" and so on.
        sources: key of the map -> the column that it names.
        files: the columns of every file.
        columns_of: the map.
        remarks: notes and assumptions, added to.

    Raises:
        BadInput: a column is missing or in several files, a value's unit is unknown, or ticks have
            other times.
    """
    table: Table = {}
    moved: list[str] = []
    at = np.empty(0, np.int64)
    for key, source in sources.items():
        file, name = holder(source.column, files, f"{section}.{key}")
        timed = file.timed(name, section)
        if not len(timed.epoch_ns):
            continue
        values = si_values(section, key, source, timed.signal, timed.at, columns_of, remarks)
        file.used(source.column, name)
        timed = Timed(Signal(np.empty(0), timed.signal.epoch_ns), timed.epoch_ns, timed.at)
        if key.startswith("ticks_"):
            values = as_counts(source, values, timed.at, remarks)
        times = timed.epoch_ns
        at = at if table else timed.at
        epoch_ns = table.setdefault("epoch_ns", times)
        if not np.array_equal(times, epoch_ns):
            moved.append(key)
            values = _brought(section, key, values, times, epoch_ns)
        elif (first := _other_rows(table, values)) is not None:
            moved.append(key)
            values = np.where(first, _brought(section, key, values, times, epoch_ns), np.nan)
        table[QUANTITIES[section][key].column] = values
    if moved:
        remarks.notes.append(
            f"{section}: {', '.join(moved)} brought to the times of {next(iter(sources))}"
        )
    if len(table) > 1 and section != "reference":
        table, rows = _measured_once(section, table, remarks)
        _drop_spikes(section, sources, table, at[rows], remarks)
    if section == "wheels":
        _unwrap(table, remarks)
    return table


def _other_rows(table: Table, values: Array) -> NDArray[np.bool_] | None:
    """The rows of the section's first column, where this one mostly stands on others; else None."""
    first = next((v for k, v in table.items() if k != "epoch_ns"), None)
    if first is None or len(first) != len(values):
        return None
    own, rows = np.isfinite(values), np.isfinite(first)
    return rows if own.any() and rows.any() and np.mean(rows[own]) < SPARSE else None


def _drop_spikes(
    section: str,
    sources: Mapping[str, Source],
    table: Table,
    at: NDArray[np.int64],
    remarks: Remarks,
) -> None:
    """Make holes of single speeds and positions far from their neighbours, in place."""
    if section not in ("gnss", "wheels"):
        return
    time_s = (table["epoch_ns"] - table["epoch_ns"][0]) * 1e-9
    for key, source in sources.items():
        columns = _judged_by(key, table)
        if not columns:
            continue
        size = np.hypot(*(table[c] for c in columns)) if len(columns) > 1 else table[columns[0]]
        found = spikes(size, time_s, "position" if key in ("east", "north") else section)
        if found.any():
            row = at[int(np.argmax(found))]
            says = (
                f"column {quoted(source.column)}, row {row}: a single value far from its neighbours"
            )
            remarks.losses.append(Loss("log", at[found], len(size), says))
            for column in columns:
                table[column] = np.where(found, np.nan, table[column])


def _judged_by(key: str, table: Table) -> tuple[str, ...]:
    """The columns in which a spike shows: a velocity turns, so only its size shows a spike."""
    if key == "v_east":
        columns: tuple[str, ...] = ("v_east_mps", "v_north_mps")
    elif key in ("east", "north"):
        columns = (f"{key}_m",)
    elif key in ("speed", "driven_speed", "v_forward") or key.startswith("speed_"):
        columns = (f"{key}_mps",) if key != "speed_sd" else ()
    else:
        columns = ()
    return columns if set(columns) <= set(table) else ()


def _brought(
    section: str, key: str, values: Array, from_ns: NDArray[np.int64], to_ns: NDArray[np.int64]
) -> Array:
    """Values of a signal at other times; NaN where none was measured."""
    if key.startswith("ticks_"):
        raise BadInput(
            f"{section}.{key} has other times than what stands before it in [{section}]; "
            "counts are not interpolated, so give all of them the same times"
        )
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(to_ns), np.nan)
    if QUANTITIES[section][key].dimension == "count":
        return brought(values[known], from_ns[known], to_ns)
    at = np.unwrap(values[known]) if key in BEARINGS else values[known]
    start_ns = int(from_ns[0])
    return between((to_ns - start_ns) * 1e-9, (from_ns[known] - start_ns) * 1e-9, at)


def _measured_once(section: str, table: Table, remarks: Remarks) -> tuple[Table, NDArray[np.bool_]]:
    """The table without rows, or with holes, where values are carried forward; the rows kept."""
    columns = {k: v for k, v in table.items() if k != "epoch_ns"}
    rows = carried.measured(list(columns.values()))
    if rows is not None:
        remarks.notes.append(_carried_note(section, rows))
        return {k: v[rows] for k, v in table.items()}, rows
    for key, values in columns.items():
        rows = None if key.startswith("ticks_") else carried.measured([values])
        if rows is not None:
            remarks.notes.append(_carried_note(f"{section} {key}", rows))
            table = {**table, key: np.where(rows, values, np.nan)}
    return table, np.ones(len(table["epoch_ns"]), bool)


def _carried_note(what: str, rows: NDArray[np.bool_]) -> str:
    each = len(rows) / max(int(rows.sum()), 1)
    return (
        f"{what}: each value stands on {each:.3g} rows, carried forward from a slower source; it"
        " counts once"
    )


def _unwrap(table: Table, remarks: Remarks) -> None:
    """Counts that go on where a counter wraps, as integers: rows that lack one leave."""
    ticks = [k for k in table if k.startswith("ticks_")]
    if not ticks:
        return
    whole = np.all([np.isfinite(table[k]) for k in ticks], axis=0)
    for key in ticks:
        counts, spike, notes = unwrapped(table[key][whole])
        remarks.notes += [f"wheels {key}: {note}" for note in notes]
        if spike.any():
            at = np.flatnonzero(whole)[spike] + 1
            says = f"{key}, row {at[0]}: a single count far from its neighbours"
            remarks.losses.append(Loss("log", at, len(whole), says))
        table[key] = np.full(len(whole), np.nan)
        table[key][np.flatnonzero(whole)[~spike]] = counts[~spike]
    whole = np.all([np.isfinite(table[k]) for k in ticks], axis=0)
    for key in table:
        table[key] = table[key][whole]
    for key in ticks:
        table[key] = table[key].astype(np.int64)
