"""The page of two drives beside each other: what they are, a table, figures of both."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from twin.io.atomic import write_text
from twin.logs.activity import PULLS, Pull
from twin.report.draw import Array, Drawing, finite
from twin.report.html import document, figures, made_with, table
from twin.report.log_figures import LEAST_IN_BIN, binned, blocks
from twin.streams import Table

LOOKS = (("A", "#D55E00", "-"), ("B", "#0072B2", "--"))
"""Name, colour and line of each of the two."""


@dataclass(frozen=True)
class Side:
    """One of the two, as the page shows it."""

    about: str
    """What it is, in a sentence."""
    rows: Table
    """Of `twin.logs.timeline.timeline`."""
    chosen: NDArray[np.bool_]
    """The rows that are compared. Shape (n,)."""
    slip_of: str
    """Whose slip the figures show."""


def write(
    path: Path,
    sides: tuple[Side, Side],
    *,
    title: str,
    headers: Sequence[str],
    lines: Sequence[Sequence[str]],
    where: str,
    notes: Sequence[str],
    command: str,
) -> None:
    """Write the page.

    Args:
        path: the .html file.
        sides: the two.
        title: heading.
        headers, lines: the table, as text.
        where: which rows are compared, in words.
        notes: what a reader should know.
        command: the command that repeats it.

    Raises:
        BadInput: the file cannot be written.
    """
    about = [f"{name}: {side.about}" for (name, *_), side in zip(LOOKS, sides, strict=True)]
    drawn = drawings(sides, where)
    parts = [
        *(f'<p class="soft">{html.escape(line)}</p>' for line in (*about, f"Compared {where}.")),
        table(headers, lines),
        figures((heading, drawing.svg(), _caption(sides)) for heading, drawing in drawn.items()),
        _listed(notes),
        made_with(command),
    ]
    write_text(path, document(title, parts))


def drawings(sides: tuple[Side, Side], where: str) -> dict[str, Drawing]:
    """Heading -> figure, those for which both have the quantity."""
    found = {
        "Slip over time": _over_time(sides, where),
        "Distribution of slip": _distribution(sides, "slip", 100.0, f"slip {where} [%]"),
        "Distribution of ground speed": _distribution(
            sides, "speed_mps", 3.6, f"ground speed {where} [km/h]"
        ),
        **{
            f"Slip against {pull.name}": _against(sides, pull) for pull in PULLS if not pull.lowered
        },
    }
    return {heading: drawing for heading, drawing in found.items() if drawing is not None}


def _values(side: Side, *columns: str) -> tuple[Array, ...]:
    """Columns in the rows that are compared and in which all are known."""
    if not set(columns) <= set(side.rows):
        return tuple(np.empty(0) for _ in columns)
    known = side.chosen & np.all([np.isfinite(side.rows[c]) for c in columns], axis=0)
    return tuple(side.rows[c][known] for c in columns)


def _each(sides: tuple[Side, Side]) -> Iterable[tuple[Side, str, str, str]]:
    return ((side, *look) for side, look in zip(sides, LOOKS, strict=True))


def _over_time(sides: tuple[Side, Side], where: str) -> Drawing | None:
    """Slip over the time that is compared, breaks left out; dots, so that no line crosses one."""
    if any(not len(_values(side, "slip")[0]) for side in sides):
        return None

    def draw(axes: Axes) -> None:
        ends = []
        for side, name, colour, _ in _each(sides):
            time_s = np.cumsum(side.rows["duration_s"][side.chosen])
            slip = 100.0 * side.rows["slip"][side.chosen]
            middle, level, *_ = blocks(time_s, slip, float(time_s[-1]))
            axes.plot(middle, level, ".", color=colour, ms=3.0, label=name)
            ends += list(np.quantile(finite(level), (0.01, 0.99)))
        margin = 0.15 * max(max(ends) - min(ends), 1.0)
        axes.set_ylim(min(ends) - margin, max(ends) + margin)
        axes.set(xlabel=f"time {where} [s]", ylabel="slip [%]")

    return Drawing(title="Slip of both over time", draw=draw, columns=2)


def _distribution(
    sides: tuple[Side, Side], column: str, scale: float, label: str
) -> Drawing | None:
    """Share of the compared time by value, in common bins."""
    values = [scale * _values(side, column)[0] for side in sides]
    if any(not len(each) for each in values):
        return None
    low, high = np.quantile(np.concatenate(values), (0.002, 0.998))
    reach = max(float(high - low), 0.5)
    edges = np.linspace(low - 0.05 * reach, high + 0.05 * reach, 41)

    def draw(axes: Axes) -> None:
        for each, (name, colour, style) in zip(values, LOOKS, strict=True):
            counts, _ = np.histogram(each, edges)
            share = 100.0 * counts / len(each)
            axes.stairs(share, edges, color=colour, ls=style, lw=1.4, label=name)
        axes.set(xlabel=label, ylabel="time compared [%]")

    return Drawing(title=f"Distribution of {column} of both", draw=draw)


def _against(sides: tuple[Side, Side], pull: Pull) -> Drawing | None:
    """Slip against draft, torque or load: medians and 5 to 95 % in bins of equal count."""
    pairs = [_values(side, pull.column, "slip") for side in sides]
    if any(len(at) < LEAST_IN_BIN for at, _ in pairs):
        return None

    def draw(axes: Axes) -> None:
        for (at, slip), (name, colour, style) in zip(pairs, LOOKS, strict=True):
            middle, level, below, above = binned(pull.scale * at, 100.0 * slip)
            bars: Any = {"color": colour, "ms": 4.0, "lw": 1.1, "capsize": 2.5, "label": name}
            axes.errorbar(middle, level, (level - below, above - level), fmt="o" + style, **bars)
        axes.set(xlabel=f"{pull.name} [{pull.unit}]", ylabel="slip [%]")

    return Drawing(title=f"Slip of both against {pull.name}", draw=draw)


def _caption(sides: tuple[Side, Side]) -> str:
    return f"A's slip is {sides[0].slip_of}, B's is {sides[1].slip_of}."


def _listed(notes: Sequence[str]) -> str:
    items = "".join(f"<li>{html.escape(line)}</li>" for line in notes)
    return f"<h2>Notes</h2><ul>{items}</ul>" if notes else ""


def summary(about: Mapping[str, object]) -> str:
    """What one of the two is, in a sentence."""
    name = about["name"] or "a log"
    seed = "" if about["seed"] is None else f", seed {about['seed']}"
    return f"{about['folder']} ({name}{seed}, {about['kind']}, {about['machine']})"
