"""CSV: a header, then rows of as many cells, cut by Arrow; a row that is not so is left out."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.cells import Cells, Text, kept, quoted
from twin.logs.losses import Loss
from twin.logs.reader import Reader
from twin.logs.readers.dialect import Dialect, dialect
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.streams import Array

_BLOCK_BYTES = 1 << 18
_BY_ARROW = ("utf-8", "cp1252", "latin-1")
"""Encodings that Arrow reads by itself; in the others, a character may be cut."""
_TAIL_BYTES = 4096
_TAILS = {"utf-16": "utf-16-le"}
"""Encoding of a file -> that of its end, where no mark says in which order bytes stand."""


class Csv(Reader):
    """A CSV file; the reader of every file that no other reader fits."""

    name = "CSV"

    def fits(self, path: Path, head: bytes) -> bool:
        """Whether it is a file."""
        return not path.is_dir()

    def found(self, path: Path, reading: Reading) -> Found:
        """Each column as a signal, by name.

        Raises:
            BadInput: the file is no text or has no rows.
        """
        how = dialect(path, reading)
        columns, rows, lost = _read(path, how, reading.columns)
        if not rows:
            raise BadInput("a header and no rows" if not lost.numbers else lost.says(how))
        if _is_cut(path, how):
            rows -= 1
            columns = {n: kept(c, np.arange(len(c)) < rows) for n, c in columns.items()}
            lost.cut = rows + 1 + len(lost.numbers)
        notes = []
        if how.preamble:
            notes.append(f"{how.preamble} lines before the header left out")
        if how.encoding not in ("utf-8", "utf-16") and not reading.encoding:
            notes.append(f"text read as {how.encoding}; encoding in [log] says another")
        if how.decimal == "," and not reading.decimal:
            notes.append("decimal comma")
        signals = {name: Signal(np.empty(0)) for name in how.names if name}
        signals |= {name: Signal(cells) for name, cells in columns.items()}
        numbers = np.array(lost.numbers, np.int64)
        cut = np.array([lost.cut] if lost.cut else [], np.int64)
        rows += len(numbers) + len(cut)
        loss = [Loss("log", numbers, rows, lost.says(how))] if len(numbers) else []
        loss += [Loss("log", cut, rows, f"row {lost.cut}, the last, is cut")] if lost.cut else []
        out = np.concatenate([numbers, cut])
        row = np.setdiff1d(np.arange(1, rows + 1), out) if len(out) else None
        return Found(signals=signals, losses=tuple(loss), notes=tuple(notes), row=row)


@dataclass
class _Lost:
    """Rows that have too many or too few cells."""

    skipped: int
    """Rows of the file before the first of the table."""
    numbers: list[int] = field(default_factory=list)
    cells: int = 0
    cut: int = 0
    """Number of the last row, if its last cell is cut."""

    def take(self, row: Plain) -> str:
        """What Arrow calls for each."""
        self.cells = self.cells or row.actual_columns
        self.numbers.append(row.number - self.skipped)
        return "skip"

    def says(self, how: Dialect) -> str:
        """What is wrong with the first."""
        return (
            f"row {self.numbers[0]} has {self.cells} cells, the header has {len(how.names)}"
            if self.numbers
            else ""
        )


def _is_cut(path: Path, how: Dialect) -> bool:
    """Whether a file ends within a row: without an end of the line, in a cell shorter than others.

    A row that is cut between its cells has too few of them, and is known by that.
    """
    with path.open("rb") as file:
        file.seek(0, 2)
        file.seek(max(file.tell() - _TAIL_BYTES, 0))
        tail = file.read().decode(_TAILS.get(how.encoding, how.encoding), "replace")
    lines = tail.rstrip("\0").split("\n")
    if len(lines) < 4 or not lines[-1].strip() or lines[-1].count(how.delimiter) < (
        len(how.names) - 1
    ):  # fmt: skip
        return False
    last = [len(line.rstrip("\r").rpartition(how.delimiter)[2]) for line in lines[1:]]
    return last[-1] < min(last[:-1])


def _read(
    path: Path, how: Dialect, asked: frozenset[str] | None
) -> tuple[dict[str, Cells], int, _Lost]:
    """The columns, the number of rows, and the rows lost; of quotes that do not close, as text."""
    import pyarrow as pa

    names = [n for n in how.names if n and (asked is None or n in asked)] or [how.names[0]]
    try:
        numeric, rows, lost = _numeric(path, how, names)
        text = [n for n in names if n not in numeric]
        columns: dict[str, Cells] = dict(numeric)
        if text:
            table = _opened(path, how, text, _Lost(how.skip_lines)).read_all()
            columns |= {n: Text(table.column(n), how.decimal) for n in text}
    except pa.ArrowInvalid as error:
        if "UTF" in str(error) and how.encoding == "utf-8":  # its last character is cut
            return _read(path, replace(how, encoding="latin-1"), asked)
        if how.quotes:
            return _read(path, replace(how, quotes=False), asked)
        if "skip initial" in str(error) or "Empty CSV" in str(error):
            raise BadInput("a header and no rows") from None
        raise BadInput(f"not CSV: {error}") from None
    except (OSError, LookupError, ValueError) as error:
        raise BadInput(f"not CSV: {quoted(error)}") from None
    return columns, rows, lost


def _numeric(path: Path, how: Dialect, names: list[str]) -> tuple[dict[str, Array], int, _Lost]:
    """The columns that hold nothing but numbers, block by block, so that no text is kept."""
    columns: dict[str, _Growing] = {n: _Growing() for n in names if how.decimal == "."}
    rows, lost = 0, _Lost(how.skip_lines)
    for batch in _opened(path, how, names, lost):
        rows += batch.num_rows
        for name in list(columns):
            numbers = _block(batch.column(name), whole=columns[name].whole)
            if numbers is None or not columns[name].take(numbers):
                del columns[name]  # read again as text
    return {name: column.values() for name, column in columns.items()}, rows, lost


class _Growing:
    """Numbers of a column so far, in one piece of memory: many small ones would fragment it."""

    def __init__(self) -> None:
        self._numbers: Array = np.empty(0, np.int64)
        self._count = 0

    @property
    def whole(self) -> bool:
        """Whether all so far are integers."""
        return self._numbers.dtype.kind == "i"

    def take(self, numbers: Array) -> bool:
        """Add a block; False where integers are too large to stand among numbers with fractions."""
        if self.whole and numbers.dtype.kind == "f":
            own = self.values()
            if len(own) and max(-int(own.min()), int(own.max())) >= 2**53:
                return False
            self._numbers = self._numbers.astype(np.float64)
        after = self._count + len(numbers)
        if after > len(self._numbers):
            grown = np.empty(2 * after, self._numbers.dtype)
            grown[: self._count] = self.values()
            self._numbers = grown
        self._numbers[self._count : after] = numbers
        self._count = after
        return True

    def values(self) -> Array:
        """The numbers."""
        return self._numbers[: self._count]


def _block(column: Plain, *, whole: bool) -> Array | None:
    """Numbers of one block: integers where all may be; None where one is anything else."""
    import pyarrow as pa
    import pyarrow.compute as pc

    for kind in (pa.int64(), pa.float64()) if whole else (pa.float64(),):
        try:
            cast = pc.cast(column, kind, memory_pool=pa.system_memory_pool())
            return np.asarray(cast.to_numpy(zero_copy_only=False))
        except pa.ArrowInvalid:
            continue
    return None


def _opened(path: Path, how: Dialect, names: list[str], lost: _Lost) -> Plain:
    """Arrow's reader of the named columns as text, block by block."""
    import pyarrow as pa
    import pyarrow.csv as arrow_csv

    return arrow_csv.open_csv(
        _transcoded(path, how.encoding) if how.encoding not in _BY_ARROW else path,
        read_options=arrow_csv.ReadOptions(
            use_threads=False, block_size=_BLOCK_BYTES, column_names=_unique(how.names),
            skip_rows=how.skip_lines,
            encoding=how.encoding if how.encoding in _BY_ARROW else "utf-8",
        ),
        parse_options=arrow_csv.ParseOptions(
            delimiter=how.delimiter, quote_char='"' if how.quotes else False,
            invalid_row_handler=lost.take,
        ),
        convert_options=arrow_csv.ConvertOptions(
            column_types=dict.fromkeys(names, pa.string()), include_columns=names,
            strings_can_be_null=False,
        ),
        memory_pool=pa.system_memory_pool(),  # which gives back what it no longer needs
    )  # fmt: skip


def _transcoded(path: Path, encoding: str) -> Plain:
    """A file in another encoding as UTF-8; what cannot be decoded becomes a question mark."""
    import pyarrow as pa

    text = path.read_bytes().decode(encoding, "replace").rstrip("\0\ufffd")
    return pa.BufferReader(text.encode())


def _unique(names: tuple[str, ...]) -> list[str]:
    """Names as Arrow wants them: blank ones are called by their place."""
    return [name or f"\0{i}" for i, name in enumerate(names)]
