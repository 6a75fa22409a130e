"""The column map: a small TOML that says which column of a log is what, and in which unit.

    [log]        time = {column = "time_s", unit = "s"}; encoding, delimiter, decimal, dbc,
                 bad_rows, fastest_kmh, offset_s: see `Reading`
    [gnss]       latitude, longitude, height, speed, course, heading, ...   (all are in QUANTITIES)
    [wheels]     driven_speed = {column = "wheel_speed_kmh", unit = "km/h"}, or by wheel
    [imu]        gyro_z, accel_x, ...; axes = "FRD" where y points right and z down
    [depth] [machine]
    [rows]       state = {column = "state"}: labels, for the rules
    [reference]  slip = {column = "slip_radar", unit = "%"}: scored against
    [zero_slip]  where = {state = ["M"]}, min_speed_kmh = 5.0: rows in which the wheels do not slip
    [steady]     the same, and max_speed_change_kmhps: rows of steady work
    [protocol]   zero_pull_passes_s = [[120, 180], [200, 260]], ...: when its parts were driven
    [implement]  width_m, name: litres per hectare follow from the working width
    [setup]      machine, wheelbase_m, ...; [setup.gnss], ... as in `twin.streams.Setup`

Every quantity may have scale and offset (value = scale x cell + offset, in its unit), sign = -1,
and missing = [...], cells that mean no value. A section may have a time of its own, as
[log] has. An angle is in the compass's sense (clockwise from north) unless its `convention` is
"east", the counter-clockwise from east that the streams use.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path

from twin.errors import BadInput, UnknownName
from twin.logs.job import Implement, implement_from
from twin.logs.protocol_parts import KEYS, Part, Times, written_from
from twin.logs.quantities import QUANTITIES
from twin.logs.readers.reading import Reading
from twin.logs.rules import Rule
from twin.logs.setup_block import setup_from
from twin.logs.stamps import TIMESTAMP
from twin.logs.units import UNITS, WHEEL_RATES

RULES = ("zero_slip", "steady")
SECTIONS = ("log", *QUANTITIES, "rows", *RULES, "implement", "protocol", "setup")
CONVENTIONS = ("compass", "east")
BEARINGS = ("course", "heading")
"""Angles that a log may count from north."""
AXES = ("FLU", "FRD")
"""Body axes: forward, left, up as the streams have them, or forward, right, down."""
_LARGEST_BYTES = 1_000_000


@dataclass(frozen=True)
class Source:
    """Column of the log that gives a quantity, with unit and conversion."""

    column: str
    unit: str
    convention: str = "compass"
    scale: float = 1.0
    offset: float = 0.0
    """In the unit: value = sign (scale x cell + offset)."""
    missing: tuple[float, ...] = ()
    """Cells that mean no value."""
    layout: str = ""
    """Of a timestamp, as strftime writes it."""
    more: tuple[str, ...] = ()
    """Further columns of a time in parts, as a date and a time of day."""


@dataclass(frozen=True, kw_only=True)
class ColumnMap:
    """A column map, checked."""

    time: Source | None = None
    columns: Mapping[str, Mapping[str, Source]] = field(default_factory=dict)
    """Section -> key -> source, for the sections of QUANTITIES."""
    times: Mapping[str, Source] = field(default_factory=dict)
    """Section -> where its own times are, for sections that are not timed as the rest is."""
    axes: Mapping[str, str] = field(default_factory=dict)
    """Section -> its body axes, one of AXES."""
    reading: Reading = field(default_factory=Reading)
    labels: Mapping[str, str] = field(default_factory=dict)
    """Label name -> column."""
    rules: Mapping[str, Rule] = field(default_factory=dict)
    implement: Implement | None = None
    protocol: Mapping[Part, Times] = field(default_factory=dict)
    setup: Mapping[str, object] = field(default_factory=dict)
    """The [setup] table as it stands; every value in it has been checked."""

    def asked(self) -> frozenset[str]:
        """Names of all columns that the map asks for, also without the file they are named with."""
        sources = [s for section in self.columns.values() for s in section.values()]
        sources += [*self.times.values(), *([self.time] if self.time else [])]
        names = {*(s.column for s in sources), *self.labels.values()}
        names |= {column for source in sources for column in source.more}
        return frozenset(names | {n.partition(":")[2] for n in names if ":" in n})


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
    return column_map_from(raw, path.parent)


def column_map_from(raw: Mapping[str, object], folder: Path = Path()) -> ColumnMap:
    """The map from parsed TOML; files it names are in `folder`. Raises BadInput with the key."""
    _known(raw, "section", SECTIONS)
    tables = {name: _table(section, name) for name, section in raw.items()}
    setup = tables.get("setup", {})
    setup_from(setup, assume=True)
    labels = {k: _label(k, v) for k, v in tables.get("rows", {}).items()}
    sections = [s for s in QUANTITIES if s in tables]
    return ColumnMap(
        time=_time("log", tables.get("log", {})),
        columns={s: _sources(s, tables[s]) for s in sections},
        times={s: time for s in sections if (time := _time(s, tables[s]))},
        axes={"imu": _axes(tables.get("imu", {}))},
        reading=_reading(tables.get("log", {}), folder),
        labels=labels,
        rules={r: _rule(r, tables[r], labels) for r in RULES if r in tables},
        implement=_implement(tables["implement"]) if "implement" in tables else None,
        protocol=_protocol(tables.get("protocol", {})),
        setup=setup,
    )


def _time(name: str, section: Mapping[str, object]) -> Source | None:
    if "time" not in section:
        return None
    return _source(f"{name}.time", section["time"], (*UNITS["time"], TIMESTAMP), time=True)


def _axes(section: Mapping[str, object]) -> str:
    axes = section.get("axes", AXES[0])
    if not isinstance(axes, str) or axes not in AXES:
        raise BadInput(f"imu.axes: {UnknownName('set of axes', str(axes), AXES)}")
    return axes


def _reading(section: Mapping[str, object], folder: Path) -> Reading:
    """How files are to be read, from [log]."""
    texts = ("encoding", "delimiter", "decimal")
    keys = ("time", *texts, "dbc", "bad_rows", "fastest_kmh", "offset_s")
    _known(section, "key of [log]", keys)
    text = {key: _text(f"log.{key}", section[key], "text") for key in texts if key in section}
    if text.get("decimal", ".") not in (".", ","):
        raise BadInput(f"log.decimal = {text['decimal']!r} must be '.' or ','")
    if len(text.get("delimiter", ",")) != 1:
        raise BadInput(f"log.delimiter = {text['delimiter']!r} must be one character")
    dbc = section.get("dbc", [])
    files = [_text("log.dbc", d, "file") for d in (dbc if isinstance(dbc, list) else [dbc])]
    bad_rows = _limit("log.bad_rows", section["bad_rows"]) if "bad_rows" in section else None
    fastest = (
        _limit("log.fastest_kmh", section["fastest_kmh"]) if "fastest_kmh" in section else None
    )
    offsets = _table(section.get("offset_s", {}), "log.offset_s")
    return Reading(
        encoding=text.get("encoding", ""), delimiter=text.get("delimiter", ""),
        decimal=text.get("decimal", ""), dbc=tuple(folder / f for f in files), bad_rows=bad_rows,
        fastest_kmh=fastest,
        offset_s={name: _number(f"log.offset_s.{name}", v) for name, v in offsets.items()},
    )  # fmt: skip


def _sources(name: str, section: Mapping[str, object]) -> dict[str, Source]:
    quantities = QUANTITIES[name]
    _known(section, f"key of [{name}]", (*quantities, "time", *["axes"] * (name == "imu")))
    return {
        key: _source(f"{name}.{key}", section[key], _units(name, key), bearing=key in BEARINGS)
        for key in section
        if key in quantities
    }


def _units(section: str, key: str) -> tuple[str, ...]:
    dimension = QUANTITIES[section][key].dimension
    turning = section == "wheels" and dimension == "speed" and key != "speed_sd"
    angle = UNITS["angle"] if key.startswith("ticks_") else ()
    return (*UNITS[dimension], *(WHEEL_RATES if turning else ()), *angle)


def _source(
    where: str, raw: object, units: Iterable[str], bearing: bool = False, time: bool = False
) -> Source:
    given = _table(raw, where)
    more = ("format",) if time else ("scale", "offset", "sign", "missing")
    _known(given, f"key of {where}", ("column", "unit", *more, *["convention"] * bearing))
    columns, unit = given.get("column"), given.get("unit")
    if not (time and isinstance(columns, list) and columns):
        columns = [columns]
    column, *rest = (_text(f"{where}.column", each) for each in columns)
    if unit is None:
        raise BadInput(f"{where} has no unit; one of {', '.join(units)} will do")
    if not isinstance(unit, str) or unit not in tuple(units):
        raise BadInput(f"{where}.unit: {UnknownName('unit', str(unit), units)}")
    convention = given.get("convention", "compass")
    if not isinstance(convention, str) or convention not in CONVENTIONS:
        known = UnknownName("convention", str(convention), CONVENTIONS)
        raise BadInput(f"{where}.convention: {known}")
    sign = given.get("sign", 1)
    if sign not in (1, -1) or isinstance(sign, bool):
        raise BadInput(f"{where}.sign = {sign!r} must be 1 or -1")
    missing = given.get("missing", [])
    codes = missing if isinstance(missing, list) else [missing]
    return Source(
        column, unit, convention,
        scale=_number(f"{where}.scale", given.get("scale", 1.0)) * int(sign),
        offset=_number(f"{where}.offset", given.get("offset", 0.0)) * int(sign),
        missing=tuple(_number(f"{where}.missing", m) for m in codes),
        layout=_text(f"{where}.format", given["format"], "format") if "format" in given else "",
        more=tuple(rest),
    )  # fmt: skip


def _number(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadInput(f"{where} = {value!r} must be a number")
    if not abs(value) < 1e15:  # a NaN is not
        raise BadInput(f"{where} = {value} is outside (-1e15, 1e15)")
    return float(value)


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


def _text(where: str, value: object, what: str = "column") -> str:
    if not isinstance(value, str) or not value or len(value) > 1000:
        raise BadInput(f"{where} must be the name of a {what}, in quotes")
    return value


def _known(section: Mapping[str, object], kind: str, known: Iterable[str]) -> None:
    known = tuple(known)
    for key in section:
        if key not in known:
            raise BadInput(str(UnknownName(kind, key, known)))
