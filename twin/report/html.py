"""The page of every report: head, style, tables, command and versions. No network, no script."""

from __future__ import annotations

import html
import platform
from collections.abc import Iterable
from importlib import metadata

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
.ended { color: #b3261e; font-weight: 600; max-width: 45rem }
.soft, figcaption { color: var(--soft); font-size: .9rem }
.wide { overflow-x: auto }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem }
th, td { padding: .3rem .6rem; text-align: right; white-space: nowrap }
th, td { border-bottom: 1px solid var(--line) }
th:first-child, td:first-child { text-align: left; padding-left: 0 }
.names2 th:nth-child(2), .names2 td:nth-child(2) { text-align: left }
.words th, .words td { text-align: left }
.words td { white-space: normal }
thead th { color: var(--soft); font-weight: 600; white-space: normal; vertical-align: bottom }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)) }
dl { gap: .6rem 1rem; margin: .8rem 0 }
dt { color: var(--soft); font-size: .85rem }
dd { margin: 0; font-size: 1.15rem; font-variant-numeric: tabular-nums }
.figures { display: grid; gap: 0 2rem; align-items: start;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 27rem), 1fr)) }
figure { margin: .3rem 0 0 }
section:has(svg.spread) { grid-column: 1 / -1 }
svg.figure { width: 100%; height: auto; display: block }
code, pre { font: .88rem/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace }
pre { background: #f5f5f5; padding: .7rem .9rem; white-space: pre-wrap; overflow-wrap: anywhere }
.parameters td { white-space: normal; overflow-wrap: anywhere }
@media (max-width: 40rem) {
  th:first-child, td:first-child { white-space: normal; min-width: 9.5rem } }
@media print { body { max-width: none; font-size: 11pt } section { break-inside: avoid } }
"""

VERSIONS = ("tractor-twin", "mujoco", "numpy", "numba", "rerun-sdk")


def document(title: str, parts: Iterable[str]) -> str:
    """A whole page with its heading.

    Args:
        title: heading and title, as text.
        parts: what follows, as HTML; empty ones are left out.
    """
    head = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{html.escape(title)}</title><style>{CSS}</style></head><body>"
    )
    body = "\n".join([f"<h1>{html.escape(title)}</h1>", *(p for p in parts if p)])
    return f"{head}{body}</body></html>\n"


def figures(drawn: Iterable[tuple[str, str, str]]) -> str:
    """Figures side by side where there is room: heading, SVG element, caption of each."""
    sections = (
        f"<section><h2>{html.escape(title)}</h2><figure>{svg}"
        f"<figcaption>{html.escape(caption)}</figcaption></figure></section>"
        for title, svg, caption in drawn
        if svg
    )
    return f'<div class="figures">{"".join(sections)}</div>'


def made_with(command: str = "", note: str = "") -> str:
    """The command that repeats it, and the versions that were used."""
    head = f"<h2>How to repeat it</h2><pre>{html.escape(command)}</pre>" if command else ""
    said = f'<p class="soft">{html.escape(note)}</p>' if note else ""
    return f'{head or "<h2>Made with</h2>"}{said}<p class="soft">{html.escape(versions())}</p>'


def versions() -> str:
    """Python and the packages that matter."""
    found = [f"Python {platform.python_version()}"]
    for package in VERSIONS:
        try:
            found.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:  # from a bare checkout
            continue
    return ", ".join(found)


def table(
    headers: Iterable[str],
    rows: Iterable[Iterable[str]],
    *,
    names: int = 1,
    kind: str = "",
) -> str:
    """A table as HTML; its cells are text, in the first one or two columns names.

    Of the kind `words` every column holds words.
    """
    head = "".join(f"<th>{html.escape(h)}</th>" for h in headers)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    look = kind or f"names{names}"
    lines = f'<table class="{look}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div class="wide">{lines}</div>'
