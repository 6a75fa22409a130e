"""Recorded drives: run folders, tables, NMEA, CAN, bags or a user's own kind become a `Log`.

file -> Reader -> named signals with times -> column map -> SI columns -> checks -> Log
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from twin.errors import BadInput, UnknownName
from twin.logs.build import log_from
from twin.logs.column_map import ColumnMap, read_column_map
from twin.logs.log import Log
from twin.logs.own_maps import completed
from twin.logs.reader import Reader
from twin.logs.readers.reading import Reading
from twin.logs.readers.run_folder import RunFolder
from twin.logs.registry import READERS, fitting, reader
from twin.logs.rules import Rule, choose
from twin.logs.signals import Found, Signal, checked
from twin.logs.speeds import driven_speed_mps, ground_speed_mps, paired_speeds
from twin.plugins.failing import failing
from twin.streams import check

__all__ = [
    "READERS",
    "BadInput",
    "ColumnMap",
    "Found",
    "Log",
    "Reader",
    "Reading",
    "Rule",
    "Signal",
    "choose",
    "driven_speed_mps",
    "found_in",
    "found_in_all",
    "ground_speed_mps",
    "paired_speeds",
    "read",
    "read_column_map",
    "reader",
]

_LONGEST_MESSAGE = 400
_Read = TypeVar("_Read")


def read(
    paths: Path | str | Sequence[Path | str],
    column_map: Path | str | None = None,
    reader: Reader | None = None,
    *,
    strict: bool = False,
    offset_s: Mapping[str, float] | None = None,
) -> Log:
    """Read a recorded drive.

    Args:
        paths: path of the log, or paths of its files.
        column_map: TOML that says which column is what; tables need one, other files may say it
            themselves, a run folder takes none.
        reader: reader of the files; None selects a reader for each file from its content.
        strict: refuse a log with a single bad row.
        offset_s: file name -> how far its clock is ahead of the first file's [s].

    Returns:
        Log whose streams obey `twin.streams.check`.

    Raises:
        BadInput: one line that names the file, what is wrong and where, and what would do.
    """
    given = [paths] if isinstance(paths, Path | str) else list(paths)
    files = [Path(p) for p in given]
    if not files:
        raise BadInput("no log is named")
    columns_of = None if column_map is None else _named(Path(column_map), read_column_map)
    for path in files:
        log = _named(path, lambda p: _whole(p, reader, columns_of, alone=len(files) == 1))
        if log is not None:
            return log
    if columns_of is not None and offset_s:
        reading = replace(columns_of.reading, offset_s=offset_s)
        columns_of = replace(columns_of, reading=reading)
    elif offset_s:
        columns_of = ColumnMap(reading=Reading(offset_s=offset_s))
    reading = _reading(columns_of)
    found = found_in_all(files, reading, reader)
    whole = files[0] if len(files) == 1 else Path(" + ".join(found))
    return _named(whole, lambda p: _built(found, columns_of, strict, files, reader))


def found_in(path: Path, reading: Reading | None = None, reader: Reader | None = None) -> Found:
    """Signals of a file, before a column map. Raises BadInput if the file cannot be read."""
    by = reader or fitting(path)
    if isinstance(by, RunFolder):
        by.whole(path)  # says what else the directory is
        raise BadInput("a run folder names its own columns; it needs no map")
    found = _by(by, lambda: by.found(path, reading or Reading()))
    signals = {name: checked(name, signal) for name, signal in found.signals.items()}
    return replace(found, signals=signals)


def found_in_all(
    paths: Sequence[Path], reading: Reading | None = None, reader: Reader | None = None
) -> dict[str, Found]:
    """File name -> signals of the file. Raises BadInput if a file cannot be read."""
    return {
        name: _named(path, lambda p: found_in(p, reading, reader))
        for name, path in _told_apart(paths).items()
    }


def _by(reader: Reader, reads: Callable[[], _Read]) -> _Read:
    """Result of a reader; the error of a user's own reader names its line."""
    if reader in READERS.values():
        return reads()
    with failing(f"the reader of {reader.name} logs", reader):
        return reads()


def _reading(columns_of: ColumnMap | None) -> Reading:
    if columns_of is None:
        return Reading()
    asked = columns_of.asked()
    return replace(columns_of.reading, columns=asked or None)


def _whole(
    path: Path, reader: Reader | None, columns_of: ColumnMap | None, *, alone: bool
) -> Log | None:
    """The log of a file that needs no map, if it is one."""
    by = reader or fitting(path)
    log = _by(by, lambda: by.whole(path))
    if log is None:
        return None
    if columns_of is not None:
        raise BadInput(f"a {by.name} names its own columns; leave the column map out")
    if not alone:
        raise BadInput(f"a {by.name} is a log by itself; name it alone")
    check(log.streams, log.setup.extra)
    return log


def _built(
    found: Mapping[str, Found],
    columns_of: ColumnMap | None,
    strict: bool,
    files: Sequence[Path],
    reader: Reader | None,
) -> Log:
    complete = completed(columns_of, found)
    if not complete.columns and (columns_of is None or not columns_of.time):
        by = reader or fitting(files[0])
        raise BadInput(
            f"a {by.name} log needs a column map (TOML) that says which column is what;"
            f" twin map {files[0].name} writes a first one"
        )
    log = log_from(found, complete, strict=strict)
    check(log.streams, log.setup.extra)
    return replace(log, implement=complete.implement, protocol=complete.protocol)


def _told_apart(files: Sequence[Path]) -> dict[str, Path]:
    """Files by their names. Raises BadInput for one that is named twice."""
    named: dict[str, Path] = {}
    for path in files:
        if path.resolve() in [known.resolve() for known in named.values()]:
            raise BadInput(f"{path} is named twice")
        named[path.name if path.name not in named else str(path)] = path
    return named


def _named(path: Path, reader: Callable[[Path], _Read]) -> _Read:
    """Result of `reader` for `path`; an error is one line that begins with the path."""
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
