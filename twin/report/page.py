"""The page: scores, figures, the scenario, and the command that repeats the run."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twin.io.atomic import write_text
from twin.io.plain import Plain, to_plain
from twin.io.run_folder import RunLike
from twin.plugins.lookup import Thing
from twin.report import errors, figures
from twin.report.draw import Drawing
from twin.report.html import document, made_with, table
from twin.report.html import figures as figures_of
from twin.scores.table import (
    COVERAGE,
    HEADERS,
    PHASE_RANKS,
    end_lines,
    left_out_lines,
    phase_rows,
    score_rows,
    zero_line,
)

if TYPE_CHECKING:
    from twin.report.log_page import Figure

SLIP_OVER_TIME = (
    "Black: truth. Bands: ±2 reported standard deviations; about the truth, ±2 of the causal "
    "bound. Light grey: what is scored."
)
ERROR_OVER_TIME = (
    "RMS over blocks of time. The bounds are the smallest errors that sensors and motion allow, "
    "from past samples (causal) or from all samples (offline). They contain no bias."
)
CONSISTENCY = (
    "Mean squared error over reported variance. Above 1 the reported standard deviation is too "
    "small, below 1 too large."
)


def write(run: RunLike, scores: Mapping[str, Plain], path: Path, command: str = "") -> None:
    """Write the report of a run.

    Args:
        run: the run.
        scores: as made by `twin.scores.scores.score`.
        path: the .html file.
        command: the command that repeats it; made of name and seed where none is given.
    """
    write_text(path, page(run, scores, command))


def page(run: RunLike, scores: Mapping[str, Plain], command: str = "") -> str:
    """The whole page as HTML text."""
    name = str(scores.get("scenario") or "log")
    seed = scores.get("seed")
    title = name if seed is None else f"{name}, seed {seed}"
    top, tables, notes = "", "", _notes(scores)
    if run.scenario is None:
        top, tables, notes = _of_a_log(run, scores)
    parts = [
        f'<p class="soft">{html.escape(_what(run, scores))}</p>',
        *(f'<p class="ended">{html.escape(line)}</p>' for line in end_lines(scores)),
        top,
        _driven(scores.get("truth") or {}),
        _headline(scores),
        tables,
        figures_of(
            (title, drawn.svg(), caption)
            for title, drawn, caption in _figures(run, scores)
            if drawn
        ),
        notes,
        _parameters(run.scenario),
        _again(name, seed, run.scenario, command),
    ]
    return document(title, parts)


def drawings(run: RunLike, scores: Mapping[str, Plain]) -> dict[str, Drawing]:
    """The figures of the page by file name without its ending, as `slip-error`."""
    return {
        title.lower().replace(" ", "-"): drawn
        for title, drawn, _ in _figures(run, scores)
        if drawn is not None
    }


def _of_a_log(run: RunLike, scores: Mapping[str, Plain]) -> tuple[str, str, str]:
    """Headline, tables and notes that the page of a log has in place of a run's."""
    from twin.report import log_page  # slow to import, and a run needs it not

    origin = run.setup.origin
    return log_page.headline(scores), log_page.tables(scores, origin), log_page.assumed(scores)


def _what(run: RunLike, scores: Mapping[str, Plain]) -> str:
    window = scores.get("window_s")
    scored = f"scored from {window[0]:.1f} s to {window[1]:.1f} s" if window else "not scored"
    if run.scenario is None:
        from twin.report import log_page

        return f"{log_page.lead(scores, run)}{f' It is {scored}.' if window else ''}"
    end = scores.get("end") or {"as_planned": True}
    driven = "" if not end["as_planned"] else f" {str(scores.get('ended', '')).capitalize()}"
    return f"Simulated run of {run.setup.machine}, {scored}.{driven.rstrip()}"


def _driven(truth: Mapping[str, float | None]) -> str:
    """Means and totals of the drive inside the window."""
    shown = (
        ("mean_speed_kmh", "Mean speed", 1.0, ".2f", "km/h"),
        ("distance_m", "Distance", 1.0, ".1f", "m"),
        ("slip_mean", "Mean slip", 100.0, ".2f", "%"),
        ("slip_sd", "Slip sd", 100.0, ".2f", "%"),
        ("draft_mean_kn", "Mean draft", 1.0, ".2f", "kN"),
        ("draft_cv", "Draft variation", 100.0, ".1f", "%"),
        ("depth_mean_m", "Mean depth", 100.0, ".1f", "cm"),
        ("sideslip_m", "Sideslip", 1.0, ".3f", "m"),
    )
    items = [
        f"<div><dt>{label}</dt><dd>{scale * value:{form}} {unit}</dd></div>"
        for key, label, scale, form, unit in shown
        if (value := truth.get(key)) is not None
    ]
    return f"<dl>{''.join(items)}</dl>" if items else ""


def _headline(scores: Mapping[str, Plain]) -> str:
    rows = score_rows(scores)
    if not rows:
        return ""
    note = (
        f"Errors are estimate minus truth at the same epoch. '{COVERAGE}' is the share of slip "
        "errors within two reported standard deviations; 95.4 % is right."
    )
    if (zero := zero_line(scores)) is not None:
        note += f" {html.escape(zero[0].upper() + zero[1:])}."
    note += "".join(
        f" {html.escape(line[0].upper() + line[1:])}." for line in left_out_lines(scores)
    )
    headline = f'<h2>Scores</h2>{table(HEADERS, rows)}<p class="soft">{note}</p>'
    return headline + _by_phase(scores)


def _by_phase(scores: Mapping[str, Plain]) -> str:
    rows = phase_rows(scores)
    if not rows:
        return ""
    rule = f"While driving; {html.escape(str(scores['phase_rule']))}."
    shown = table(tuple(PHASE_RANKS), rows)
    return f'<h3>By phase</h3>{shown}<p class="soft">{rule}</p>'


def _notes(scores: Mapping[str, Plain]) -> str:
    items = "".join(f"<li>{html.escape(line)}</li>" for line in scores.get("notes", ()))
    return f"<h2>Notes</h2><ul>{items}</ul>" if items else ""


def _figures(run: RunLike, scores: Mapping[str, Plain]) -> Iterable[Figure]:
    if run.scenario is None:
        from twin.report import log_page

        yield from log_page.figures(run, scores)
        yield from log_page.clocked_figures(
            _run_figures(*log_page.since_start(run, scores)), scores
        )
    else:
        yield from _run_figures(run, scores)


def _run_figures(run: RunLike, scores: Mapping[str, Plain]) -> Iterable[Figure]:
    window = tuple(scores["window_s"]) if scores.get("window_s") else None
    truth, estimates, bound = run.truth, run.estimates, scores.get("bound") or {}
    caption = SLIP_OVER_TIME if truth else "Bands: ±2 reported standard deviations."
    yield "Slip", figures.slip(truth, estimates, window, bound), caption
    if truth and window is not None:
        given: Any = (truth, estimates, window, bound)
        yield "Slip error", errors.slip_error(*given), ERROR_OVER_TIME
        yield "Distribution of the slip error", errors.histogram(*given), "In the scored window."
    yield "Sideslip", figures.sideslip(truth, estimates), "At the centre of gravity; + is left."
    if truth and window is not None:
        yield "Sideslip angle error", errors.angle_error(*given), ERROR_OVER_TIME
    yield "Path", figures.path(truth, run.streams), "East and north have one scale."
    yield "Draft and depth", figures.draft(truth), ""
    yield "Speeds", figures.speeds(truth, estimates), "At the rear-axle centre."
    yield "Power", figures.power(truth, window), "Means within the scored window."
    if truth and window is not None:
        yield "Consistency", errors.nees(truth, estimates, window), CONSISTENCY


def _parameters(scenario: Thing) -> str:
    if scenario is None:
        return ""
    rows = [(f"<code>{html.escape(k)}</code>", html.escape(v)) for k, v in flat(to_plain(scenario))]
    body = "".join(f"<tr><td>{k}</td><td>{v}</td></tr>" for k, v in rows)
    return (
        "<h2>Scenario</h2><details><summary>All parameters</summary>"
        f'<div class="wide"><table class="parameters"><tbody>{body}</tbody></table></div></details>'
    )


def flat(value: Plain, prefix: str = "") -> list[tuple[str, str]]:
    """Nested plain values as (dotted name, text), in order."""
    if isinstance(value, Mapping):
        items = [flat(v, f"{prefix}.{k}" if prefix else str(k)) for k, v in value.items()]
        return [pair for item in items for pair in item]
    return [(prefix, f"{value:g}" if isinstance(value, float) else str(value))]


def _again(name: str, seed: int | None, scenario: Thing, command: str) -> str:
    if command or scenario is None:
        return made_with(command)
    command = f"twin run {name}" + ("" if seed is None else f" --seed {seed}")
    return made_with(command, "Overrides, if any, are in scenario.json beside this page.")
