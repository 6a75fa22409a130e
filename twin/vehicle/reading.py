"""A TOML table as a frozen dataclass, with checked names and types; grades go to `sources`.

Any number is plain or `{value = 5260, grade = "published", source = "data sheet"}`.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import tomllib
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from twin.errors import BadInput, TwinError
from twin.io.plain import Plain, from_plain
from twin.plugins.lookup import line

T = TypeVar("T")
GRADED = frozenset({"value", "grade", "source"})
KEPT = frozenset({"sources", "folder"})
"""Fields of the dataclass that a file cannot set: they are filled while it is read."""
FORMS = {
    "cvt_ratio": "[least, greatest]",
    "depth_m": "[least, greatest]",
    "torque_points": "pairs [rpm, N m]",
    "ratios": "[ratio of each gear]",
    "speeds_kmh": "[speed of each gear]",
    "lower_pivot_m": "[x, z]",
    "top_pivot_m": "[x, z]",
} | dict.fromkeys(("gnss_main_m", "gnss_aux_m", "imu_m", "camera_m"), "[x, y, z]")
"""Field -> contents of its list, for messages."""
WORDS = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}


def read(kind: type[T], path: Path) -> T:
    """The dataclass `kind` of a TOML file.

    Raises:
        BadInput: the file cannot be read, a field is unknown or has another type, or the dataclass
            refuses a value; the message names the file, the field, the value and what is allowed.
    """
    table = table_of(path)
    try:
        return from_table(kind, table, folder=str(path.parent.absolute()))
    except TwinError as error:
        raise BadInput(f"{path}: {error}") from None


def table_of(path: Path) -> dict[str, Plain]:
    """The table of a TOML file. Raises BadInput where it cannot be read."""
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))  # with or without its mark
    except FileNotFoundError:
        raise BadInput(f"{path} is missing; a TOML file would do") from None
    except UnicodeDecodeError as error:
        row = 1 + error.object[: error.start].count(b"\n")
        raise BadInput(
            f"{path} is no UTF-8 text: byte 0x{error.object[error.start]:02x} in line {row}; save "
            "it as UTF-8"
        ) from None
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise BadInput(f"{path} is no TOML file: {line(error)}") from None


def from_table(kind: type[T], table: Mapping[str, Plain], *, folder: str) -> T:
    """The dataclass `kind` of a table; raises as `read`. `folder` becomes its field `folder`."""
    sources: list[dict[str, str]] = []
    plain = _fields(kind, table, "", sources)
    return from_plain(kind, plain | {"sources": sources, "folder": folder})


def _fields(kind: type, table: Plain, path: str, sources: list[dict[str, str]]) -> dict[str, Plain]:
    """The table's values by their fields, checked."""
    if not isinstance(table, Mapping):
        raise BadInput(f"{path} = {table!r} is no table; [{path}] with its fields would do")
    hints = typing.get_type_hints(kind)
    names = [f.name for f in dataclasses.fields(kind) if f.name not in KEPT]
    out: dict[str, Plain] = {}
    for key, value in table.items():
        here = f"{path}.{key}" if path else key
        if key not in names:
            raise BadInput(f"{here} = {_said(value)} is no field; {_near(key, names)}")
        out[key] = _value(hints[key], value, here, sources)
    for field in dataclasses.fields(kind):
        needed = field.default is field.default_factory is dataclasses.MISSING
        if needed and field.name not in out:
            raise BadInput(f"{path}.{field.name} is missing; a value would do")
    return out


def _value(hint: object, value: Plain, path: str, sources: list[dict[str, str]]) -> Plain:
    options = [h for h in _members(hint) if h is not type(None)]
    wanted: Plain = options[0]
    if dataclasses.is_dataclass(wanted) and isinstance(wanted, type):
        return _fields(wanted, value, path, sources)
    inner, origin = typing.get_args(wanted), _origin(wanted)
    if origin is tuple and dataclasses.is_dataclass(inner[0]):
        if not isinstance(value, list):
            raise BadInput(f"{path} = {_said(value)} is no list; [[{path}]] would do")
        of: Plain = inner[0]
        return [_fields(of, v, f"{path}.{i}", sources) for i, v in enumerate(value)]
    if isinstance(value, Mapping):
        value = _unwrapped(value, path, sources)
    _check(wanted, value, path)
    return value


def _unwrapped(value: Mapping[str, Plain], path: str, sources: list[dict[str, str]]) -> Plain:
    """The number of a `{value, grade, source}`; its grade and source are kept."""
    if "value" not in value or set(value) - GRADED:
        raise BadInput(
            f"{path} = {_said(value)} is no value; a number, or {{value, grade, source}}, would do"
        )
    said = {k: v for k, v in value.items() if k != "value"}
    for key, text in said.items():
        if not isinstance(text, str):
            raise BadInput(f"{path}.{key} = {_said(text)} is not text")
    sources.append({"path": path, **said})
    return value["value"]


def _check(wanted: Plain, value: Plain, path: str) -> None:
    """Refuse a value of another kind than the field's."""
    if _origin(wanted) is tuple:
        inner = typing.get_args(wanted)
        if not isinstance(value, list):
            raise BadInput(f"{path} = {_said(value)} is no list of values; {_form(path)} would do")
        if len(inner) == 2 and inner[1] is Ellipsis:
            inner = (inner[0],) * len(value)
        if len(value) != len(inner):
            raise BadInput(
                f"{path} = {_said(value)} has {len(value)} values; {len(inner)} as "
                f"{_form(path)} would do"
            )
        for i, (kind, each) in enumerate(zip(inner, value, strict=True)):
            _check(kind, each, f"{path}.{i}")
        return
    fits = isinstance(value, (int, float) if wanted is float else wanted)
    if wanted in (int, float) and isinstance(value, bool):
        fits = False
    if not fits:
        raise BadInput(f"{path} = {_said(value)} is not {WORDS[wanted]}")
    if wanted is float and not math.isfinite(value):
        raise BadInput(f"{path} = {value} is not finite; a number would do")


def _form(path: str) -> str:
    """What a list at a path holds, in words."""
    parts = path.split(".")
    each = parts[-1].isdigit()
    name = parts[-2] if each else parts[-1]
    said = FORMS.get(name, "a list")
    return said.removeprefix("pairs ") if each else said


def _origin(hint: Plain) -> Plain:
    return typing.get_origin(hint)


def _members(hint: object) -> tuple[object, ...]:
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    return typing.get_args(hint) if union else (hint,)


def _said(value: Plain) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _near(key: str, names: list[str]) -> str:
    """What the field is probably called: the same quantity in its own unit, or similar letters."""
    stem = key.rpartition("_")[0] or key
    same = [n for n in names if n == stem or n.startswith((stem + "_", key + "_"))]
    near = difflib.get_close_matches(key, same, n=1, cutoff=0.0) or (
        difflib.get_close_matches(key, names, n=1)
    )  # fmt: skip
    return f"did you mean {near[0]}?" if near else f"there are: {', '.join(names)}"
