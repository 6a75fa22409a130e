"""Report that functions are being compiled when compiling takes longer than PATIENCE_S.

Light to import: the command line sets the listener before anything is compiled.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

PATIENCE_S = 2.0
"""Compiling that ends within this time is not reported [s]."""

Report = Callable[[], None]


@dataclass
class _Watch:
    """Counts the time in which any function is being compiled, and reports it once."""

    report: Report
    started: dict[object, float] = field(default_factory=dict)
    """Function being compiled -> its start time [s]. Functions that it calls may be added."""
    spent_s: float = 0.0
    timer: threading.Timer | None = None

    def begin(self, function: object) -> None:
        if not self.started and self.spent_s < PATIENCE_S:
            self.timer = threading.Timer(PATIENCE_S - self.spent_s, self.report)
            self.timer.daemon = True
            self.timer.start()
        self.started.setdefault(function, time.perf_counter())

    def end(self, function: object) -> None:
        began_s = self.started.pop(function, None)
        if began_s is None or self.started:
            return
        self.spent_s += time.perf_counter() - began_s
        self.stop()

    def stop(self) -> None:
        if self.timer is not None:
            self.timer.cancel()


_watch: _Watch | None = None


@contextmanager
def when_compiling(report: Report) -> Iterator[None]:
    """Call `report` once if compiling inside the block takes longer than PATIENCE_S in total."""
    global _watch
    before, _watch = _watch, _Watch(report)
    try:
        yield
    finally:
        _watch.stop()
        _watch = before


def begins(function: object) -> None:
    """Called when compiling of a function begins: its machine code is not in the cache."""
    if _watch is not None:
        _watch.begin(function)


def ends(function: object) -> None:
    """Called when compiling of a function has ended."""
    if _watch is not None:
        _watch.end(function)
