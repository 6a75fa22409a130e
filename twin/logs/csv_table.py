"""CSV: a header, then rows of as many cells; comma, semicolon or tab between them; UTF-8."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from twin.errors import BadInput
from twin.logs.cells import quoted
from twin.logs.reader import Reader
from twin.logs.signals import Signal


class Csv(Reader):
    """A CSV file; the reader of every file that no other reader fits."""

    name = "CSV"

    def fits(self, path: Path, head: bytes) -> bool:
        """Whether it is a file."""
        return not path.is_dir()

    def signals(self, path: Path) -> dict[str, Signal]:
        """Each column as a signal, by name.

        Raises:
            BadInput: the file is not UTF-8 or CSV, has no rows or ragged ones, or two columns have
                one name.
        """
        return {name: Signal(cells) for name, cells in read_csv(path).items()}


def read_csv(path: Path) -> dict[str, list[str]]:
    """The columns as text, by name. Raises BadInput for no rows, ragged rows and doubled names."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput(f"not a text file: byte {error.start} is not UTF-8") from None
    if not text.strip():
        raise BadInput("the file is empty")
    # str.splitlines would also split at separators that a quoted cell may hold
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    header, rows = _rows(lines)
    _check_header(header)
    if not rows:
        raise BadInput("a header and no rows")
    return {name: list(cells) for name, cells in zip(header, zip(*rows, strict=True), strict=True)}


def _rows(lines: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    first = next(line for line in lines if line.strip())
    delimiter = max(",;\t", key=first.count)
    try:
        # a blank line is no row; a row of blank cells is one, and has no time
        table = [
            r for r in csv.reader(lines, delimiter=delimiter) if len(r) > 1 or "".join(r).strip()
        ]
    except csv.Error as error:
        raise BadInput(f"not CSV: {error}") from None
    if not table:
        raise BadInput("no header and no rows")
    header, rows = [name.strip() for name in table[0]], table[1:]
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise BadInput(f"row {number} has {len(row)} cells, the header has {len(header)}")
    return header, rows


def _check_header(header: list[str]) -> None:
    if len(set(header)) < len(header):
        twice = next(name for name in header if header.count(name) > 1)
        raise BadInput(f"two columns are called {quoted(twice)}")
