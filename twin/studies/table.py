"""All parts of a plan as one table, in the order of the plan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from twin.errors import BadInput
from twin.io.atomic import written_when_complete
from twin.plugins.lookup import line
from twin.studies.plan import Case

AT_ONCE = 256
"""Parts that are joined at a time."""


def read(cases: Sequence[Case], folder: Path) -> Any:
    """The rows of every part, as a pyarrow Table; a column that a part lacks is null there.

    Raises:
        BadInput: a part is missing or damaged; says which.
    """
    import pyarrow as pa

    def joined(tables: list[Any]) -> Any:
        return pa.concat_tables(tables, promote_options="permissive").combine_chunks()

    held: list[Any] = []
    for start in range(0, len(cases), AT_ONCE):  # a table of one row takes far more than its row
        held.append(joined([_part(folder / c.part) for c in cases[start : start + AT_ONCE]]))
    return joined(held)


def _part(path: Path) -> Any:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return pq.ParquetFile(path).read()
    except FileNotFoundError:
        raise BadInput(f"{path} is missing; the same command does that run") from None
    except (pa.ArrowException, OSError, ValueError) as error:
        text = f"{path} is not a whole Parquet file: {line(error)}"
        raise BadInput(f"{text}; delete it, and the same command repeats its run") from None


def failed(cases: Sequence[Case], folder: Path) -> list[Path]:
    """Parts that hold an error."""
    import pyarrow.parquet as pq

    def fails(path: Path) -> bool:
        column = pq.ParquetFile(path).read(columns=["error"])["error"]
        return bool(column.null_count < len(column))

    paths = [folder / case.part for case in cases]
    return [path for path in paths if path.exists() and fails(path)]


def write_table(table: Any, path: Path) -> None:
    """A table as one Parquet file, in place of an earlier one only when whole."""
    import pyarrow.parquet as pq

    with written_when_complete(path) as partial:
        pq.write_table(table, partial, compression="zstd")
