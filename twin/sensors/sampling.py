"""Reading a trajectory at a sensor's own epochs, across chunk borders, and stamping arrivals.

Every result depends on rows of the trajectory alone and not on where chunks are cut, so the same
trajectory gives the same bits in any chunks.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.streams import STAMPS, Table

if TYPE_CHECKING:
    from twin.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

FEW = 8
"""Number of epochs up to which a loop is faster, as in a control step of an environment."""


@dataclass(frozen=True, kw_only=True)
class Clock:
    """A sensor's epochs: number k falls at start + k / rate, rounded to the nanosecond."""

    start_ns: int
    rate_hz: float
    index: int = 0
    """Number of the next epoch."""


def due(clock: Clock, grid_ns: Stamps) -> tuple[Clock, Stamps]:
    """The clock's next epochs up to the end of the grid, shape (n,); and the clock after them."""
    if len(grid_ns) == 0:
        return clock, np.empty(0, np.int64)
    first_ns, last_ns = int(grid_ns[0]), int(grid_ns[-1])
    elapsed_s = (last_ns - clock.start_ns) * 1e-9
    stop = max(clock.index, int(elapsed_s * clock.rate_hz) + 2)
    if stop - clock.index <= FEW:
        epochs = [clock.start_ns + round(k * 1e9 / clock.rate_hz) for k in range(clock.index, stop)]
        passed = [ns for ns in epochs if ns <= last_ns]
        covered, epoch_ns = len(passed), np.array([ns for ns in passed if ns >= first_ns], np.int64)
    else:
        number = np.arange(clock.index, stop)
        all_ns = clock.start_ns + np.rint(number * 1e9 / clock.rate_hz).astype(np.int64)
        covered = int(np.searchsorted(all_ns, last_ns, side="right"))
        epoch_ns = all_ns[int(np.searchsorted(all_ns, first_ns)) : covered]
    after = Clock(start_ns=clock.start_ns, rate_hz=clock.rate_hz, index=clock.index + covered)
    return after, epoch_ns


@dataclass(frozen=True, kw_only=True)
class Reader:
    """State of `read`: the sensor's clock and the last row of the trajectory."""

    clock: Clock
    grid_ns: Stamps = field(default_factory=lambda: np.empty(0, np.int64))
    rows: dict[str, Array] = field(default_factory=dict)


def reader(start_ns: int, rate_hz: float) -> Reader:
    """A reader at the start of a run, before any row."""
    return Reader(clock=Clock(start_ns=start_ns, rate_hz=rate_hz))


def read(
    state: Reader, chunk: Trajectory, names: Iterable[str]
) -> tuple[Reader, Stamps, dict[str, Array]]:
    """Columns of a trajectory at the sensor's epochs.

    A row on the physics grid is taken unchanged; between two rows it is interpolated linearly,
    x = a + f (b - a), which errs by at most x'' h^2 / 8: 1 um for 2 m/s2 on a 2 ms grid.

    Args:
        state: the reader after the last chunk.
        chunk: the next part of the trajectory.
        names: columns to read; the same ones each time.

    Returns:
        The reader after the chunk, the epochs, shape (n,), and the columns, shape (n, ...).
    """
    grid_ns = np.concatenate([state.grid_ns, chunk.epoch_ns])
    columns = {n: np.asarray(chunk[n], float) for n in names}
    clock, epoch_ns = due(state.clock, grid_ns)
    kept = {n: c[-1:].copy() for n, c in columns.items()} if len(chunk) else state.rows
    after = Reader(clock=clock, grid_ns=grid_ns[-1:].copy(), rows=kept)
    if not len(epoch_ns):
        return after, epoch_ns, {n: c[:0] for n, c in columns.items()}
    at, before = np.searchsorted(grid_ns, epoch_ns), len(state.grid_ns)
    if at[0] >= before and np.array_equal(grid_ns[at], epoch_ns):
        return after, epoch_ns, {n: c[at - before] for n, c in columns.items()}
    left, right, fraction = _bracket(grid_ns, epoch_ns)
    rows = {n: np.concatenate([state.rows.get(n, c[:0]), c]) for n, c in columns.items()}
    values = {n: _interpolate(x[left], x[right], fraction) for n, x in rows.items()}
    return after, epoch_ns, values


@cache
def nothing(*columns: str, whole: tuple[str, ...] = ()) -> Table:
    """A table of stamps and columns without rows; the columns in `whole` are integers."""
    counted = (*STAMPS, *whole)
    return {n: np.empty(0, np.int64 if n in counted else float) for n in (*STAMPS, *columns)}


def _bracket(grid_ns: Stamps, epoch_ns: Stamps) -> tuple[Stamps, Stamps, Array]:
    """Rows before and at-or-after each epoch, and how far between them it lies, in (0, 1]."""
    right = np.searchsorted(grid_ns, epoch_ns)
    left = np.maximum(right - 1, 0)
    step_ns = np.maximum(grid_ns[right] - grid_ns[left], 1)
    from_left_ns = np.where(right > left, epoch_ns - grid_ns[left], 1)
    return left, right, from_left_ns / step_ns


def _interpolate(a: Array, b: Array, fraction: Array) -> Array:
    f = fraction.reshape(-1, *[1] * (a.ndim - 1))
    values: Array = np.where(f == 1.0, b, a + f * (b - a))
    return values


@dataclass(frozen=True, kw_only=True)
class Averager:
    """State of the running integral of a signal of m components."""

    clock: Clock
    integral: Array
    """Integral up to the last row, shape (m,)."""
    grid_ns: Stamps
    """Epoch of the last row, shape (0,) or (1,)."""
    row: Array
    """The last row, shape (0, m) or (1, m)."""
    edge_ns: Stamps
    """The last window edge, shape (0,) or (1,)."""
    edge: Array
    """Integral up to that edge, shape (0, m) or (1, m)."""


def averager(start_ns: int, rate_hz: float, components: int) -> Averager:
    """An averager at the start of a run, before any row."""
    return Averager(
        clock=Clock(start_ns=start_ns, rate_hz=rate_hz),
        integral=np.zeros(components),
        grid_ns=np.empty(0, np.int64),
        row=np.empty((0, components)),
        edge_ns=np.empty(0, np.int64),
        edge=np.empty((0, components)),
    )


def average(
    state: Averager, epoch_ns: Stamps, signal: Array
) -> tuple[Averager, Stamps, Array, NDArray[np.int64]]:
    """Means of a signal over the windows between consecutive clock epochs.

    The signal is taken as linear between rows and integrated exactly:

        I(t) = I_left + f h (a + f (b - a) / 2)
        mean = (I(t_k) - I(t_{k-1})) / (t_k - t_{k-1})

    Args:
        state: the averager after the last chunk.
        epoch_ns: epochs of the signal's rows, shape (n,).
        signal: shape (n, m).

    Returns:
        The averager after the chunk; the end of each window, shape (w,); the means, shape
        (w, m); and the number of the clock epoch at each window's end, shape (w,).
    """
    grid_ns = np.concatenate([state.grid_ns, epoch_ns])
    x = np.concatenate([state.row, signal])  # (n + 1, m)
    step_s = (np.diff(grid_ns) * 1e-9)[:, None]
    pieces = 0.5 * step_s * (x[1:] + x[:-1])
    # accumulate adds strictly in order, unlike sum, so the carry reproduces every bit
    integral = np.add.accumulate(np.concatenate([state.integral[None], pieces]))
    clock, due_ns = due(state.clock, grid_ns)
    left, right, fraction = _bracket(grid_ns, due_ns)
    f = fraction[:, None]
    h = ((grid_ns[right] - grid_ns[left]) * 1e-9)[:, None]
    edge = integral[left] + f * h * (x[left] + 0.5 * f * (x[right] - x[left]))
    edges_ns = np.concatenate([state.edge_ns, due_ns])
    edges = np.concatenate([state.edge, edge])
    means = np.diff(edges, axis=0) / (np.diff(edges_ns) * 1e-9)[:, None]
    after = Averager(
        clock=clock,
        integral=integral[-1].copy(),
        grid_ns=grid_ns[-1:].copy(),
        row=x[-1:].copy(),
        edge_ns=edges_ns[-1:].copy(),
        edge=edges[-1:].copy(),
    )
    return after, edges_ns[1:], means, clock.index - np.arange(len(means), 0, -1)


def arrivals(last_ns: int, sent_ns: Stamps, delay_s: Array) -> tuple[int, Stamps]:
    """Arrival times of samples: sent + delay, but never before the sample sent before.

    Args:
        last_ns: arrival of the last sample of the chunk before.
        sent_ns: times of sending, (n,).
        delay_s: delays, (n,).

    Returns:
        arrival of the last sample, arrivals (n,) [ns].
    """
    if len(sent_ns) == 1:
        last_ns = max(last_ns, int(sent_ns[0]) + round(float(delay_s[0]) * 1e9))
        return last_ns, np.array([last_ns], np.int64)
    raw_ns = sent_ns + np.rint(delay_s * 1e9).astype(np.int64)
    ordered = np.maximum.accumulate(np.concatenate([[last_ns], raw_ns]))
    return int(ordered[-1]), ordered[1:]
