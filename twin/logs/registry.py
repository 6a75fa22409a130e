"""The readers of logs by name: those that come with the twin, and a user's own."""

from __future__ import annotations

from pathlib import Path

from twin.errors import BadInput, UnknownName
from twin.logs.reader import Reader
from twin.logs.readers.can_bus import Can
from twin.logs.readers.csv_table import Csv
from twin.logs.readers.mat_table import Mat
from twin.logs.readers.nmea import Nmea
from twin.logs.readers.parquet_table import Parquet
from twin.logs.readers.ros_bag import Bag
from twin.logs.readers.run_folder import RunFolder
from twin.logs.readers.ubx import Ubx
from twin.plugins.lookup import attribute, instance

READERS: dict[str, Reader] = {
    "bag": Bag(),
    "run-folder": RunFolder(),
    "parquet": Parquet(),
    "mat": Mat(),
    "ubx": Ubx(),
    "can": Can(),
    "nmea": Nmea(),
    "csv": Csv(),
}
"""By name; the first that fits a path reads it, and CSV fits any file."""


def reader(spec: str) -> Reader:
    """A reader by its name, or by `module:Name`, a class or an instance.

    Raises:
        UnknownName: no reader is called so.
        BadInput: the module cannot be imported, or what it has is no reader.
    """
    if spec in READERS:
        return READERS[spec]
    if ":" not in spec:
        raise UnknownName("reader of logs", spec, READERS)
    found = instance("reader of logs", spec, attribute("reader of logs", spec))
    if not isinstance(found, Reader):
        kind = getattr(found, "__name__", type(found).__name__)
        raise BadInput(f"reader of logs '{spec}' is {kind}; it must be a twin.logs.Reader")
    return found


def fitting(path: Path) -> Reader:
    """The reader a path needs, by its nature and its first bytes. Raises BadInput."""
    head = b""
    if not path.is_dir():
        if not path.exists():
            raise BadInput("there is no such file")
        if not path.is_file():
            raise BadInput("not a regular file")
        with path.open("rb") as file:
            head = file.read(4096)
    return next(known for known in READERS.values() if known.fits(path, head))
