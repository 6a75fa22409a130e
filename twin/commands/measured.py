"""What a rig measured: its files, the tables on the terminal, and the same as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from twin.commands.terminal import console
from twin.errors import BadInput
from twin.io.atomic import moved_when_complete

Columns = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Talk:
    """What is said of what was measured."""

    quiet: bool = False
    """Say nothing but errors."""
    json: bool = False
    """Print the columns of every CSV as JSON instead of tables."""


@dataclass(frozen=True)
class Measured:
    """What a rig found."""

    files: Mapping[str, Columns]
    """CSV name -> its columns."""
    shown: Sequence[Columns]
    """What the terminal shows."""
    figure: str
    draw: Callable[[Path], None]

    def write(self, folder: Path) -> list[Path]:
        """Write all files or none of them; their paths. Raises BadInput."""
        from twin.rig.table import write_csv

        try:
            with moved_when_complete(folder) as partial:
                for name, columns in self.files.items():
                    write_csv(columns, partial / name)
                self.draw(partial / self.figure)
        except OSError as error:
            raise BadInput(f"--out {folder} cannot be written: {error.strerror}") from None
        return [folder / name for name in (*self.files, self.figure)]

    def to_json(self) -> str:
        """The columns of every file; what is not known is null."""
        return json.dumps(
            {
                name: {column: [_plain(v) for v in values] for column, values in columns.items()}
                for name, columns in self.files.items()
            }
        )


def _plain(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None


def print_columns(columns: Columns) -> None:
    """Columns as a table."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in columns:
        table.add_column(name, justify="right")
    for row in zip(*columns.values(), strict=True):
        table.add_row(*("-" if math.isnan(v) else f"{round(v, 12) + 0.0:.4g}" for v in row))
    console().print(table)
