"""Drawing as inline SVG: the figure itself, and lines of tables over time.

Truth is black, estimators in the colour-blind safe palette.
"""

from __future__ import annotations

import html
import io
from collections.abc import Callable, Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.report.palette import FIGURE, colours
from twin.scores.scores import seconds
from twin.streams import Table

Array = NDArray[Any]
Estimates = Mapping[str, Table]

WIDTH_IN, HEIGHT_IN = 5.6, 2.7
MOST_POINTS = 700
"""A line is thinned to this many points; the page shows no more."""
STYLE: Any = FIGURE | {
    "svg.fonttype": "none",  # text stays text, in the page's own font
    "font.family": "sans-serif",
    "font.size": 10.0,
    "legend.fontsize": 9.0,
    "path.simplify": True,
}


def svg(
    title: str,
    draw: Callable[..., None],
    rows: int = 1,
    *,
    left: float = 0.14,
    height_in: float = HEIGHT_IN,
) -> str:
    """Draw into a fresh figure and give it as an SVG element with a title for screen readers."""
    height_in *= 1.0 + 0.5 * (rows - 1)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, height_in))
        axes = [figure.add_subplot(rows, 1, i + 1) for i in range(rows)]
        draw(*axes)
        _legend(axes[0])
        figure.subplots_adjust(
            left=left,
            right=0.985,
            top=1.0 - 0.28 / height_in,
            bottom=0.5 / height_in,
            hspace=0.3,
        )
        text = io.StringIO()
        metadata = {"Date": None, "Creator": None, "Format": None, "Type": None}
        figure.savefig(text, format="svg", metadata=metadata, transparent=True)
    element = text.getvalue()
    element = element[element.index("<svg") :]
    label = f'<svg role="img" aria-label="{html.escape(title)}" class="figure" '
    return element.replace("<svg ", label, 1)


def _legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    named = [(h, label) for h, label in zip(handles, labels, strict=True) if label]
    if named:
        chosen, names = zip(*named, strict=True)
        place: Any = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.98), "borderaxespad": 0.0}
        axes.legend(chosen, names, ncols=5, handlelength=1.2, columnspacing=1.2, **place)


def thinned(table: Table, most: int = MOST_POINTS) -> Table:
    """Every k-th row, at most about `most` of them."""
    stride = max(1, len(table["epoch_ns"]) // most)
    return {name: column[::stride] for name, column in table.items()}


def estimate_lines(
    axes: Axes, estimates: Estimates, column: str, sd: str, *, percent: bool = False
) -> None:
    """A column of every estimate, each with its band of two standard deviations."""
    scale = 100.0 if percent else 1.0
    for name, colour in colours(estimates).items():
        table = estimates[name]
        if column not in table or not len(table["epoch_ns"]):
            continue
        rows = thinned(table)
        time, middle = seconds(rows), scale * rows[column]
        if sd in rows:
            reach = 2.0 * scale * rows[sd]
            axes.fill_between(time, middle - reach, middle + reach, color=colour, alpha=0.18, lw=0)
        axes.plot(time, middle, color=colour, lw=0.8, label=name)


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
    """A column of every table that has it."""
    tables = [t for t in (truth, *estimates.values()) if t is not None]
    return [t[column] for t in tables if column in t]


def limits(axes: Axes, found: list[Array], scale: float) -> None:
    """Vertical limits from the bulk of the values, so one spike does not flatten the rest."""
    values = finite(np.concatenate(found)) if found else np.empty(0)
    if len(values):
        low, high = scale * np.quantile(values, [0.005, 0.995])
        margin = 0.12 * max(high - low, 0.5)
        axes.set_ylim(low - margin, high + margin)


def widen(axes: Axes) -> None:
    """Never show less than 2 m of north or east: a straight line is not a zigzag."""
    for get, put in ((axes.get_xlim, axes.set_xlim), (axes.get_ylim, axes.set_ylim)):
        low, high = get()
        spare = max(0.0, 2.0 - (high - low)) / 2.0
        put(low - spare, high + spare)


def finite(values: Array) -> Array:
    """Those that are numbers."""
    return values[np.isfinite(values)]
