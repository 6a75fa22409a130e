"""Parquet: columns of numbers, timestamps or text. Nothing in a file is ever unpickled."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.cells import Cells, Text, quoted
from twin.logs.reader import Reader
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal


class Parquet(Reader):
    """A Parquet file."""

    name = "Parquet"

    def fits(self, path: Path, head: bytes) -> bool:
        """Whether it is a Parquet file, by its first bytes or its suffix."""
        named = path.suffix.lower() in (".parquet", ".pq")
        return not path.is_dir() and (named or head.startswith(b"PAR1"))

    def found(self, path: Path, reading: Reading) -> Found:
        """Each column as a signal, by name.

        Raises:
            BadInput: the file is damaged or has no rows, or two columns have one name.
        """
        columns = read_parquet(path, reading.columns)
        return Found(signals={name: Signal(cells) for name, cells in columns.items()})


def read_parquet(path: Path, asked: frozenset[str] | None = None) -> dict[str, Cells]:
    """The columns by name. Raises BadInput for a file that is not whole, and for no rows."""
    import pyarrow as pa  # lazily: 0.1 s that a CSV does not need
    import pyarrow.parquet as pq

    if path.stat().st_size == 0:
        raise BadInput("the file is empty")
    try:
        # arrow_extensions_enabled=False: an extension type stays its plain storage
        file = pq.ParquetFile(path, arrow_extensions_enabled=False)
        names = file.schema_arrow.names
        if len(set(names)) < len(names):
            twice = next(n for n in names if names.count(n) > 1)
            raise BadInput(f"two columns are called {quoted(twice)}")
        table = file.read(None if asked is None else [n for n in names if n in asked])
        rows = file.metadata.num_rows
    except (pa.ArrowException, OSError, ValueError, KeyError, MemoryError) as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(f"not a whole Parquet file: {error}") from None
    if rows == 0:
        raise BadInput("columns and no rows")
    absent: dict[str, Cells] = {n: np.empty(0) for n in names if n not in table.column_names}
    return absent | {n: _cells(pa, n, table.column(n)) for n in table.column_names}


def _cells(pa: Plain, name: str, column: Plain) -> Cells:
    kind = column.type
    try:
        if pa.types.is_dictionary(kind):
            column, kind = column.cast(kind.value_type), kind.value_type
        if pa.types.is_string(kind) or pa.types.is_large_string(kind):
            return Text(column.cast(pa.string()).fill_null(""))
        if pa.types.is_timestamp(kind):
            return np.asarray(column.cast(pa.timestamp("ns")).to_numpy(), "datetime64[ns]")
        if pa.types.is_decimal(kind):
            column = column.cast(pa.float64())
        if pa.types.is_boolean(kind):
            column = column.cast(pa.int8())
        if not pa.types.is_primitive(column.type):
            return np.full(len(column), kind, dtype=object)  # refused if it is asked for
        return np.asarray(column.to_numpy())
    except (pa.ArrowException, UnicodeDecodeError, ValueError, TypeError) as error:
        raise BadInput(f"column {quoted(name)}: {error}") from None
