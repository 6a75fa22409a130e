"""What a reader finds in a log: named signals, with times of their own where they have such."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import Cells, check_times, quoted
from twin.streams import Array


@dataclass(frozen=True)
class Signal:
    """One signal of a log, in its own unit."""

    values: Cells
    """Text cells, or an array of numbers or datetime64, shape (n,)."""
    epoch_ns: NDArray[np.int64] | None = None
    """When each was measured, rising; None for a column of a table, whose rows share a time."""


def checked(name: str, signal: object) -> Signal:
    """A signal as the map can take it. Raises BadInput that names it."""
    if not isinstance(signal, Signal):
        raise BadInput(f"signal {quoted(name)} is {type(signal).__name__}, not a twin.logs.Signal")
    values = signal.values
    if not (isinstance(values, list) and all(isinstance(v, str) for v in values)):
        values = np.asarray(values)
        if values.ndim != 1:
            raise BadInput(f"signal {quoted(name)} has shape {values.shape}, not (n,)")
    if signal.epoch_ns is None:
        return Signal(values)
    epoch_ns = np.asarray(signal.epoch_ns)
    if epoch_ns.dtype != np.int64 or epoch_ns.shape != (len(values),):
        raise BadInput(
            f"signal {quoted(name)}: epoch_ns is {epoch_ns.dtype} of shape {epoch_ns.shape}; "
            f"int64 of shape ({len(values)},) will do"
        )
    check_times(name, epoch_ns)
    return Signal(values, epoch_ns)


def brought(values: Array, from_ns: NDArray[np.int64], to_ns: NDArray[np.int64]) -> Array:
    """The newest value at or before each time; NaN, or no text, before the first. Shape (m,)."""
    if np.array_equal(from_ns, to_ns):
        return values
    newest = np.searchsorted(from_ns, to_ns, side="right") - 1
    nothing = np.array(["" if values.dtype.kind == "U" else np.nan], values.dtype)
    return np.concatenate([values, nothing])[np.where(newest < 0, len(values), newest)]
