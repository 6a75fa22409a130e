"""Run many calls in processes and report progress when each of them ends."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from multiprocessing import resource_tracker
from typing import Any, TypeAlias

import joblib

Result: TypeAlias = Any
"""What a call gives; and a call as joblib has it, which has no types."""
Told = Callable[[int, int], None]
"""Progress callback: calls done, calls in all."""


def _no_progress(done: int, total: int) -> None:
    """No-op progress callback."""


_TOLD: ContextVar[Told] = ContextVar("told", default=_no_progress)


@contextmanager
def telling(told: Told) -> Iterator[None]:
    """Set the progress callback of the calls inside the block."""
    token = _TOLD.set(told)
    try:
        yield
    finally:
        _TOLD.reset(token)


def many(calls: Iterable[Result], jobs: int = 1) -> list[Result]:
    """Results of calls, in their order.

    Args:
        calls: as `joblib.delayed` makes them.
        jobs: processes; -1 for one a core.
    """
    calls, told = list(calls), _TOLD.get()
    told(0, len(calls))
    with Counted(n_jobs=jobs) as parallel, telling(_no_progress):  # of calls that a call makes
        if jobs != 1:
            _start(parallel)
        parallel.told = lambda done: told(done, len(calls))
        found: list[Result] = parallel(calls)
    return found


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

    told: Callable[[int], None] = staticmethod(lambda done: None)

    def print_progress(self) -> None:
        """Called by joblib after every batch."""
        self.told(self.n_completed_tasks)
