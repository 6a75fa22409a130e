"""The page itself: headline table, figures, what was driven, and how to do it again."""

from __future__ import annotations

import html
import platform
from collections.abc import Iterable, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

from twin.plain import to_plain
from twin.report import figures
from twin.runfolder import RunLike
from twin.table import HEADERS, score_rows, slip_lines

CSS = """
:root { color-scheme: light; --ink: #1b1b1b; --soft: #5c5c5c; --line: #dcdcdc }
* { box-sizing: border-box }
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 72rem; color: var(--ink);
  background: #fff; font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .3rem; overflow-wrap: anywhere }
h2 { font-size: 1.1rem; margin: 2.2rem 0 .5rem }
p { margin: .4rem 0 }
p.soft { max-width: 45rem }
li { overflow-wrap: anywhere }
.soft, figcaption { color: var(--soft); font-size: .9rem }
.wide { overflow-x: auto }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem }
th, td { padding: .3rem .6rem; text-align: right; white-space: nowrap }
th, td { border-bottom: 1px solid var(--line) }
th:first-child, td:first-child { text-align: left; padding-left: 0 }
thead th { color: var(--soft); font-weight: 600 }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)) }
dl { gap: .6rem 1rem; margin: .8rem 0 }
dt { color: var(--soft); font-size: .85rem }
dd { margin: 0; font-size: 1.15rem; font-variant-numeric: tabular-nums }
.figures { display: grid; gap: 0 2rem; align-items: start;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 27rem), 1fr)) }
figure { margin: .3rem 0 0 }
svg.figure { width: 100%; height: auto; display: block }
code, pre { font: .88rem/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace }
pre { background: #f5f5f5; padding: .7rem .9rem; white-space: pre-wrap; overflow-wrap: anywhere }
.parameters td { white-space: normal; overflow-wrap: anywhere }
@media print { body { max-width: none; font-size: 11pt } section { break-inside: avoid } }
"""

VERSIONS = ("tractor-twin", "mujoco", "numpy", "numba", "rerun-sdk")


def write(run: RunLike, scores: Mapping[str, Any], path: Path) -> None:
    """Write the report of a run.

    Args:
        run: the run.
        scores: as made by `twin.scores.score`.
        path: the .html file.
    """
    path.write_text(page(run, scores), encoding="utf-8")


def page(run: RunLike, scores: Mapping[str, Any]) -> str:
    """The whole page as HTML text."""
    name = str(scores.get("scenario") or "log")
    seed = scores.get("seed")
    title = name if seed is None else f"{name}, seed {seed}"
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        f'<p class="soft">{html.escape(_what(run, scores))}</p>',
        _driven(scores.get("truth") or {}),
        _headline(scores),
        _found(scores),
        f'<div class="figures">{"".join(_figures(run, scores))}</div>',
        _parameters(run.scenario),
        _again(name, seed, run.scenario),
    ]
    head = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{html.escape(title)}</title><style>{CSS}</style></head><body>"
    )
    return head + "\n".join(p for p in parts if p) + "</body></html>\n"


def _what(run: RunLike, scores: Mapping[str, Any]) -> str:
    window = scores.get("window_s")
    scored = f"scored from {window[0]:.1f} s to {window[1]:.1f} s" if window else "not scored"
    kind = "Recorded log of" if run.scenario is None else "Simulated run of"
    return f"{kind} {run.setup.machine}, {scored}."


def _driven(truth: Mapping[str, float | None]) -> str:
    """What was driven inside the window, as a list of figures."""
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


def _headline(scores: Mapping[str, Any]) -> str:
    rows = score_rows(scores)
    if not rows:
        return ""
    note = (
        "Errors are estimate minus truth at the same epoch. Coverage is the share of slip errors "
        "within ±2 of the reported standard deviation (95.4 % when honest)."
    )
    return f'<h2>Scores</h2>{table(HEADERS, rows)}<p class="soft">{note}</p>'


def _found(scores: Mapping[str, Any]) -> str:
    """What a recorded drive says of itself, and what was handled in reading it."""
    lines = [*slip_lines(scores), *(f"Note: {note}" for note in scores.get("notes", ()))]
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return f"<h2>Slip of the drive</h2><ul>{items}</ul>" if lines else ""


def _figures(run: RunLike, scores: Mapping[str, Any]) -> Iterable[str]:
    window = tuple(scores["window_s"]) if scores.get("window_s") else None
    truth, estimates = run.truth, run.estimates
    scored = truth is not None and window is not None and "slip" in truth
    drawn = (
        ("Slip", figures.slip(truth, estimates, window),
         "Black: truth. Bands: ±2 reported standard deviations. Grey: what is scored."),
        ("Slip error", figures.histogram(truth, estimates, window)  # type: ignore[arg-type]
         if scored else "", "Within the scored window."),
        ("Sideslip", figures.sideslip(truth, estimates),
         "Amount at the centre of gravity, to the left positive."),
        ("Path", figures.path(truth, run.streams), "East and north differ in scale."),
        ("Draft and depth", figures.draft(truth), ""),
        ("Speeds", figures.speeds(truth, estimates), "At the rear-axle centre."),
    )  # fmt: skip
    for title, svg, caption in drawn:
        if svg:
            figure = f"<figure>{svg}<figcaption>{caption}</figcaption></figure>"
            yield f"<section><h2>{title}</h2>{figure}</section>"


def _parameters(scenario: Any) -> str:
    if scenario is None:
        return ""
    rows = [(f"<code>{html.escape(k)}</code>", html.escape(v)) for k, v in flat(to_plain(scenario))]
    body = "".join(f"<tr><td>{k}</td><td>{v}</td></tr>" for k, v in rows)
    return (
        "<h2>Scenario</h2><details><summary>All parameters</summary>"
        f'<div class="wide"><table class="parameters"><tbody>{body}</tbody></table></div></details>'
    )


def flat(value: Any, prefix: str = "") -> list[tuple[str, str]]:
    """Nested plain values as (dotted name, text), in order."""
    if isinstance(value, Mapping):
        items = [flat(v, f"{prefix}.{k}" if prefix else str(k)) for k, v in value.items()]
        return [pair for item in items for pair in item]
    return [(prefix, f"{value:g}" if isinstance(value, float) else str(value))]


def _again(name: str, seed: int | None, scenario: Any) -> str:
    own = "" if seed is None else f" --seed {seed}"
    command = f"<pre>twin run {html.escape(name)}{own}</pre>" if scenario is not None else ""
    note = '<p class="soft">Overrides, if any, are in scenario.json beside this page.</p>'
    rerun = f"<h2>Do it again</h2>{command}{note}" if command else "<h2>Made with</h2>"
    return f'{rerun}<p class="soft">{html.escape(_versions())}</p>'


def _versions() -> str:
    found = [f"Python {platform.python_version()}"]
    for package in VERSIONS:
        try:
            found.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:  # from a bare checkout
            continue
    return ", ".join(found)


def table(headers: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table as HTML; its cells are text."""
    head = "".join(f"<th>{html.escape(h)}</th>" for h in headers)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    lines = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div class="wide">{lines}</div>'
