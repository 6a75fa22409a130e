"""From the columns of a file and a column map to a Log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, UnknownName
from twin.logs.cells import Cells, labels, numbers, quoted, stamps_ns
from twin.logs.column_map import ColumnMap, Source
from twin.logs.gaps import gap_notes
from twin.logs.gnss_table import Origin, gnss_table
from twin.logs.log import Log
from twin.logs.plausible import check_plausible, check_same_machine
from twin.logs.quantities import QUANTITIES
from twin.logs.setup_block import assumed_names, setup_from
from twin.logs.speeds import paired_speeds
from twin.logs.units import UNITS
from twin.streams import COLUMNS, Setup, Streams, Table


def log_from_columns(columns: Mapping[str, Cells], columns_of: ColumnMap) -> Log:
    """A Log of the mapped columns. Raises BadInput that names the column, row and value."""
    time = columns_of.time
    if time is None:
        raise BadInput('the column map has no [log] time = {column = "...", unit = "s"}')
    epoch_ns = stamps_ns(time.column, _column(columns, time.column, "log.time"), time.unit)
    values = {s: _values(columns, s, m) for s, m in columns_of.columns.items()}
    text = {k: labels(c, _column(columns, c, f"rows.{k}")) for k, c in columns_of.labels.items()}
    return assemble(epoch_ns, values, text, columns_of, [])


def assemble(
    epoch_ns: NDArray[np.int64],
    values: Mapping[str, Table],
    text: Table,
    columns_of: ColumnMap,
    notes: list[str],
) -> Log:
    """A Log of SI columns by section, all on the rows of `epoch_ns`."""
    notes = [*notes, *gap_notes("log", epoch_ns)]
    sections, reference = dict(values), None
    if sections.get("reference"):
        reference = {"epoch_ns": epoch_ns, **sections.pop("reference")}
    setup = setup_from(columns_of.setup, assume=True)
    tables: dict[str, Table] = {}
    for name in COLUMNS:
        if sections.get(name):
            table, origin, more = _sensor_table(name, sections[name])
            setup = replace(setup, origin=origin) if origin else setup
            measured, kept, dropped = _measured_rows(name, table, epoch_ns)
            notes += [*more, *dropped]
            if not kept.any():
                continue
            tables[name] = measured
            text = {k: v[kept] for k, v in text.items()} if name == "wheels" else text
    if not tables:
        raise BadInput(
            "no sensor has a measurement; name columns of [gnss], [wheels], ... in the map"
        )
    check_same_machine(*paired_speeds(Streams(tables)))
    setup, assumed = _with_blocks(setup, columns_of, tables)
    return Log(
        streams=Streams(tables), setup=setup, reference=reference, rows=text or None,
        rules=columns_of.rules, notes=(*notes, *assumed),
    )  # fmt: skip


def _column(columns: Mapping[str, Cells], column: str, where: str) -> Cells:
    if column not in columns:
        raise BadInput(f"{where}: {UnknownName('column', column, columns)}")
    return columns[column]


def _values(columns: Mapping[str, Cells], section: str, sources: Mapping[str, Source]) -> Table:
    """SI values of a section by stream column, checked for what a tractor can have."""
    values: Table = {}
    for key, source in sources.items():
        quantity = QUANTITIES[section][key]
        factor = UNITS[quantity.dimension][source.unit]
        cells = _column(columns, source.column, f"{section}.{key}")
        si = numbers(source.column, cells) * factor
        check_plausible(quantity, source.column, source.unit, factor, si)
        if key in ("course", "heading") and source.convention == "compass":
            si = math.pi / 2 - si
        if key.startswith("ticks_"):
            values[quantity.column] = _whole(source.column, si)
        else:
            values[quantity.column] = si
    return values


def _whole(column: str, ticks: NDArray[Any]) -> NDArray[np.int64]:
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
    raw = {**columns_of.setup, **{s: dict(columns_of.setup.get(s, {})) for s in sensors}}
    for sensor in sensors:
        step_ns = np.diff(tables[sensor]["epoch_ns"])
        if len(step_ns):
            raw[sensor].setdefault("rate_hz", 1e9 / float(np.median(step_ns)))
    built = replace(setup_from(raw, assume=True), origin=setup.origin)
    assumed = assumed_names(raw, sensors)
    return built, [f"setup: assumed {', '.join(assumed)}"] if assumed else []
