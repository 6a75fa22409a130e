"""An experiment's report: what is reached and why, figures like the paper's, every row."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from twin.io.atomic import write_text
from twin.io.result_rows import Row, Rows
from twin.report.html import document, made_with, table
from twin.report.rows import band_figure, ratio_figure

PIVOTED = ("MAE", "RMSE", "RMSE from 1 s", "max", "bias")
"""Quantities of several methods, as `RMSE, KF`: a line for each method."""


@dataclass(frozen=True, kw_only=True)
class Story:
    """What an experiment has to say beside its rows."""

    paragraphs: tuple[str, ...]
    figures: tuple[tuple[str, Callable[[], str]], ...] = ()
    """Caption, and what draws the figure as an SVG element."""


def write(path: Path, title: str, rows: Rows, story: Story, command: str = "") -> None:
    """Write the report as one HTML page, no network; `command` is what repeats it."""
    write_text(path, page(title, rows, story, command))


def page(title: str, rows: Rows, story: Story, command: str = "") -> str:
    """The whole page as HTML text."""
    figures = "".join(
        f"<figure>{draw()}<figcaption>{html.escape(caption)}</figcaption></figure>"
        for caption, draw in story.figures or _usual(rows)
    )
    parts = [
        *(f"<p>{html.escape(text)}</p>" for text in story.paragraphs),
        f'<div class="figures">{figures}</div>' if figures else "",
        *(_section(case, found) for case, found in _cases(rows).items()),
        made_with(command),
    ]
    return document(title, parts)


def _usual(rows: Rows) -> list[tuple[str, Callable[[], str]]]:
    """The figures of an experiment that has none of its own."""
    beside = [row for row in rows if row.get("published")]
    promised = [row for row in rows if "passed" in row]
    found: list[tuple[str, Callable[[], str]]] = []
    if beside:
        caption = "Ours over what was published; grey is what is promised."
        found.append((caption, partial(ratio_figure, beside)))
    if promised:
        caption = "Each row with a promise, in the order of the tables; grey is what is promised."
        found.append((caption, partial(band_figure, promised)))
    return found


def _cases(rows: Rows) -> dict[str, Rows]:
    out: dict[str, Rows] = {}
    for row in rows:
        out.setdefault(row["case"], []).append(row)
    return out


def _section(case: str, rows: Rows) -> str:
    """Methods as lines and quantities as columns, and below it the quantities of no one method."""
    methods: dict[str, dict[str, Row]] = {}
    rest = []
    for row in rows:
        quantity, _, method = row["quantity"].partition(", ")
        if method and quantity in PIVOTED:
            methods.setdefault(method, {})[quantity] = row
        else:
            rest.append(row)
    parts = [f"<h2>{html.escape(case)}</h2>"]
    if methods:
        parts.append(_pivot(methods))
    if rest:
        lines = (
            [row["quantity"], _cell(row), _published(row), _unit(row), _promise(row)]
            for row in rest
        )
        parts.append(table(["quantity", "ours", "published", "unit", "promised"], lines))
    return "".join(parts)


def _pivot(methods: Mapping[str, Mapping[str, Row]]) -> str:
    """A column for each quantity, and one beside it where something was published of it."""
    headers, columns = ["method"], [list(methods)]
    for quantity in PIVOTED:
        found = [of.get(quantity) for of in methods.values()]
        if any(found):
            headers.append(quantity)
            columns.append([_cell(row) for row in found])
        if any(row and "published" in row for row in found):
            headers.append("published")
            columns.append([_published(row) for row in found])
    return table(headers, zip(*columns, strict=True))


def _cell(row: Row | None) -> str:
    """`0.0267 ± 0.0003`, half the 95 % interval; the value alone where low and high are bounds."""
    if row is None:
        return "-"
    text = _number(row["ours"])
    if "passed" not in row and {"low", "high"} <= row.keys():
        text += f" ± {_number(0.5 * (row['high'] - row['low']))}"
    return text


def _number(value: float) -> str:
    """Four digits, and no power of ten for what is written without one."""
    return f"{value:.4f}" if 1e-4 <= abs(value) < 1.0 else f"{value:.4g}"


def _unit(row: Row) -> str:
    return "" if row.get("unit", "1") == "1" else str(row["unit"])


def _published(row: Row | None) -> str:
    return _number(row["published"]) if row and "published" in row else ""


def _promise(row: Row) -> str:
    if "passed" not in row:
        return ""
    ends = [("at least", row.get("low")), ("at most", row.get("high"))]
    said = " and ".join(f"{word} {end:.4g}" for word, end in ends if end is not None)
    return f"{said}: {'reached' if row['passed'] else 'not reached'}"
