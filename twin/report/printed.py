"""Figures as files: PNG for the screen, SVG and PDF at the width of a journal's columns."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import matplotlib as mpl
from matplotlib.figure import Figure

from twin.io.atomic import moved_when_complete, write_bytes
from twin.io.plain import Plain
from twin.report.palette import FIGURE

MM_PER_IN = 25.4
WIDTHS_MM = {1: 85.0, 2: 175.0}
"""Columns of a page that a figure spans -> its width."""
SCREEN: Any = FIGURE | {
    "font.size": 9.0,
    "figure.titlesize": 10.5,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "savefig.dpi": 130,
}
"""Style of figures as files of pixels."""
PRINT: Any = FIGURE | {
    "font.size": 8.0,
    "figure.titlesize": 8.0,
    "axes.titlesize": 8.0,
    "axes.titlelocation": "left",
    "legend.fontsize": 7.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "lines.linewidth": 1.0,
    "lines.markersize": 3.0,
    "pdf.fonttype": 42,  # text stays text
    "svg.hashsalt": "tractor-twin",  # the same figure, the same file
}
"""Style of figures at print size: no text is smaller than 7 pt."""


class Printable(Protocol):
    """A figure that can be drawn in any style."""

    @property
    def columns(self) -> int:
        """Columns of a page that it spans in print: 1 or 2."""

    def figure(self) -> Figure:
        """Draw it in the style that is set."""


def write_png(drawn: Printable, path: Path) -> None:
    """Write a figure as PNG."""
    with mpl.rc_context(SCREEN):
        _write(drawn.figure(), path, {})


def write_print(drawn: Mapping[str, Printable], folder: Path) -> list[str]:
    """Write NAME.svg and NAME.pdf of each figure into a folder, all or none; the file names.

    Raises:
        BadInput: the folder cannot be written.
    """
    with moved_when_complete(folder) as partial:
        names = [at_print_size(one, partial / stem) for stem, one in drawn.items()]
        return sorted(name for pair in names for name in pair)


def at_print_size(drawn: Printable, stem: Path) -> list[str]:
    """Write `stem`.svg and `stem`.pdf, as wide as the columns it spans; the file names."""
    with mpl.rc_context(PRINT):
        figure = drawn.figure()
        width_in = WIDTHS_MM[drawn.columns] / MM_PER_IN
        least_in = 0.7 * width_in / drawn.columns
        height_in = figure.get_figheight() * width_in / figure.get_figwidth()
        figure.set_size_inches(width_in, max(height_in, least_in))
        undated: dict[str, dict[str, Plain]] = {
            "svg": {"Date": None},
            "pdf": {"CreationDate": None},
        }
        for kind, metadata in undated.items():
            _write(figure, stem.with_name(f"{stem.name}.{kind}"), metadata)
    return [f"{stem.name}.{kind}" for kind in undated]


def _write(figure: Figure, path: Path, metadata: dict[str, Plain]) -> None:
    """Write a figure as its file's suffix says; encoded first, as encoders hide a full disk."""
    encoded = io.BytesIO()
    figure.savefig(encoded, format=path.suffix[1:], metadata=metadata)
    write_bytes(path, encoded.getvalue())


def legend_columns(labels: Sequence[str], width_in: float) -> int:
    """How many labels of a legend stand beside each other in a width, in the style that is set."""
    size_pt = _points(mpl.rcParams["legend.fontsize"])
    longest = max(map(len, labels))
    fitting = math.floor(72.0 * width_in / (size_pt * (2.6 + 0.55 * longest)))
    return max(1, min(fitting, len(labels)))


def _points(size: Any) -> float:
    return float(size) if isinstance(size, (int, float)) else 0.833 * mpl.rcParams["font.size"]


@dataclass(frozen=True)
class Picture:
    """A figure that a function draws, at the size it likes."""

    build: Callable[[], Figure]
    columns: int = 2

    def figure(self) -> Figure:
        """Draw it in the style that is set."""
        return self.build()
