"""What is said on the terminal: tables, progress, and little of either when it is not one."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from rich.console import Console

from twin.scores.table import HEADERS, end_lines, score_rows

if TYPE_CHECKING:
    from twin.compute.parallel import Told

_WIDE = 200
"""Columns of a table that goes into a file or a pipe."""


def console(*, stderr: bool = False) -> Console:
    """A console; into a file or a pipe it neither colours nor wraps at 80."""
    out = Console(stderr=stderr, soft_wrap=False)
    return out if out.is_terminal else Console(stderr=stderr, width=_WIDE, no_color=True)


def print_scores(scores: Mapping[str, Any]) -> None:
    """The score table, and above it what was driven and, where it was not as planned, its end."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    for line in end_lines(scores):
        console().print(line, style="bold red", highlight=False, markup=False)
    rows = score_rows(scores)
    if not rows:
        return
    table = Table(box=box.SIMPLE_HEAD, title=_title(scores), title_justify="left", pad_edge=False)
    for i, header in enumerate(HEADERS):
        table.add_column(escape(header), justify="left" if i == 0 else "right", no_wrap=i == 0)
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    console().print(table)


def _title(scores: Mapping[str, Any]) -> str:
    truth, window = scores.get("truth") or {}, scores.get("window_s") or (0.0, 0.0)
    said = [str(scores.get("scenario"))]
    if scores.get("seed") is not None:
        said.append(f"seed {scores['seed']}")
    said.append(f"scored {window[0]:.1f} to {window[1]:.1f} s")
    for key, form in (
        ("mean_speed_kmh", "{:.2f} km/h"),
        ("slip_mean", "slip {:.2%}"),
        ("draft_mean_kn", "draft {:.1f} kN"),
    ):
        if truth.get(key) is not None:
            said.append(form.format(truth[key]))
    return ", ".join(said)


class Tell(Protocol):
    """Takes the share done, and the time simulated where there is one."""

    def __call__(self, share: float, simulated_s: float | None = None, /) -> None:
        """Tell that a share from 0 to 1 is done."""


@contextmanager
def progress(label: str, *, shown: bool) -> Iterator[Tell]:
    """A bar on stderr, with simulated time, speed and time left; silent off a terminal."""
    watch = Stopwatch()
    with _bar(label, shown=shown) as (bar, task):
        if bar is None:
            yield lambda share, simulated_s=None, /: None
            return

        def tell(share: float, simulated_s: float | None = None, /) -> None:
            bar.update(task, completed=min(share, 1.0), pace=pace(simulated_s, watch.seconds()))

        yield tell


@contextmanager
def counting(label: str, what: str, *, shown: bool) -> Iterator[Told]:
    """A bar of things done, in stages that each begin at none: `37 runs, 1.4 a second`."""
    watch, before, stage = Stopwatch(), 0, 0
    with _bar(label, shown=shown) as (bar, task):
        if bar is None:
            yield lambda done, total: None
            return

        def tell(done: int, total: int) -> None:
            nonlocal before, stage
            if done == 0:
                before, stage = before + stage, 0
                bar.reset(task, total=total)
            stage = done
            said = rate(before + done, what, watch.seconds())
            bar.update(task, completed=done, total=total, pace=said)

        yield tell


@contextmanager
def waiting(label: str, *, shown: bool) -> Iterator[None]:
    """A sign that something goes on; silent off a terminal."""
    err = console(stderr=True)
    if not (shown and err.is_terminal):
        yield
        return
    with err.status(label):
        yield


@contextmanager
def _bar(label: str, *, shown: bool) -> Iterator[tuple[Any, Any]]:
    """rich's bar and its one task, gone when done; None off a terminal."""
    err = console(stderr=True)
    if not (shown and err.is_terminal):
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
