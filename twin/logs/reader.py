"""A kind of log: whether a path is one, and what is in it. CSV is one, CAN or UBX may be others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

from twin.errors import BadInput
from twin.logs.build import log_from_signals
from twin.logs.column_map import ColumnMap, column_map_from
from twin.logs.log import Log
from twin.logs.signals import Signal, checked


class Reader:
    """Base of a reader. A subclass gives `signals`; or `read`, where a file says all by itself."""

    name: ClassVar[str] = "log"
    """What messages call a log of this kind."""
    own_map: ClassVar[Mapping[str, object]] = {}
    """Column map of a kind of log that names its own signals, as its TOML would read."""

    def fits(self, path: Path, head: bytes) -> bool:
        """Whether a path looks like one; `head` are a file's first 4096 bytes."""
        return False

    def signals(self, path: Path) -> Mapping[str, Signal]:
        """Every signal of a log, by name. Raises BadInput."""
        raise NotImplementedError

    def read(self, path: Path, column_map: ColumnMap | None) -> Log:
        """The log at a path, through a column map or the reader's own. Raises BadInput."""
        columns_of = self._map(column_map)
        if columns_of is None:
            raise BadInput(
                f"a {self.name} log needs a column map (TOML) that says which column is what"
            )
        found = {name: checked(name, signal) for name, signal in self.signals(path).items()}
        return log_from_signals(found, columns_of)

    def _map(self, given: ColumnMap | None) -> ColumnMap | None:
        """The user's map, with the reader's own columns where the user names none."""
        if not self.own_map:
            return given
        own = column_map_from(self.own_map)
        if given is None or given.columns:
            return given or own
        return replace(given, time=given.time or own.time, columns=own.columns)
