"""CSV: a header, then rows of as many cells. Arrow cuts it; a row that cannot be cut is left out."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.cells import Text, quoted
from twin.logs.losses import Loss
from twin.logs.reader import Reader
from twin.logs.readers.dialect import Dialect, dialect
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal

_BLOCK_BYTES = 1 << 22


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
        table, lost = _read(path, how, reading.columns)
        rows = table.num_rows + len(lost.numbers)
        if not table.num_rows:
            raise BadInput("a header and no rows" if not lost.numbers else lost.says(how))
        notes = []
        if how.preamble:
            notes.append(f"{how.preamble} lines before the header left out")
        if how.encoding not in ("utf-8", "utf-16") and not reading.encoding:
            notes.append(f"text read as {how.encoding}; encoding in [log] says another")
        if how.decimal == "," and not reading.decimal:
            notes.append("decimal comma")
        columns = {name: Signal(np.empty(0)) for name in how.names if name}
        columns |= {n: Signal(Text(table.column(n), how.decimal)) for n in table.column_names}
        numbers = np.array(lost.numbers, np.int64)
        loss = [Loss("log", numbers, rows, lost.says(how))] if len(numbers) else []
        row = np.setdiff1d(np.arange(1, rows + 1), numbers) if len(numbers) else None
        return Found(signals=columns, losses=tuple(loss), notes=tuple(notes), row=row)


@dataclass
class _Lost:
    """Rows that have too many or too few cells."""

    skipped: int
    """Rows of the file before the first of the table."""
    numbers: list[int] = field(default_factory=list)
    cells: int = 0

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


def _read(path: Path, how: Dialect, asked: frozenset[str] | None) -> tuple[Plain, _Lost]:
    """The columns as text; of a file whose quotes do not close, with the quotes as text."""
    import pyarrow as pa
    import pyarrow.csv as arrow_csv

    names = [n for n in how.names if n and (asked is None or n in asked)] or [how.names[0]]
    lost = _Lost(how.skip_lines)
    try:
        table = arrow_csv.open_csv(
            path,
            read_options=arrow_csv.ReadOptions(
                use_threads=False, block_size=_BLOCK_BYTES, column_names=_unique(how.names),
                skip_rows=how.skip_lines, encoding=how.encoding,
            ),
            parse_options=arrow_csv.ParseOptions(
                delimiter=how.delimiter, quote_char='"' if how.quotes else False,
                invalid_row_handler=lost.take,
            ),
            convert_options=arrow_csv.ConvertOptions(
                column_types=dict.fromkeys(names, pa.string()), include_columns=names,
                strings_can_be_null=False,
            ),
        ).read_all()  # fmt: skip
    except pa.ArrowInvalid as error:
        if "UTF" in str(error) and how.encoding == "utf-8":
            return _read(path, replace(how, encoding="cp1252"), asked)
        if how.quotes:
            return _read(path, replace(how, quotes=False), asked)
        if "skip initial" in str(error):
            raise BadInput("a header and no rows") from None
        raise BadInput(f"not CSV: {error}") from None
    except (OSError, LookupError, ValueError) as error:
        raise BadInput(f"not CSV: {quoted(error)}") from None
    return table, lost


def _unique(names: tuple[str, ...]) -> list[str]:
    """Names as Arrow wants them: blank ones are called by their place."""
    return [name or f"\0{i}" for i, name in enumerate(names)]
