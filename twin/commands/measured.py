"""The result of a rig as files, as tables on the terminal and as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from twin.commands.tables import Column, print_table
from twin.io.atomic import moved_when_complete
from twin.io.plain import Plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Columns = Mapping[str, Plain]


@dataclass(frozen=True, kw_only=True)
class RigOptions:
    """Options of every `twin rig` command: how the result is shown."""

    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print the columns of every CSV as JSON instead of tables."""
    figures: Path | None = None
    """Folder for the figure as SVG and PDF, as wide as a printed page's text (175 mm)."""


@dataclass(frozen=True)
class RigResult:
    """The result of a virtual rig: its tables and its figure."""

    files: Mapping[str, Columns]
    """CSV name -> its columns."""
    shown: Sequence[Columns]
    """Tables for the terminal."""
    figure: str
    """File name of the figure."""
    draw: Callable[[], Figure]

    def write(self, folder: Path, figures: Path | None = None) -> list[Path]:
        """Write all files or none of them; their paths.

        Args:
            folder: of the tables and the figure as PNG.
            figures: folder of the figure as SVG and PDF; None for none.

        Raises:
            BadInput: a folder cannot be written.
        """
        from twin.report.printed import Picture, write_png, write_print
        from twin.rig.table import write_csv

        drawn = Picture(self.draw)
        with moved_when_complete(folder) as partial:
            for name, columns in self.files.items():
                write_csv(columns, partial / name)
            write_png(drawn, partial / self.figure)
        paths = [folder / name for name in (*self.files, self.figure)]
        if figures is None:
            return paths
        return paths + [figures / n for n in write_print({Path(self.figure).stem: drawn}, figures)]

    def to_json(self) -> str:
        """The columns of every file; what is not known is null."""
        return json.dumps(
            {
                name: {column: [_plain(v) for v in values] for column, values in columns.items()}
                for name, columns in self.files.items()
            }
        )


def _plain(value: Plain) -> float | None:
    return float(value) if math.isfinite(value) else None


def print_columns(columns: Columns) -> None:
    """Columns as a table; where there is no room the last are left out first."""
    print_table(
        [
            Column(heading=name.replace("_", " "), cells=[_text(v) for v in values], rank=rank)
            for rank, (name, values) in enumerate(columns.items())
        ]
    )


def _text(value: float) -> str:
    return "-" if math.isnan(value) else f"{round(value, 12) + 0.0:.4g}"
