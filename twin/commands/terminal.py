"""Lines and progress on the terminal; into a file or a pipe lines alone, without colour."""

from __future__ import annotations

import os
import sys
import textwrap
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rich.console import Console

    from twin.compute.parallel import Progress

_UNLIMITED = 10_000
"""Columns of a file or a pipe, unless COLUMNS says how many."""


def console(*, stderr: bool = False) -> Console:
    """A console as wide as its terminal, or as COLUMNS says; a file or a pipe has no width."""
    from rich.console import Console

    out = Console(stderr=stderr)
    return out if out.is_terminal else Console(stderr=stderr, width=_columns(), no_color=True)


def _plain(*, stderr: bool) -> bool:
    """Whether lines need no width and no colour, so that rich, which is slow to load, is not."""
    stream = sys.stderr if stderr else sys.stdout
    return not (stream.isatty() or {"FORCE_COLOR", "TTY_COMPATIBLE"} & set(os.environ))


def _columns() -> int:
    """Width of a file or a pipe."""
    columns = os.environ.get("COLUMNS", "")
    return int(columns) if columns.isdigit() and int(columns) > 0 else _UNLIMITED


def say(line: str, *, style: str = "", stderr: bool = False, indent: int = 0) -> None:
    """Print a line, broken between its words where it is too long; no word is cut.

    Args:
        line: the line.
        style: rich's name of a style.
        stderr: print it there.
        indent: spaces before all but the first of the broken line's parts.
    """
    plain = _plain(stderr=stderr)
    width = _columns() if plain else console(stderr=stderr).width
    parts = textwrap.wrap(
        line, width, break_long_words=False, break_on_hyphens=False,
        subsequent_indent=" " * indent, drop_whitespace=True,
    )  # fmt: skip
    for part in parts or [""]:
        if plain:
            print(part, file=sys.stderr if stderr else sys.stdout)
        else:
            console(stderr=stderr).print(
                part, style=style, highlight=False, markup=False, soft_wrap=True
            )


class ShowProgress(Protocol):
    """Callback that shows progress: share done (0 to 1) and, for a run, the simulated time [s]."""

    def __call__(self, share: float, simulated_s: float | None = None, /) -> None:
        """Show the share that is done, 0 to 1."""


@contextmanager
def progress(label: str, *, shown: bool) -> Iterator[ShowProgress]:
    """A bar on stderr, with simulated time, speed and time left; silent off a terminal."""
    watch = Stopwatch()
    with _bar(label, shown=shown) as (bar, task):
        if bar is None:
            yield lambda share, simulated_s=None, /: None
            return

        def show(share: float, simulated_s: float | None = None, /) -> None:
            bar.update(task, completed=min(share, 1.0), pace=pace(simulated_s, watch.seconds()))

        yield show


@contextmanager
def counting(label: str, what: str, *, shown: bool) -> Iterator[Progress]:
    """A bar that counts things over several stages: `37 runs, 1.4 a second`."""
    watch, before, stage = Stopwatch(), 0, 0
    with _bar(label, shown=shown) as (bar, task):
        if bar is None:
            yield lambda done, total: None
            return

        def show(done: int, total: int) -> None:
            nonlocal before, stage
            if done == 0:
                before, stage = before + stage, 0
                bar.reset(task, total=total)
            stage = done
            said = rate(before + done, what, watch.seconds())
            bar.update(task, completed=done, total=total, pace=said)

        yield show


@contextmanager
def waiting(label: str, *, shown: bool) -> Iterator[None]:
    """A sign of activity; silent off a terminal."""
    if not shown or _plain(stderr=True) or not (err := console(stderr=True)).is_terminal:
        yield
        return
    with err.status(label):
        yield


@contextmanager
def _bar(label: str, *, shown: bool) -> Iterator[tuple[Any, Any]]:
    """rich's bar and its one task, gone when done; None off a terminal."""
    if not shown or _plain(stderr=True) or not (err := console(stderr=True)).is_terminal:
        yield None, None
        return
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(),
        TextColumn("{task.fields[pace]}"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=err, transient=True) as bar:
        yield bar, bar.add_task(label, total=1.0, pace="")


def rate(done: int, what: str, wall_s: float) -> str:
    """`37 runs, 1.4 a second`, or a minute where that is few."""
    if done == 0 or wall_s <= 0.0:
        return ""
    per_s = done / wall_s
    often = f"{per_s:.1f} a second" if per_s >= 1.0 else f"{60.0 * per_s:.1f} a minute"
    return f"{done} {what}, {often}"


def pace(simulated_s: float | None, wall_s: float) -> str:
    """`42 s driven, 19 x real time`; nothing where nothing is simulated."""
    if simulated_s is None or wall_s <= 0.0:
        return ""
    return f"{simulated_s:.0f} s driven, {simulated_s / wall_s:.1f} x real time"


class Stopwatch:
    """Seconds since it was made."""

    def __init__(self) -> None:
        self._start_s = time.perf_counter()

    def seconds(self) -> float:
        """Time since the start [s]."""
        return time.perf_counter() - self._start_s
