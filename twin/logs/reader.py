"""A kind of log: whether a path is one, and what is in it. CSV is one, CAN and NMEA are others."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from twin.logs.log import Log
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal


class Reader:
    """Base of a reader. A subclass gives `signals`, or `found` with what it had to leave out."""

    name: ClassVar[str] = "log"
    """What messages call a log of this kind."""
    own_map: ClassVar[Mapping[str, object]] = {}
    """Column map of a kind of log that names its own signals, as its TOML would read."""

    def fits(self, path: Path, head: bytes) -> bool:
        """True if the reader can read the path; `head` is the first 4096 bytes of the file."""
        return False

    def signals(self, path: Path) -> Mapping[str, Signal]:
        """Signal name -> signal of the log. Raises BadInput if the file cannot be read."""
        raise NotImplementedError

    def found(self, path: Path, reading: Reading) -> Found:
        """The signals, the map that goes with them, and what could not be read. Raises BadInput."""
        return Found(signals=self.signals(path), own_map=self.own_map)

    def whole(self, path: Path) -> Log | None:
        """The log, where a file holds streams and a set-up and needs no map. Raises BadInput."""
        return None
