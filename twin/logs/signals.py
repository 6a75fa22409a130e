"""What a reader finds in a log: named signals, with times of their own where they have such."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import Cells, Text, quoted
from twin.logs.losses import Loss
from twin.streams import Array

MAX_NS = 2**62
"""Half the int64 range (146 years), so that a difference of two stamps cannot overflow."""


@dataclass(frozen=True)
class Signal:
    """One signal of a log, in its own unit."""

    values: Cells | list[str]
    """Text cells, or an array of numbers or datetime64, shape (n,)."""
    epoch_ns: NDArray[np.int64] | None = None
    """When each was measured, rising; None for a column of a table, whose rows share a time."""

    @property
    def cells(self) -> Cells:
        """The values, a list of texts as Text."""
        return Text.of(self.values) if isinstance(self.values, list) else self.values


@dataclass(frozen=True, kw_only=True)
class Found:
    """Signals and other content that a reader finds in a file."""

    signals: Mapping[str, Signal]
    """By name."""
    own_map: Mapping[str, object] = field(default_factory=dict)
    """Column map of these signals where the file says what they are, as its TOML would read."""
    losses: tuple[Loss, ...] = ()
    """Rows, lines or frames that could not be read."""
    notes: tuple[str, ...] = ()
    row: NDArray[np.int64] | None = None
    """Number in the file, from 1, of each row of a table that has lost some."""


def checked(name: str, signal: object) -> Signal:
    """A signal as the map can take it. Raises BadInput that names it."""
    if not isinstance(signal, Signal):
        raise BadInput(f"signal {quoted(name)} is {type(signal).__name__}, not a twin.logs.Signal")
    values = signal.values
    if isinstance(values, list) and all(isinstance(v, str) for v in values):
        values = Text.of(values)
    elif not isinstance(values, Text):
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
    if len(epoch_ns) and max(-int(epoch_ns.min()), int(epoch_ns.max())) > MAX_NS:
        raise BadInput(f"signal {quoted(name)}: a time is more than 146 years from zero")
    return Signal(values, epoch_ns)


def brought(values: Array, from_ns: NDArray[np.int64], to_ns: NDArray[np.int64]) -> Array:
    """Newest value at or before each time; NaN, or empty text, before the first. Shape (m,).

    Args:
        values: values of a signal. Shape (n,).
        from_ns: times of the values [ns], ascending. Shape (n,).
        to_ns: times of the result [ns]. Shape (m,).
    """
    if np.array_equal(from_ns, to_ns):
        return values
    newest = np.searchsorted(from_ns, to_ns, side="right") - 1
    nothing = np.array(["" if values.dtype.kind == "U" else np.nan], values.dtype)
    return np.concatenate([values, nothing])[np.where(newest < 0, len(values), newest)]
