"""Drawing the figures of a report: the figure itself, and curves of table columns over time.

Truth is black, estimators have the colour-blind safe palette.
"""

from __future__ import annotations

import html
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.report.palette import FIGURE, looks
from twin.report.printed import MM_PER_IN, WIDTHS_MM, legend_columns
from twin.scores.scores import seconds
from twin.streams import Table

Array = NDArray[Any]
Estimates = Mapping[str, Table]

WIDTH_IN, HEIGHT_IN = 5.6, 2.7
MOST_POINTS = 700
"""A line is thinned to this many points; the page shows no more."""
GAP_PERIODS = 5.0
STYLE: Any = FIGURE | {
    "svg.fonttype": "none",  # text stays text, in the page's own font
    "font.family": "sans-serif",
    "font.size": 10.0,
    "legend.fontsize": 9.0,
    "path.simplify": True,
}


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A figure of a report: for its page, and for print."""

    title: str
    draw: Callable[..., None]
    """Draws into one set of axes for each row."""
    rows: int = 1
    left: float = 0.14
    """Share of the width to the left of the axes, on the page."""
    height_in: float = HEIGHT_IN
    """Height of the first row [in]; each further one adds half of it."""
    above_in: float = 0.0
    """Room above the first axes for what stands there beside a legend [in], on the page."""
    columns: int = 1
    """Columns of a printed page that it spans."""

    def svg(self) -> str:
        """An SVG element for the page, with a title for screen readers."""
        with mpl.rc_context(STYLE):
            figure, axes = self._drawn(self.columns * WIDTH_IN)
            above_in = (
                self.above_in
                + 0.1
                + 0.2 * _legend(axes[0], (1.0 - self._left) * self.columns * WIDTH_IN)
            )
            below_in = 0.5 + 0.18 * axes[-1].get_xlabel().count("\n")
            height_in = self._height_in + max(0.0, above_in - 0.3) + max(0.0, below_in - 0.5)
            figure.set_figheight(height_in)
            figure.subplots_adjust(
                left=self._left,
                right=1.0 - 0.015 / self.columns,
                top=1.0 - above_in / height_in,
                bottom=below_in / height_in,
                hspace=0.3,
            )
            text = io.StringIO()
            metadata = {"Date": None, "Creator": None, "Format": None, "Type": None}
            figure.savefig(text, format="svg", metadata=metadata, transparent=True)
        element = text.getvalue()
        element = element[element.index("<svg") :]
        look = "figure" if self.columns == 1 else "figure spread"
        label = f'<svg role="img" aria-label="{html.escape(self.title)}" class="{look}" '
        return element.replace("<svg ", label, 1)

    def figure(self) -> Figure:
        """The figure in the style that is set, laid out for the size it is given."""
        width_in = WIDTHS_MM[self.columns] / MM_PER_IN
        figure, axes = self._drawn(width_in)
        figure.set_layout_engine("constrained")
        figure.set_figheight(0.85 * self._height_in)
        _legend(axes[0], 0.8 * width_in)
        return figure

    @property
    def _left(self) -> float:
        return self.left / self.columns

    @property
    def _height_in(self) -> float:
        return self.height_in * (1.0 + 0.5 * (self.rows - 1))

    def _drawn(self, width_in: float) -> tuple[Figure, list[Axes]]:
        figure = Figure(figsize=(width_in, self._height_in))
        axes = [figure.add_subplot(self.rows, 1, i + 1) for i in range(self.rows)]
        self.draw(*axes)
        return figure, axes


def svg(
    title: str,
    draw: Callable[..., None],
    rows: int = 1,
    *,
    left: float = 0.14,
    height_in: float = HEIGHT_IN,
) -> str:
    """A `Drawing` as an SVG element."""
    return Drawing(title=title, draw=draw, rows=rows, left=left, height_in=height_in).svg()


def _legend(axes: Axes, width_in: float) -> int:
    """Put a legend above the axes; how many lines it has."""
    handles, labels = axes.get_legend_handles_labels()
    named = [(h, label) for h, label in zip(handles, labels, strict=True) if label]
    if not named:
        return 0
    chosen, names = zip(*named, strict=True)
    ncols = legend_columns(names, width_in)
    place: Any = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.98), "borderaxespad": 0.0}
    axes.legend(chosen, names, ncols=ncols, handlelength=1.2, columnspacing=1.2, **place)
    return -(-len(names) // ncols)


def thinned(table: Table, most: int = MOST_POINTS) -> Table:
    """Every k-th row, about `most` of them, and a row of NaN in every gap of time.

    A gap is longer than GAP_PERIODS median periods of the table. No line is drawn across it, nor
    across as many unknown values of a column that lie between two of the rows.
    """
    epoch_ns = table["epoch_ns"]
    rows = np.arange(0, len(epoch_ns), max(1, len(epoch_ns) // most))
    steps_ns = np.diff(epoch_ns)
    if not len(steps_ns):
        return {name: column[rows] for name, column in table.items()}
    gaps = _between(rows, np.append(False, steps_ns > GAP_PERIODS * np.median(steps_ns)))
    holes = {name: _between(rows, _holes(column)) for name, column in table.items()}
    breaks = np.unique(np.concatenate([gaps, *holes.values()]))
    return {
        name: _with_gaps(column[rows], breaks, np.isin(breaks, [*gaps, *holes[name]]))
        for name, column in table.items()
    }


def _between(rows: Array, marked: Array) -> Array:
    """Places in `rows` before which, since the one before, something was marked."""
    return np.flatnonzero(np.diff(np.cumsum(marked)[rows])) + 1


def _holes(column: Array) -> Array:
    """The row after each run of at least GAP_PERIODS unknown values, marked. Shape (n,)."""
    marked = np.zeros(len(column), np.bool_)
    if column.dtype.kind == "f" and column.ndim == 1 and np.isnan(column).any():
        edges = np.flatnonzero(np.diff(np.isnan(column), prepend=False, append=False))
        first, after = edges[::2], edges[1::2]
        ends = after[after - first >= GAP_PERIODS]
        marked[ends[ends < len(column)]] = True
    return marked


def _with_gaps(column: Array, breaks: Array, unknown: Array) -> Array:
    """A column with a row before each break: NaN where it is unknown, else what follows."""
    between = column[breaks]
    if column.dtype.kind == "f" and column.ndim == 1:
        between = np.where(unknown, np.nan, between)
    return np.insert(column, breaks, between, axis=0) if column.ndim == 1 else column


def estimate_lines(
    axes: Axes, estimates: Estimates, column: str, sd: str, *, percent: bool = False
) -> None:
    """A column of every estimate, each with its band of two standard deviations."""
    scale = 100.0 if percent else 1.0
    for name, (colour, _, line_style) in looks(estimates).items():
        table = estimates[name]
        if column not in table or not len(table["epoch_ns"]):
            continue
        rows = thinned(table)
        time, middle = seconds(rows), scale * rows[column]
        if sd in rows:
            reach = 2.0 * scale * rows[sd]
            axes.fill_between(time, middle - reach, middle + reach, color=colour, alpha=0.18, lw=0)
        axes.plot(time, middle, line_style, color=colour, lw=0.8, label=name)


def line(
    axes: Axes,
    table: Table | None,
    column: str,
    label: str,
    colour: str,
    *,
    scale: float = 1.0,
    width: float = 1.0,
) -> None:
    """A column of one table, where it has it."""
    if table is None or column not in table:
        return
    rows = thinned(table)
    axes.plot(seconds(rows), scale * rows[column], color=colour, lw=width, label=label, zorder=3)


def columns(truth: Table | None, estimates: Estimates, column: str) -> list[Array]:
    """A column of every table that has it, truth first."""
    tables = [t for t in (truth, *estimates.values()) if t is not None]
    return [t[column] for t in tables if column in t]


def limits(axes: Axes, found: list[Array], scale: float) -> None:
    """Vertical limits from the bulk of the values, so one spike does not flatten the rest."""
    values = finite(np.concatenate(found)) if found else np.empty(0)
    if len(values):
        low, high = (scale * float(q) for q in np.quantile(values, (0.005, 0.995)))
        margin = 0.12 * max(high - low, 0.5)
        axes.set_ylim(low - margin, high + margin)


def as_map(axes: Axes) -> None:
    """A metre east as long as a metre north, and never less than 2 m of either."""
    middle = 0.5 * np.add(axes.dataLim.min, axes.dataLim.max)
    axes.update_datalim([middle - 1.0, middle + 1.0])
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")


def finite(values: Array) -> Array:
    """Those that are numbers."""
    return values[np.isfinite(values)]
