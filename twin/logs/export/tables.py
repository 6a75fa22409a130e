"""Streams as CSV, one file for each sensor, with every digit."""

from __future__ import annotations

from pathlib import Path

from twin.errors import BadInput
from twin.logs.export import maps
from twin.logs.quantities import QUANTITIES
from twin.logs.units import UNITS
from twin.streams import COLUMNS, Setup, Streams

TIME = "epoch_ns"


def write_tables(streams: Streams, setup: Setup, directory: Path) -> list[str]:
    """`gnss.csv`, `wheels.csv`, ... and `map.toml`; what is not in them. Raises BadInput."""
    sections: dict[str, dict[str, dict[str, object]]] = {}
    held: dict[str, set[str]] = {}
    for sensor in COLUMNS:
        keys = {q.column: (k, q) for k, q in QUANTITIES.get(sensor, {}).items()}
        table = streams.tables.get(sensor, {})
        columns = [c for c in table if c in keys]
        if not columns:
            continue
        held[sensor] = set(columns)
        sources: dict[str, dict[str, object]] = {}
        for column in columns:
            key, quantity = keys[column]
            unit = next(u for u, factor in UNITS[quantity.dimension].items() if factor == 1.0)
            sources[key] = {"column": f"{sensor}_{column}", "unit": unit}
            if key in ("course", "heading"):
                sources[key]["convention"] = "east"
        sections[sensor] = sources
        _write(directory / f"{sensor}.csv", sensor, columns, streams)
    if not sections:
        raise BadInput("the streams hold nothing that a table can")
    log = {
        "time": {"column": TIME, "unit": "ns"},
        "offset_s": {f"{sensor}.csv": 0.0 for sensor in list(sections)[1:]},
    }
    text = maps.map_text(sections, setup, log)
    (directory / "map.toml").write_text(text, encoding="utf-8")
    return maps.left_out(streams, held)


def _write(path: Path, sensor: str, columns: list[str], streams: Streams) -> None:
    table = streams[sensor]
    with path.open("w", encoding="ascii", newline="") as file:
        file.write(",".join([TIME, *(f"{sensor}_{c}" for c in columns)]) + "\n")
        values = [table[TIME].tolist(), *(table[c].tolist() for c in columns)]
        for row in zip(*values, strict=True):
            file.write(",".join("" if cell != cell else repr(cell) for cell in row) + "\n")
