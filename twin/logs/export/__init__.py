"""Streams written as the files of a real machine, each with the column map that reads it back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from twin.errors import UnknownName
from twin.io.atomic import renamed_when_complete
from twin.logs.export.candump import write_candump
from twin.logs.export.mcap import write_mcap
from twin.logs.export.nmea import write_nmea
from twin.logs.export.tables import write_tables
from twin.streams import Setup, Streams

Writer = Callable[[Streams, Setup, Path], list[str]]
"""Writes files into a folder; says what of the streams is not in them."""
WRITERS: dict[str, Writer] = {
    "candump": write_candump,
    "nmea": write_nmea,
    "mcap": write_mcap,
    "csv": write_tables,
}
"""By the name of the format."""


def export(streams: Streams, setup: Setup, kind: str, directory: Path) -> list[str]:
    """Write streams in a format; what of them it does not hold. All stamps are epochs.

    Args:
        streams: the samples.
        setup: nominal machine, which goes into the map.
        kind: key of WRITERS.
        directory: a new folder for the files.

    Raises:
        UnknownName: there is no such format.
        BadInput: the streams hold nothing that the format can; the folder cannot be written.
    """
    if kind not in WRITERS:
        raise UnknownName("format of logs", kind, WRITERS)
    with renamed_when_complete(directory) as partial:
        return WRITERS[kind](streams, setup, partial)
