"""Recorded drives: a run folder, CSV, Parquet, NMEA 0183 or a user's own kind becomes a `Log`.

A `Reader` finds named signals in a file, and a column map makes streams of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from twin.errors import BadInput, UnknownName
from twin.logs.column_map import ColumnMap, read_column_map
from twin.logs.log import Log
from twin.logs.reader import Reader
from twin.logs.readers import READERS, fitting, reader
from twin.logs.rules import Rule, choose
from twin.logs.signals import Signal
from twin.logs.speeds import driven_speed_mps, ground_speed_mps, paired_speeds
from twin.plugins.failing import failing
from twin.streams import check

__all__ = [
    "READERS",
    "BadInput",
    "ColumnMap",
    "Log",
    "Reader",
    "Rule",
    "Signal",
    "choose",
    "driven_speed_mps",
    "ground_speed_mps",
    "paired_speeds",
    "read",
    "read_column_map",
    "reader",
]

_LONGEST_MESSAGE = 400
_Read = TypeVar("_Read")


def read(
    path: Path | str, column_map: Path | str | None = None, reader: Reader | None = None
) -> Log:
    """Read a recorded drive.

    Args:
        path: the log.
        column_map: TOML that says which column is what; CSV and Parquet need one, for NMEA it may
            give the set-up, a run folder takes none.
        reader: what reads it; None tells a run folder, Parquet, NMEA 0183 and CSV apart by what is
            in them.

    Returns:
        Log whose streams obey `twin.streams.check`.

    Raises:
        BadInput: one line that names the file, what is wrong and where, and what would do.
    """
    columns_of = None if column_map is None else _named(Path(column_map), read_column_map)
    return _named(Path(path), lambda p: _read(p, columns_of, reader))


def _read(path: Path, columns_of: ColumnMap | None, reader: Reader | None) -> Log:
    by = reader or fitting(path)
    if by in READERS.values():
        log = by.read(path, columns_of)
    else:
        with failing(f"the reader of {by.name} logs", by):
            log = by.read(path, columns_of)
    check(log.streams, log.setup.extra)
    if columns_of is None:
        return log
    return replace(log, implement=columns_of.implement, protocol=columns_of.protocol)


def _named(path: Path, reader: Callable[[Path], _Read]) -> _Read:
    """What `reader` makes of `path`; a refusal is one line that begins with the path."""
    try:
        return reader(path)
    except (BadInput, UnknownName) as error:
        raise BadInput(_one_line(f"{path}: {error}")) from None
    except OSError as error:
        raise BadInput(_one_line(f"{path}: {error.strerror or error}")) from None


def _one_line(text: str) -> str:
    line = "".join(c if c.isprintable() else " " for c in text)
    line = " ".join(line.split())
    return line if len(line) <= _LONGEST_MESSAGE else f"{line[: _LONGEST_MESSAGE - 3]}..."
