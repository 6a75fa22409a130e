"""Plain values as TOML text, which the standard library only reads."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import TypeAlias

Value: TypeAlias = object


class Inline(dict[str, Value]):
    """A table that is written in one line."""


def text(table: Mapping[str, Value]) -> str:
    """A table of scalars, lists, tables and lists of tables; what is None is left out."""
    return "\n".join(_lines(table, "")).strip() + "\n"


def _lines(table: Mapping[str, Value], path: str) -> Iterator[str]:
    inner = {
        k: v
        for k, v in table.items()
        if (isinstance(v, Mapping) and not isinstance(v, Inline)) or _is_tables(v)
    }
    for key, value in table.items():
        if value is not None and key not in inner:
            yield f"{key} = {scalar(value)}"
    for key, value in inner.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, Mapping):
            if any(v is not None for v in value.values()):
                yield from ("", f"[{here}]", *_lines(value, here))
        elif isinstance(value, list):
            for each in value:
                yield from ("", f"[[{here}]]", *_lines(each, here))


def _is_tables(value: Value) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)


def scalar(value: Value) -> str:
    """A number, text, truth value or list as TOML writes it; a table in one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} = {scalar(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(scalar(v) for v in value) + "]"
    return json.dumps(str(value), ensure_ascii=False)
