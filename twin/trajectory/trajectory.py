"""Noise-free quantities of a drive on the physics grid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.streams import Array, read_only
from twin.trajectory.end import End


@dataclass(frozen=True)
class Trajectory:
    """A chunk of a drive: every column is taken at the same epochs; chunks are contiguous."""

    epoch_ns: NDArray[np.int64]
    """Physics grid, shape (n,)."""
    columns: Mapping[str, Array]
    """Quantity by name, each of shape (n, ...)."""
    end: End | None = None
    """End of the drive, in the last chunk; None in other chunks."""

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.epoch_ns)

    def read_only(self) -> Trajectory:
        """Trajectory with the same rows, through views that cannot be written to."""
        columns = {name: read_only(column) for name, column in self.columns.items()}
        return Trajectory(read_only(self.epoch_ns), columns, self.end)

    def cut(self, start: int, stop: int) -> Trajectory:
        """Trajectory with the rows from `start` to `stop` - 1, without `end`."""
        columns = {name: column[start:stop] for name, column in self.columns.items()}
        return Trajectory(self.epoch_ns[start:stop], columns)
