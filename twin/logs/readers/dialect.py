"""How a text table is written: its encoding, delimiter, decimal sign, and where its header is."""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from twin.errors import BadInput
from twin.logs.cells import NUMBER
from twin.logs.readers.reading import Reading

HEAD_BYTES = 1 << 18
SAMPLE_LINES = 200
_DELIMITERS = (",", ";", "\t", "|")
_BOMS = ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_COMMA_NUMBER = re.compile(r"^[+-]?[0-9]+,[0-9]+([eE][+-]?[0-9]+)?$")
_NUMBER = re.compile(NUMBER)
_CONTROL = frozenset(range(1, 9)) | frozenset(range(14, 32))


@dataclass(frozen=True, kw_only=True)
class Dialect:
    """How a table is written."""

    encoding: str
    delimiter: str
    decimal: str
    names: tuple[str, ...]
    """Of the columns."""
    skip_lines: int
    """Lines up to the first row."""
    preamble: int = 0
    """Lines before the header that are none of the table."""
    quotes: bool = True
    """Whether cells may be in double quotes."""


def dialect(path: Path, reading: Reading) -> Dialect:
    """The dialect of a file, by its first lines, unless `reading` says it. Raises BadInput."""
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if not head.strip(b"\x00 \t\r\n\xef\xbb\xbf"):
        raise BadInput("the file is empty")
    encoding = reading.encoding or _encoding(head, path)
    try:
        text = head.decode("utf-8-sig" if encoding == "utf-8" else encoding, errors="replace")
    except LookupError:
        raise BadInput(f"encoding '{encoding}' is not one that Python knows") from None
    # str.splitlines would also split at separators that a quoted cell may hold
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(head) == HEAD_BYTES and len(lines) > 1:
        lines = lines[:-1]
    stated = re.fullmatch(r'"?sep=(.)"?', lines[0].strip("\ufeff \0"))
    start = 1 if stated else 0
    delimiter = reading.delimiter or (stated[1] if stated else _delimiter(lines[start:]))
    found = _header(lines, start, delimiter)
    rows = _cells(lines[found.skip_lines :], delimiter)
    decimal = reading.decimal or _decimal(rows, delimiter)
    return replace(found, encoding=encoding, decimal=decimal)


def _encoding(head: bytes, path: Path) -> str:
    for mark, name in _BOMS:
        if head.startswith(mark):
            return name
    odd = head[1:4000:2]
    if len(odd) > 8 and odd.count(0) > 0.6 * len(odd) and head[0:4000:2].count(0) < 0.1 * len(odd):
        return "utf-16-le"
    if sum(head.count(c) for c in _CONTROL) > 0.01 * len(head.rstrip(b"\0")):
        raise BadInput("not a text file: control characters stand where a table has text")
    return next(name for name in ("utf-8", "cp1252", "latin-1") if _decodes(path, name))


def _decodes(path: Path, encoding: str) -> bool:
    """Whether a whole file is text in an encoding; the last character may be cut."""
    decoder = codecs.getincrementaldecoder(encoding)()
    with path.open("rb") as file:
        try:
            while block := file.read(1 << 20):
                decoder.decode(block)
        except UnicodeDecodeError:
            return False
    return True


def _cells(lines: Sequence[str], delimiter: str) -> list[list[str]]:
    kept = [line for line in lines[: SAMPLE_LINES * 2] if line.strip(" \0")][:SAMPLE_LINES]
    try:
        return [next(csv.reader([line], delimiter=delimiter), []) for line in kept]
    except csv.Error:
        return [line.split(delimiter) for line in kept]


def _delimiter(lines: Sequence[str]) -> str:
    """That which cuts most lines into the same number of cells, more than one."""

    def agreeing(delimiter: str) -> tuple[float, int]:
        counts = Counter(len(cells) for cells in _cells(lines, delimiter))
        cells, times = max(counts.items(), key=lambda item: (item[1] * (item[0] > 1), item[0]))
        return (0.0, 0) if cells < 2 else (_header_fits(lines, delimiter, cells) * times, cells)

    if not any(line.strip(" \0") for line in lines):
        raise BadInput("no header and no rows")
    return max(_DELIMITERS, key=agreeing)


def _header_fits(lines: Sequence[str], delimiter: str, cells: int) -> float:
    """1 where some line that is no numbers has as many cells as the rows, else a half."""
    for row in _cells(lines, delimiter)[:50]:
        if len(row) == cells and not any(_NUMBER.match(c.strip()) for c in row if c):
            return 1.0
    return 0.5


def _header(lines: Sequence[str], start: int, delimiter: str) -> Dialect:
    """Where the header is: the first line that has as many cells as most lines have."""
    rows = _cells(lines[start:], delimiter)
    usual = Counter(len(r) for r in rows[1:] or rows).most_common(1)[0][0]
    at = start
    while at < len(lines):
        line = lines[at]
        cells = _cells([line], delimiter)[0] if line.strip(" \0") else []
        after = _cells(lines[at + 1 :], delimiter)[:1]
        short = len(cells) == usual - 1 and bool(after) and len(after[0]) == usual
        blank_ends = short and not after[0][-1].strip()
        if cells and (len(cells) == usual or blank_ends):
            break
        at += 1
    else:
        at, cells = start, rows[0]
        blank_ends = False
    names = [name.removeprefix("ï»¿").strip(" \t\0\ufeff\"'") for name in cells] + [""] * blank_ends
    numeric = [bool(_NUMBER.match(n)) for n in names if n]
    headless = bool(numeric) and all(numeric)
    return Dialect(
        encoding="", delimiter=delimiter, decimal=".",
        names=_told_apart([str(i + 1) for i in range(len(names))] if headless else names),
        skip_lines=at if headless else at + 1,
        preamble=sum(bool(line.strip(" \0")) for line in lines[start:at]),
    )  # fmt: skip


def _told_apart(names: Sequence[str]) -> tuple[str, ...]:
    """The names, those that stand twice with a number: which is meant, the map has to say."""
    counts, seen, told = Counter(names), Counter[str](), []
    for name in names:
        seen[name] += 1
        told.append(f"{name} ({seen[name]})" if counts[name] > 1 else name)
    return tuple(told)


def _decimal(rows: Sequence[Sequence[str]], delimiter: str) -> str:
    if delimiter == ",":
        return "."
    cells = [c.strip() for row in rows for c in row]
    commas = sum(bool(_COMMA_NUMBER.match(c)) for c in cells)
    points = sum("." in c and bool(_NUMBER.match(c)) for c in cells)
    return "," if commas > points else "."
