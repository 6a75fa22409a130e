"""Run many calls in processes and report progress when each of them ends."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from multiprocessing import resource_tracker
from typing import Any, TypeAlias, TypeVar

import joblib

Result: TypeAlias = Any
"""Result of a call, or a call made by `joblib.delayed`; joblib has no types for either."""
Case = TypeVar("Case")
Found = TypeVar("Found")
Progress = Callable[[int, int], None]
"""Progress callback: calls done, calls in all."""


def _no_progress(done: int, total: int) -> None:
    """No-op progress callback."""


_PROGRESS: ContextVar[Progress] = ContextVar("progress", default=_no_progress)


@contextmanager
def reporting(progress: Progress) -> Iterator[None]:
    """Set the progress callback of the calls inside the block."""
    token = _PROGRESS.set(progress)
    try:
        yield
    finally:
        _PROGRESS.reset(token)


def many(calls: Iterable[Result], jobs: int = 1) -> list[Result]:
    """Run all calls and return their results, in the order of the calls.

    Args:
        calls: as `joblib.delayed` makes them.
        jobs: processes; -1 for one a core.
    """
    calls, progress = list(calls), _PROGRESS.get()
    progress(0, len(calls))
    with Counted(n_jobs=jobs) as parallel, reporting(_no_progress):  # of calls that a call makes
        if jobs != 1:
            _start(parallel)
        parallel.report = lambda done: progress(done, len(calls))
        found: list[Result] = parallel(calls)
    return found


def over_seeds(
    call: Callable[[Case, int], Found], cases: Mapping[str, Case], seeds: int, jobs: int = 1
) -> dict[str, list[Found]]:
    """Call a function with every case and each of the first seeds; its results by case.

    Args:
        call: function of a case and a seed.
        cases: cases by name.
        seeds: number of seeds: 0, 1, ...
        jobs: processes; -1 for one a core.
    """
    done = iter(
        many((joblib.delayed(call)(c, s) for c in cases.values() for s in range(seeds)), jobs)
    )
    return {name: [next(done) for _ in range(seeds)] for name in cases}


def _start(parallel: Counted) -> None:
    """Start processes that ignore Ctrl-C, which the terminal sends to all; this one ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        return
    resource_tracker.ensure_running()  # its own start lifts a mask
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        parallel([joblib.delayed(int)()])  # a process keeps the mask it began with
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Counted(joblib.Parallel):  # type: ignore[misc]
    """Parallel that reports how many calls are done, with any backend."""

    report: Callable[[int], None] = staticmethod(lambda done: None)

    def print_progress(self) -> None:
        """Called by joblib after every batch."""
        self.report(self.n_completed_tasks)
