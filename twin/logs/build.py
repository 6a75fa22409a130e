"""From the signals of a log and a column map to a Log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, UnknownName
from twin.logs.cells import labels, numbers, quoted, stamps_ns
from twin.logs.column_map import BEARINGS, ColumnMap, Source
from twin.logs.gaps import between, gap_notes
from twin.logs.gnss_table import Origin, gnss_table
from twin.logs.log import Log
from twin.logs.plausible import check_plausible, check_same_machine
from twin.logs.quantities import QUANTITIES
from twin.logs.setup_block import assumed_names, setup_from, table_of
from twin.logs.signals import Signal, brought
from twin.logs.speeds import paired_speeds
from twin.logs.units import UNITS
from twin.streams import COLUMNS, Array, Setup, Streams, Table


def log_from_signals(signals: Mapping[str, Signal], columns_of: ColumnMap) -> Log:
    """A Log of the mapped signals. Raises BadInput that names the column, row and value."""
    table_ns = _table_ns(signals, columns_of)
    sections, notes = {}, [] if table_ns is None else gap_notes("log", table_ns)
    for name, sources in columns_of.columns.items():
        if sources:
            sections[name], told = _section(name, sources, signals, table_ns)
            own = (
                []
                if sections[name]["epoch_ns"] is table_ns
                else gap_notes(name, sections[name]["epoch_ns"])
            )
            notes += [*told, *own]
    text = {}
    for label, column in columns_of.labels.items():
        signal = _signal(signals, column, f"rows.{label}")
        text[label] = labels(column, signal.values), _times(column, signal, table_ns)
    return assemble(sections, text, columns_of, notes)


def assemble(
    sections: Mapping[str, Table],
    text: Mapping[str, tuple[Array, NDArray[np.int64]]],
    columns_of: ColumnMap,
    notes: list[str],
) -> Log:
    """A Log of SI columns by section, each with its `epoch_ns`, and of labels with their times."""
    setup = setup_from(columns_of.setup, assume=True)
    tables: dict[str, Table] = {}
    rows_ns = next((times for _, times in text.values()), None)
    for name in COLUMNS:
        if sections.get(name):
            values = dict(sections[name])
            epoch_ns = values.pop("epoch_ns")
            table, origin, more = _sensor_table(name, values)
            setup = replace(setup, origin=origin) if origin else setup
            measured, kept, dropped = _measured_rows(name, table, epoch_ns)
            notes = [*notes, *more, *dropped]
            if not kept.any():
                continue
            tables[name] = measured
            rows_ns = measured["epoch_ns"] if name == "wheels" else rows_ns
    if not tables:
        raise BadInput(
            "no sensor has a measurement; name columns of [gnss], [wheels], ... in the map"
        )
    check_same_machine(*paired_speeds(Streams(tables)))
    setup, assumed = _with_blocks(setup, columns_of, tables)
    rows = {k: brought(v, times, rows_ns) for k, (v, times) in text.items() if rows_ns is not None}
    return Log(
        streams=Streams(tables), setup=setup, reference=sections.get("reference"),
        rows=rows or None, rules=columns_of.rules, notes=(*notes, *assumed),
    )  # fmt: skip


def _table_ns(signals: Mapping[str, Signal], columns_of: ColumnMap) -> NDArray[np.int64] | None:
    """Times of the rows of a table; None where the map names no time."""
    time = columns_of.time
    if time is None:
        return None
    return stamps_ns(time.column, _signal(signals, time.column, "log.time").values, time.unit)


def _signal(signals: Mapping[str, Signal], column: str, where: str) -> Signal:
    if column not in signals:
        raise BadInput(f"{where}: {UnknownName('column', column, signals)}")
    return signals[column]


def _times(column: str, signal: Signal, table_ns: NDArray[np.int64] | None) -> NDArray[np.int64]:
    """When a signal was measured: its own times, or those of the table's rows."""
    times = table_ns if signal.epoch_ns is None else signal.epoch_ns
    if times is None:
        raise BadInput('the column map has no [log] time = {column = "...", unit = "s"}')
    if len(times) != len(signal.values):
        raise BadInput(
            f"column {quoted(column)} has {len(signal.values)} rows and {len(times)} times"
        )
    return times


def _section(
    section: str,
    sources: Mapping[str, Source],
    signals: Mapping[str, Signal],
    table_ns: NDArray[np.int64] | None,
) -> tuple[Table, list[str]]:
    """SI columns of a section at the times of its first signal; what was brought there, as notes.

    Numbers that count, and labels, are held; all others are interpolated linearly, except in gaps.
    """
    table: Table = {}
    moved = []
    for key, source in sources.items():
        signal = _signal(signals, source.column, f"{section}.{key}")
        times = _times(source.column, signal, table_ns)
        quantity = QUANTITIES[section][key]
        values = _si(section, key, source, signal)
        epoch_ns = table.setdefault("epoch_ns", times)
        if not np.array_equal(times, epoch_ns):
            moved.append(key)
            values = _brought(section, key, values, times, epoch_ns)
        table[quantity.column] = values
    first = next(iter(sources))
    told = f"{section}: {', '.join(moved)} brought to the times of {first}"
    return table, [told] if moved else []


def _brought(
    section: str, key: str, values: Array, from_ns: NDArray[np.int64], to_ns: NDArray[np.int64]
) -> Array:
    """Values of a signal at other times; NaN where none was measured."""
    if key.startswith("ticks_"):
        raise BadInput(
            f"{section}.{key} has other times than what stands before it in [{section}]; "
            "counts are not interpolated, so give all of them the same times"
        )
    if QUANTITIES[section][key].dimension == "count":
        return brought(values, from_ns, to_ns)
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(to_ns), np.nan)
    at = np.unwrap(values[known]) if key in BEARINGS else values[known]
    start_ns = int(from_ns[0])
    return between((to_ns - start_ns) * 1e-9, (from_ns[known] - start_ns) * 1e-9, at)


def _si(section: str, key: str, source: Source, signal: Signal) -> Array:
    """SI values of a column, checked for what a tractor can have."""
    quantity = QUANTITIES[section][key]
    factor = UNITS[quantity.dimension][source.unit]
    si = numbers(source.column, signal.values) * factor
    check_plausible(quantity, source.column, source.unit, factor, si)
    if key in BEARINGS and source.convention == "compass":
        si = math.pi / 2 - si
    return _whole(source.column, si) if key.startswith("ticks_") else si


def _whole(column: str, ticks: Array) -> NDArray[np.int64]:
    """Counts as integers, which have no NaN: every row must have one."""
    whole = ticks == np.round(ticks)
    if not whole.all():
        row = int(np.argmax(~whole))
        raise BadInput(f"column {quoted(column)}, row {row + 1}: {ticks[row]} is not a count")
    return ticks.astype(np.int64)


def _sensor_table(name: str, values: Table) -> tuple[Table, Origin | None, list[str]]:
    if name == "gnss":
        return gnss_table(values)
    table = dict(values)
    if "driven_speed_mps" in table:
        speed = table.pop("driven_speed_mps")
        for wheel in ("rl", "rr"):
            if f"speed_{wheel}_mps" in table:
                raise BadInput(f"wheels.driven_speed and wheels.speed_{wheel} are both given")
            table[f"speed_{wheel}_mps"] = speed
    return table, None, []


def _measured_rows(
    name: str, table: Table, epoch_ns: NDArray[np.int64]
) -> tuple[Table, NDArray[np.bool_], list[str]]:
    """The rows in which the sensor measured anything, with their stamps; notes on the others."""
    kept = np.any([np.isfinite(v) for v in table.values()], axis=0)
    measured = {"epoch_ns": epoch_ns[kept], "arrival_ns": epoch_ns[kept].copy()}
    measured |= {k: v[kept] for k, v in table.items()}
    lost = int((~kept).sum())
    if not lost:
        return measured, kept, []
    first = f"(first at row {int(np.argmax(~kept)) + 1})"
    notes = [f"{name}: {lost} rows without a measurement left out {first}"]
    return measured, kept, [*notes, *gap_notes(name, measured["epoch_ns"])]


def _with_blocks(
    setup: Setup, columns_of: ColumnMap, tables: Mapping[str, Table]
) -> tuple[Setup, list[str]]:
    """The set-up with a block for each sensor there is; its rate is the log's own."""
    sensors = tuple(s for s in ("wheels", "gnss", "imu", "depth") if s in tables)
    given: dict[str, dict[str, object]] = {s: {} for s in sensors}
    for sensor, block in given.items():
        block |= table_of(f"setup.{sensor}", columns_of.setup.get(sensor, {}))
    for sensor in sensors:
        step_ns = np.diff(tables[sensor]["epoch_ns"])
        if len(step_ns):
            given[sensor].setdefault("rate_hz", 1e9 / float(np.median(step_ns)))
    raw = {**columns_of.setup, **given}
    built = replace(setup_from(raw, assume=True), origin=setup.origin)
    assumed = assumed_names(raw, sensors)
    return built, [f"setup: assumed {', '.join(assumed)}"] if assumed else []
