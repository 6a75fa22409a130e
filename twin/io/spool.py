"""Tables that grow by chunks and do not fill the memory: long ones go on in files.

A column of a table above `MOST_BYTES` is appended to a temporary file, and read back through a
memory map, which the system holds or drops as it likes. The files have no names, so nothing is left
behind by a process that is killed. They lie where the system keeps temporary files (`TMPDIR`).
"""

from __future__ import annotations

import tempfile
import weakref
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from twin.streams import Table

MOST_BYTES = 64 * 2**20
"""Of one table in memory: some minutes of truth, an hour of a stream."""


class Spool:
    """A table of which chunks arrive."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        """An empty one that keeps so much in memory."""
        self.most_bytes, self.held_bytes = most_bytes, 0
        self.parts: list[Table] = []
        self.files: dict[str, IO[bytes]] = {}
        weakref.finalize(self, _close, self.files)
        self.kinds: dict[str, tuple[np.dtype[Any], tuple[int, ...]]] = {}

    def append(self, table: Table) -> None:
        """Append rows; every chunk has the columns of the first."""
        self.parts.append({name: np.array(column) for name, column in table.items()})
        self.held_bytes += sum(column.nbytes for column in self.parts[-1].values())
        if self.held_bytes > self.most_bytes:
            self._flush()

    def table(self) -> Table:
        """All rows, in memory or mapped from the files; the spool is empty then."""
        if self.files:
            self._flush()
            joined = {name: self._mapped(name) for name in self.files}
        else:
            joined = {n: np.concatenate([p[n] for p in self.parts]) for n in self.parts[0]}
        self.parts, self.held_bytes = [], 0
        return joined

    def _flush(self) -> None:
        if not self.parts:
            return
        for name in self.parts[0]:
            rows = np.concatenate([part[name] for part in self.parts])
            if name not in self.files:
                self.files[name] = tempfile.TemporaryFile()  # noqa: SIM115  # closed when it is mapped
                self.kinds[name] = rows.dtype, rows.shape[1:]
            self.files[name].write(np.ascontiguousarray(rows).data)
        self.parts, self.held_bytes = [], 0

    def _mapped(self, name: str) -> NDArray[Any]:
        with self.files[name] as file:
            file.flush()
            kind, inner = self.kinds[name]
            return np.asarray(np.memmap(file, kind, mode="r+")).reshape(-1, *inner)


def _close(files: dict[str, IO[bytes]]) -> None:
    """Close what a spool that was given up has open."""
    for file in files.values():
        file.close()
