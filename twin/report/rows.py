"""Reports of rows: checks with their tolerances, means with their intervals."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes

from twin.io.atomic import write_text
from twin.io.plain import Plain
from twin.report.draw import svg
from twin.report.html import document, figures, made_with, table
from twin.report.palette import TRUTH_COLOUR

Rows = Sequence[Mapping[str, Plain]]

BLUE, RED, GREY = "#0072B2", "#D55E00", "#e8e8e8"
BEYOND = 1.6
"""A value further outside its band than this is drawn here."""
ROW_IN, LABEL_LETTERS = 0.19, 32


def write_intervals(
    path: Path,
    title: str,
    about: str,
    rows: Rows,
    command: str,
    *,
    not_driven: Sequence[str] = (),
    colour_of: Mapping[str, str] | None = None,
) -> None:
    """Means with 95 % intervals: a figure for each quantity, a line for each case.

    Args:
        path: the .html file.
        title, about: heading, and what was done, in a sentence.
        rows: as `twin.io.result_rows` has them, the interval in `low` and `high`; a `bound` beside
            them is drawn as a line.
        command: the command that repeats it.
        not_driven: runs that did not drive their course, and how each ended.
        colour_of: case -> its colour in the figures.
    """
    palette = colour_of or {}
    quantities = list(dict.fromkeys(row["quantity"] for row in rows))
    drawn = [
        (_named(q, rows), interval_figure(q, [r for r in rows if r["quantity"] == q], palette), "")
        for q in quantities
    ]
    cases = list(dict.fromkeys(row["case"] for row in rows))
    cells = {(row["case"], row["quantity"]): row for row in rows}
    lines = [[case, *(_cell(cells.get((case, q))) for q in quantities)] for case in cases]
    parts = [
        f'<p class="soft">{html.escape(about)}</p>',
        table(["", *(_named(q, rows) for q in quantities)], lines),
        _listed(f"Not driven as planned: {len(not_driven)} runs", not_driven),
        figures(drawn),
        made_with(command),
    ]
    write_text(path, document(title, parts))


def _listed(heading: str, lines: Sequence[str]) -> str:
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return f"<h2>{heading}</h2><ul>{items}</ul>" if lines else ""


def write_checks(
    path: Path, title: str, about: str, sections: Mapping[str, Rows], command: str
) -> None:
    """Checks, each within its tolerance or not: a figure and a table for each section."""
    every = [row for rows in sections.values() for row in rows]
    failed = [row for row in every if not row.get("passed", True)]
    said = f"{len(every)} rows, {len(every) - len(failed)} pass, {len(failed)} fail. {about}"
    parts = [f'<p class="soft">{html.escape(said)}</p>']
    if failed:
        parts += ["<h2>Failed checks</h2>", _check_table(failed)]
    parts += [
        figures(
            (
                name,
                band_figure(rows),
                "Grey: the tolerance. Each dot is one row of the table below.",
            )
            for name, rows in sections.items()
            if rows
        )
    ]
    for name, rows in sections.items():
        if rows:
            parts.append(f"<h2>{html.escape(name)}</h2>{_check_table(rows)}")
    write_text(path, document(title, [*parts, made_with(command)]))


def interval_figure(quantity: str, rows: Rows, colour_of: Mapping[str, str]) -> str:
    """A dot and its interval for each case, in the case's colour."""
    names = [fill(row["case"], LABEL_LETTERS, break_on_hyphens=False) for row in rows]
    lines = max(name.count("\n") for name in names) + 1
    order = range(len(rows))[::-1]

    def draw(axes: Axes) -> None:
        for place, row in zip(order, rows, strict=True):
            mean = row["ours"]
            reach = [mean - row.get("low", mean)], [row.get("high", mean) - mean]
            colour = colour_of.get(row["case"], BLUE)
            axes.errorbar(mean, place, xerr=np.abs(reach), fmt="o", color=colour, capsize=3)
        bounds = {
            place: row["bound"] for place, row in zip(order, rows, strict=True) if "bound" in row
        }
        if bounds:
            ends = np.array([*bounds]) - 0.4, np.array([*bounds]) + 0.4
            axes.vlines([*bounds.values()], *ends, color=TRUTH_COLOUR, ls="--", label="bound")
        axes.set_yticks(list(order), names)
        axes.set_ylim(-0.6, len(rows) - 0.4)
        axes.grid(axis="y", visible=False)
        axes.set_xlabel(_unit(quantity, rows) or quantity)
        axes.locator_params(axis="x", nbins=4)

    longest = max(len(line) for name in names for line in name.split("\n"))
    left = min(0.7, 0.04 + 0.016 * longest)
    height_in = 0.9 + (1.0 + lines) * ROW_IN * len(rows)
    return svg(quantity, draw, left=left, height_in=height_in)


def band_figure(rows: Rows) -> str:
    """Place of each value in its tolerance: -1 and 1 are the ends, 0 the middle."""
    places = np.array([place_of(row) for row in rows])

    def draw(axes: Axes) -> None:
        axes.axvspan(-1.0, 1.0, color=GREY, lw=0)
        shown = np.clip(places, -BEYOND, BEYOND)
        for passed, colour, marker in ((True, BLUE, "o"), (False, RED, "D")):
            chosen = np.array([bool(row.get("passed", True)) is passed for row in rows])
            order = np.arange(len(rows))[::-1]
            axes.plot(shown[chosen], order[chosen], marker, color=colour, ms=4.0,
                      label="pass" if passed else "fail")  # fmt: skip
        axes.set(xlim=(-BEYOND - 0.1, BEYOND + 0.1), yticks=[], xlabel="place in the tolerance")
        axes.set_xticks([-1.0, 0.0, 1.0], ["low", "middle", "high"])
        axes.grid(False)

    return svg("Rows within their tolerance", draw, height_in=1.1 + 0.5 * ROW_IN * len(rows))


def ratio_figure(rows: Rows) -> str:
    """Each value over the published one, with its tolerance."""
    names = [fill(f"{row['case']}, {row['quantity']}", LABEL_LETTERS) for row in rows]
    lines = max(name.count("\n") for name in names) + 1
    published = np.array([float(row["published"]) for row in rows])
    ours = np.array([float(row["ours"]) for row in rows]) / published
    bounds = [[row.get(end, np.nan) for row in rows] for end in ("low", "high")]
    low, high = np.sort(np.array(bounds, float) / published, axis=0)  # NaN comes last

    def draw(axes: Axes) -> None:
        order = np.arange(len(rows))[::-1]
        axes.axvline(1.0, color="#666", lw=0.8)
        known = np.isfinite(low) & np.isfinite(high)
        width = (high - low)[known]
        axes.barh(order[known], width, left=low[known], color=GREY, height=0.8, zorder=0)
        for passed, colour, marker in ((True, BLUE, "o"), (False, RED, "D")):
            chosen = np.array([bool(row.get("passed", True)) is passed for row in rows])
            axes.plot(ours[chosen], order[chosen], marker, color=colour, ms=4.0)
        axes.set_yticks(order, names)
        axes.set_ylim(-0.7, len(rows) - 0.3)
        axes.set_xlabel("ours over published")
        axes.grid(axis="y", visible=False)

    return svg("Ours over published", draw, left=0.5, height_in=0.9 + lines * ROW_IN * len(rows))


def place_of(row: Mapping[str, Plain]) -> float:
    """-1 at the low end of the tolerance, 1 at the high one; a single bound is one of them."""
    low, high, ours = row.get("low"), row.get("high"), float(row["ours"])
    if low is not None and high is not None:
        half = max(0.5 * (high - low), 1e-12)
        return float((ours - 0.5 * (low + high)) / half)
    bound = high if high is not None else low
    if bound is None:
        return 0.0
    size = max(abs(bound), 1e-12)
    if high is not None:
        return float(max(-1.0, 1.0 - 2.0 * (bound - ours) / size))
    return float(min(1.0, 2.0 * (ours - bound) / size - 1.0))


def _check_table(rows: Rows) -> str:
    lines = [
        [
            row["case"],
            row["quantity"],
            _number(row["ours"]),
            _number(row.get("published", row.get("reference"))),
            _tolerance(row),
            "" if row.get("unit", "1") == "1" else str(row["unit"]),
            {True: "pass", False: "FAIL", None: "-"}[row.get("passed")],
        ]
        for row in rows
    ]
    return table(["case", "quantity", "ours", "reference", "tolerance", "unit", ""], lines, names=2)


def _tolerance(row: Mapping[str, Plain]) -> str:
    low, high = row.get("low"), row.get("high")
    if low is not None and high is not None:
        return f"{_number(low)} to {_number(high)}"
    if high is not None:
        return f"at most {_number(high)}"
    return "" if low is None else f"at least {_number(low)}"


def _number(value: Plain) -> str:
    return "" if value is None else f"{value:.4g}"


def _cell(row: Mapping[str, Plain] | None) -> str:
    if row is None:
        return ""
    half = 0.5 * (row.get("high", row["ours"]) - row.get("low", row["ours"]))
    return f"{row['ours']:.3f} ± {half:.3f}"


def _named(quantity: str, rows: Rows) -> str:
    unit = _unit(quantity, rows)
    return f"{quantity.replace('_', ' ')}{f' [{unit}]' if unit else ''}"


def _unit(quantity: str, rows: Rows) -> str:
    unit = next(str(row.get("unit", "1")) for row in rows if row["quantity"] == quantity)
    return "" if unit == "1" else unit
