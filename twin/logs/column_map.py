"""The column map: a small TOML that says which column of a log is what, and in which unit.

    [log]        time = {column = "time_s", unit = "s"}
    [gnss]       latitude, longitude, height, speed, course, heading, ...   (all are in QUANTITIES)
    [wheels]     driven_speed = {column = "wheel_speed_kmh", unit = "km/h"}, or by wheel
    [imu] [depth] [machine]
    [rows]       state = {column = "state"}: labels, for the rules
    [reference]  slip = {column = "slip_radar", unit = "%"}: scored against
    [zero_slip]  where = {state = ["M"]}, min_speed_kmh = 5.0: rows in which the wheels do not slip
    [steady]     the same, and max_speed_change_kmhps: rows of steady work
    [protocol]   zero_pull_passes_s = [[120, 180], [200, 260]], ...: when its parts were driven
    [implement]  width_m, name: litres per hectare follow from the working width
    [setup]      machine, wheelbase_m, ...; [setup.gnss], ... as in `twin.streams.Setup`

An angle is in the compass's sense (clockwise from north) unless its `convention` is "east", the
counter-clockwise from east that the streams use.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path

from twin.errors import BadInput, UnknownName
from twin.logs.cells import TIMESTAMP
from twin.logs.job import Implement, implement_from
from twin.logs.protocol_parts import KEYS, Part, Times, written_from
from twin.logs.quantities import QUANTITIES
from twin.logs.rules import Rule
from twin.logs.setup_block import setup_from
from twin.logs.units import UNITS

RULES = ("zero_slip", "steady")
SECTIONS = ("log", *QUANTITIES, "rows", *RULES, "implement", "protocol", "setup")
CONVENTIONS = ("compass", "east")
BEARINGS = ("course", "heading")
"""Angles that a log may count from north."""
_LARGEST_BYTES = 1_000_000


@dataclass(frozen=True)
class Source:
    """Where a quantity comes from."""

    column: str
    unit: str
    convention: str = "compass"


@dataclass(frozen=True, kw_only=True)
class ColumnMap:
    """A column map, checked."""

    time: Source | None = None
    columns: Mapping[str, Mapping[str, Source]] = field(default_factory=dict)
    """Section -> key -> source, for the sections of QUANTITIES."""
    labels: Mapping[str, str] = field(default_factory=dict)
    """Label name -> column."""
    rules: Mapping[str, Rule] = field(default_factory=dict)
    implement: Implement | None = None
    protocol: Mapping[Part, Times] = field(default_factory=dict)
    setup: Mapping[str, object] = field(default_factory=dict)
    """The [setup] table as it stands; every value in it has been checked."""


def read_column_map(path: Path) -> ColumnMap:
    """The map in a TOML file. Raises BadInput that names the file and the key."""
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise BadInput(f"{path.stat().st_size} bytes; a column map is a small TOML file")
        raw = tomllib.loads(path.read_bytes().decode("utf-8"))
    except UnicodeDecodeError as error:
        raise BadInput(f"not UTF-8 text at byte {error.start}; a column map is TOML") from None
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"not TOML: {error}") from None
    except (RecursionError, ValueError, OverflowError) as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput("not TOML that can be read: nested too deep or a number too long") from None
    return column_map_from(raw)


def column_map_from(raw: Mapping[str, object]) -> ColumnMap:
    """The map from parsed TOML. Raises BadInput that names the key."""
    _known(raw, "section", SECTIONS)
    tables = {name: _table(section, name) for name, section in raw.items()}
    setup = tables.get("setup", {})
    setup_from(setup, assume=True)
    labels = {k: _label(k, v) for k, v in tables.get("rows", {}).items()}
    return ColumnMap(
        time=_time(tables.get("log", {})),
        columns={s: _sources(s, tables[s]) for s in QUANTITIES if s in tables},
        labels=labels,
        rules={r: _rule(r, tables[r], labels) for r in RULES if r in tables},
        implement=_implement(tables["implement"]) if "implement" in tables else None,
        protocol=_protocol(tables.get("protocol", {})),
        setup=setup,
    )


def _time(section: Mapping[str, object]) -> Source | None:
    _known(section, "key of [log]", ("time",))
    if "time" not in section:
        return None
    return _source("log.time", section["time"], (*UNITS["time"], TIMESTAMP), bearing=False)


def _sources(name: str, section: Mapping[str, object]) -> dict[str, Source]:
    quantities = QUANTITIES[name]
    _known(section, f"key of [{name}]", quantities)
    return {
        key: _source(f"{name}.{key}", raw, UNITS[quantities[key].dimension], key in BEARINGS)
        for key, raw in section.items()
    }


def _source(where: str, raw: object, units: Iterable[str], bearing: bool) -> Source:
    given = _table(raw, where)
    _known(given, f"key of {where}", ("column", "unit", *["convention"] * bearing))
    column, unit = _text(f"{where}.column", given.get("column")), given.get("unit")
    if unit is None:
        raise BadInput(f"{where} has no unit; one of {', '.join(units)} will do")
    if not isinstance(unit, str) or unit not in tuple(units):
        raise BadInput(f"{where}.unit: {UnknownName('unit', str(unit), units)}")
    convention = given.get("convention", "compass")
    if not isinstance(convention, str) or convention not in CONVENTIONS:
        known = UnknownName("convention", str(convention), CONVENTIONS)
        raise BadInput(f"{where}.convention: {known}")
    return Source(column, unit, convention)


def _protocol(section: Mapping[str, object]) -> dict[Part, Times]:
    _known(section, "key of [protocol]", KEYS)
    return written_from(section)


def _implement(section: Mapping[str, object]) -> Implement:
    _known(section, "key of [implement]", (f.name for f in fields(Implement)))
    return implement_from(section)


def _label(name: str, raw: object) -> str:
    given = _table(raw, f"rows.{name}")
    _known(given, f"key of rows.{name}", ("column",))
    return _text(f"rows.{name}.column", given.get("column"))


def _rule(name: str, section: Mapping[str, object], labels: Mapping[str, str]) -> Rule:
    _known(section, f"key of [{name}]", (f.name for f in fields(Rule)))
    where = _table(section.get("where", {}), f"{name}.where")
    chosen: dict[str, tuple[str, ...]] = {}
    for label, values in where.items():
        if label not in labels:
            raise BadInput(f"{name}.where: {UnknownName('column of [rows]', label, labels)}")
        if not isinstance(values, list) or any(not isinstance(v, str) for v in values):
            raise BadInput(f"{name}.where.{label} must be a list of labels in quotes")
        chosen[label] = tuple(values)
    limits = {k: _limit(f"{name}.{k}", v) for k, v in section.items() if k != "where"}
    return Rule(where=chosen, **limits)


def _limit(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadInput(f"{where} = {value!r} must be a number")
    if math.isnan(value) or value < 0:
        raise BadInput(f"{where} = {value} is below zero")
    return float(min(value, 1e9))


def _table(raw: object, where: str) -> Mapping[str, object]:
    if not isinstance(raw, Mapping):
        raise BadInput(f"{where} = {raw!r} must be a table of values")
    return raw


def _text(where: str, value: object) -> str:
    if not isinstance(value, str) or not value:
        raise BadInput(f"{where} must be the name of a column, in quotes")
    return value


def _known(section: Mapping[str, object], kind: str, known: Iterable[str]) -> None:
    known = tuple(known)
    for key in section:
        if key not in known:
            raise BadInput(str(UnknownName(kind, key, known)))
