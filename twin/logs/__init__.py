"""Readers of recorded drives: a run folder, CSV, Parquet or NMEA 0183 becomes a `Log`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from twin.errors import BadInput
from twin.logs.build import log_from_columns
from twin.logs.column_map import ColumnMap, read_column_map
from twin.logs.csv_table import read_csv
from twin.logs.log import Log
from twin.logs.nmea_log import read_nmea_log
from twin.logs.parquet_table import read_parquet
from twin.logs.rules import Rule, choose
from twin.logs.run_folder import read_run_folder
from twin.logs.speeds import driven_speed_mps, ground_speed_mps, paired_speeds
from twin.streams import check

__all__ = [
    "BadInput",
    "ColumnMap",
    "Log",
    "Rule",
    "choose",
    "driven_speed_mps",
    "ground_speed_mps",
    "paired_speeds",
    "read",
    "read_column_map",
]

_LONGEST_MESSAGE = 400
_Read = TypeVar("_Read")


def read(path: Path | str, column_map: Path | str | None = None) -> Log:
    """Read a recorded drive.

    Args:
        path: a run folder, or a CSV, Parquet or NMEA 0183 file; told apart by what is in it.
        column_map: TOML that says which column is what; CSV and Parquet need one, for NMEA it may
            give the set-up, a run folder takes none.

    Returns:
        Log whose streams obey `twin.streams.check`.

    Raises:
        BadInput: one line that names the file, what is wrong and where, and what would do.
    """
    columns_of = None if column_map is None else _named(Path(column_map), read_column_map)
    return _named(Path(path), lambda p: _read(p, columns_of))


def _read(path: Path, columns_of: ColumnMap | None) -> Log:
    log = _read_as(_format(path), path, columns_of)
    check(log.streams, log.setup.extra)
    return log


def _format(path: Path) -> str:
    """Which reader a path needs, by its nature and its first bytes."""
    if path.is_dir():
        return "run folder"
    if not path.exists():
        raise BadInput("there is no such file")
    if not path.is_file():
        raise BadInput("not a regular file")
    with path.open("rb") as file:
        head = file.read(4096)
    if head.startswith(b"PAR1") or path.suffix.lower() in (".parquet", ".pq"):
        return "Parquet"
    if head.lstrip().startswith((b"$", b"!")) or path.suffix.lower() in (".nmea", ".nme"):
        return "NMEA"
    return "CSV"


def _read_as(form: str, path: Path, columns_of: ColumnMap | None) -> Log:
    if form == "run folder":
        if columns_of is not None:
            raise BadInput("a run folder names its own columns; leave the column map out")
        return read_run_folder(path)
    if form == "NMEA":
        return read_nmea_log(path, columns_of or ColumnMap())
    columns = read_parquet(path) if form == "Parquet" else read_csv(path)
    if columns_of is None:
        raise BadInput(f"a {form} log needs a column map (TOML) that says which column is what")
    return log_from_columns(columns, columns_of)


def _named(path: Path, reader: Callable[[Path], _Read]) -> _Read:
    """What `reader` makes of `path`; a refusal is one line that begins with the path."""
    try:
        return reader(path)
    except BadInput as error:
        raise BadInput(_one_line(f"{path}: {error}")) from None
    except OSError as error:
        raise BadInput(_one_line(f"{path}: {error.strerror or error}")) from None


def _one_line(text: str) -> str:
    line = "".join(c if c.isprintable() else " " for c in text)
    line = " ".join(line.split())
    return line if len(line) <= _LONGEST_MESSAGE else f"{line[: _LONGEST_MESSAGE - 3]}..."
