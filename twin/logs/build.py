"""From what readers find in files and a column map to a Log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import labels
from twin.logs.checks.across import along_course
from twin.logs.checks.agreement import disagreements
from twin.logs.checks.cutoff import unknown
from twin.logs.checks.plausible import check_same_machine
from twin.logs.checks.reverse import signed
from twin.logs.column_map import ColumnMap
from twin.logs.gaps import gap_notes
from twin.logs.gnss_table import Origin, gnss_table
from twin.logs.joined import shift
from twin.logs.log import Log
from twin.logs.losses import SHARE, Limits, judged
from twin.logs.quantity_columns import ANGLE_COUNTS, Remarks
from twin.logs.sections import Columns, holder, named, section_table
from twin.logs.setup_block import assumed_names, setup_from, table_of
from twin.logs.signals import Found, brought
from twin.logs.speeds import driven_speed_mps, ground_speed_mps, paired_speeds
from twin.logs.units import UNITS
from twin.streams import COLUMNS, Array, Setup, Streams, Table


def log_from(found: Mapping[str, Found], columns_of: ColumnMap, *, strict: bool = False) -> Log:
    """A Log of the mapped signals of one file or several. Raises BadInput that names what is wrong.

    Args:
        found: file name -> what a reader found in it.
        columns_of: the map.
        strict: refuse a log with a single bad row.
    """
    remarks = Remarks(
        notes=[note for each in found.values() for note in each.notes],
        losses=[loss for each in found.values() for loss in each.losses],
    )
    files = [Columns(name, each, columns_of, remarks) for name, each in found.items()]
    _check_time(files, columns_of)
    if len(files) > 1:
        shift(files, columns_of, remarks)
    for file in files:
        table_ns = file.table_ns()
        if table_ns is not None:
            remarks.notes += gap_notes("log", table_ns)
    sections = {}
    for name, sources in columns_of.columns.items():
        table = section_table(name, sources, files, columns_of, remarks) if sources else {}
        if len(table) > 1:
            sections[name] = table
    text = {}
    for label, column in columns_of.labels.items():
        file, own = holder(column, files, f"rows.{label}")
        timed = file.timed(own)
        text[label] = labels(column, timed.signal.cells), timed.epoch_ns
    share = columns_of.reading.bad_rows
    limits = Limits(SHARE if share is None else share, strict)
    return _assembled(sections, text, columns_of, remarks, limits)


def _check_time(files: Sequence[Columns], columns_of: ColumnMap) -> None:
    """Raise BadInput unless the map's time is a column of some file that needs one."""
    time = columns_of.time
    timeless = [f for f in files if any(s.epoch_ns is None for s in f.found.signals.values())]
    if time is not None and timeless and not any(time.column in f for f in files):
        named(time.column, {n: s for f in timeless for n, s in f.found.signals.items()}, "log.time")


def _assembled(
    sections: Mapping[str, Table],
    text: Mapping[str, tuple[Array, NDArray[np.int64]]],
    columns_of: ColumnMap,
    remarks: Remarks,
    limits: Limits,
) -> Log:
    """A Log of SI columns by section, each with its `epoch_ns`, and of labels with their times."""
    setup = setup_from(columns_of.setup, assume=True)
    tables: dict[str, Table] = {}
    rows_ns = next((times for _, times in text.values()), None)
    for name in COLUMNS:
        if name in sections:
            values = dict(sections[name])
            epoch_ns = values.pop("epoch_ns")
            table, origin = _sensor_table(name, values, epoch_ns, remarks, setup)
            setup = replace(setup, origin=origin) if origin else setup
            measured = _measured_rows(name, table, epoch_ns, remarks)
            if not len(measured["epoch_ns"]):
                continue
            tables[name] = measured
            rows_ns = measured["epoch_ns"] if name == "wheels" else rows_ns
    left_out = judged(remarks.losses, limits)
    if not tables:
        why = "; ".join(remarks.notes[-2:])
        raise BadInput(
            "no sensor has a measurement; name columns of [gnss], [wheels], ... in the map"
            + (f" ({why})" if why else "")
        )
    remarks.notes += left_out
    check_same_machine(*paired_speeds(Streams(tables)))
    tables, more = _without_cut_off(tables)
    mount_rad = setup.gnss.heading_mount_rad if setup.gnss else 0.0
    remarks.notes += [*more, *disagreements(tables, mount_rad), *_absent(tables)]
    if "gnss" in tables:
        tables["gnss"], across = along_course(tables["gnss"], mount_rad)
        remarks.notes += across
    tables, reversing = signed(tables, mount_rad)
    remarks.notes += reversing
    if "wheels" in tables and rows_ns is not None:
        rows_ns = tables["wheels"]["epoch_ns"]
    setup, assumed = _with_blocks(setup, columns_of, tables)
    rows = {k: brought(v, times, rows_ns) for k, (v, times) in text.items() if rows_ns is not None}
    return Log(
        streams=Streams(tables), setup=setup, reference=sections.get("reference"),
        rows=rows or None, rules=columns_of.rules, notes=(*remarks.notes, *assumed),
    )  # fmt: skip


def _sensor_table(
    name: str, values: Table, epoch_ns: NDArray[np.int64], remarks: Remarks, setup: Setup
) -> tuple[Table, Origin | None]:
    if name == "gnss":
        mount_rad = setup.gnss.heading_mount_rad if setup.gnss else 0.0
        return gnss_table(values, epoch_ns, remarks, setup.origin, mount_rad)
    table = dict(values)
    if "driven_speed_mps" in table:
        speed = table.pop("driven_speed_mps")
        for wheel in ("rl", "rr"):
            if f"speed_{wheel}_mps" in table:
                raise BadInput(f"wheels.driven_speed and wheels.speed_{wheel} are both given")
            table[f"speed_{wheel}_mps"] = speed
    return table, None


def _measured_rows(name: str, table: Table, epoch_ns: NDArray[np.int64], remarks: Remarks) -> Table:
    """The rows in which the sensor measured anything, with their stamps."""
    kept = np.any([np.isfinite(v) for v in table.values()], axis=0) if table else (
        np.zeros(len(epoch_ns), bool)
    )  # fmt: skip
    if kept.all():
        return {"epoch_ns": epoch_ns, "arrival_ns": epoch_ns, **table}
    lost = int((~kept).sum())
    first = f"(first at row {int(np.argmax(~kept)) + 1})"
    remarks.notes.append(f"{name}: {lost} rows without a measurement left out {first}")
    times = epoch_ns[kept]
    remarks.notes += gap_notes(name, times)
    return {"epoch_ns": times, "arrival_ns": times} | {k: v[kept] for k, v in table.items()}


def _without_cut_off(tables: Mapping[str, Table]) -> tuple[dict[str, Table], list[str]]:
    """Wheel speeds without those that read zero while the ground moves."""
    streams = Streams(dict(tables))
    ground, wheel = ground_speed_mps(streams), driven_speed_mps(streams)
    if not len(ground) or not len(wheel):
        return dict(tables), []
    times = tables["wheels"]["epoch_ns"], tables["gnss"]["epoch_ns"]
    doubted, moving_mps = unknown(wheel, times[0], ground, times[1])
    if not doubted.any():
        return dict(tables), []
    keys = [k for k in tables["wheels"] if k.startswith("speed_") and k != "speed_sd_mps"]
    wheels = {k: np.where(doubted & (v == 0.0), np.nan, v) if k in keys else v
              for k, v in tables["wheels"].items()}  # fmt: skip
    known = np.any([np.isfinite(v) for k, v in wheels.items() if k not in
                    ("epoch_ns", "arrival_ns", "speed_sd_mps")], axis=0)  # fmt: skip
    note = (
        f"wheels: {int(doubted.sum())} speeds of zero while the ground moves at"
        f" {float(np.median(moving_mps)):.2g} m/s are unknown: below the sensor's cut-off"
    )
    rest = {**tables, "wheels": {k: v[known] for k, v in wheels.items()}}
    if not known.any():
        del rest["wheels"]
    return rest, [note]


def _absent(tables: Mapping[str, Table]) -> list[str]:
    """What is missing for a slip, if anything is."""
    gnss, wheels = tables.get("gnss", {}), tables.get("wheels", {})
    turning = any(k.startswith(("ticks_", "speed_")) and k != "speed_sd_mps" for k in wheels)
    notes = []
    if not turning:
        notes.append(
            "no wheel speed: slip cannot be estimated, and estimators that count by wheel samples"
            " say nothing; map [wheels] driven_speed, speed_* or ticks_*"
        )
    if "v_east_mps" not in gnss or not np.isfinite(gnss["v_east_mps"]).any():
        notes.append(
            "no ground speed: slip cannot be estimated; map [gnss] speed or v_east, v_north"
        )
    return notes


def _with_blocks(
    setup: Setup, columns_of: ColumnMap, tables: Mapping[str, Table]
) -> tuple[Setup, list[str]]:
    """The set-up with a block for each sensor there is; its rate is the log's own."""
    sensors: Sequence[str] = tuple(s for s in ("wheels", "gnss", "imu", "depth") if s in tables)
    given: dict[str, dict[str, object]] = {s: {} for s in sensors}
    for sensor, block in given.items():
        block |= table_of(f"setup.{sensor}", columns_of.setup.get(sensor, {}))
    for sensor in sensors:
        step_ns = np.diff(tables[sensor]["epoch_ns"])
        if len(step_ns):
            given[sensor].setdefault("rate_hz", 1e9 / float(np.median(step_ns)))
    turned = any(
        k.startswith("ticks_") and s.unit in UNITS["angle"]
        for k, s in columns_of.columns.get("wheels", {}).items()
    )
    if turned and "wheels" in given:
        given["wheels"].setdefault("counts_per_turn", ANGLE_COUNTS)
    raw = {**columns_of.setup, **given}
    built = replace(setup_from(raw, assume=True), origin=setup.origin)
    assumed = assumed_names(raw, tuple(sensors))
    notes = [f"setup: assumed {', '.join(assumed)}"] if assumed else []
    counting = any(k.startswith("ticks_") for k in tables.get("wheels", {}))
    if counting and built.wheels is not None and built.wheels.counts_per_turn is None:
        notes.append(
            "wheels: counts give no speed without counts_per_turn in [setup.wheels], so no slip"
            " can be estimated"
        )
    return built, notes
