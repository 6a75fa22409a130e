"""The streams of a run folder of our own: streams/setup.json and streams/<sensor>.parquet."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from twin.errors import BadInput, UnknownName
from twin.logs.cells import LARGEST, Text, quoted
from twin.logs.log import Log
from twin.logs.reader import Reader
from twin.logs.readers.parquet_table import read_parquet
from twin.logs.setup_block import setup_from
from twin.streams import COLUMNS, Setup, Streams, Table


class RunFolder(Reader):
    """A run folder, or its `streams` folder, which says all of itself."""

    name = "run folder"

    def fits(self, path: Path, head: bytes) -> bool:
        """Any directory."""
        return path.is_dir()

    def whole(self, path: Path) -> Log:
        """Its streams and set-up. Raises BadInput if it is malformed."""
        folder = path / "streams" if (path / "streams").is_dir() else path
        setup_json = folder / "setup.json"
        if not setup_json.is_file():
            raise BadInput(
                "a directory without streams/setup.json is not a run folder; name a log file"
            )
        files = sorted(folder.glob("*.parquet"))
        if not files:
            raise BadInput(f"{folder.name}/ has no .parquet file")
        setup = _setup(setup_json)
        tables = {f.stem: _table(f, (*COLUMNS, *setup.extra)) for f in files}
        return Log(streams=Streams(tables), setup=setup)


def _setup(path: Path) -> Setup:
    try:
        raw = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path.name} is not JSON: {error}") from None
    if not isinstance(raw, dict):
        raise BadInput(f"{path.name} is not a set-up but a {type(raw).__name__}")
    return setup_from(raw, where=path.name, assume=False)


def _table(path: Path, streams: Sequence[str]) -> Table:
    if path.stem not in streams:
        raise BadInput(f"{path.name}: {UnknownName('stream', path.stem, streams)}")
    table: Table = {}
    for column, cells in read_parquet(path).items():
        if isinstance(cells, Text) or cells.dtype.kind not in "iuf":
            raise BadInput(f"{path.name}: column {quoted(column)} does not hold numbers")
        if cells.dtype.kind == "f" and np.any(np.abs(cells) > LARGEST):
            raise BadInput(f"{path.name}: column {quoted(column)} holds a value beyond {LARGEST:g}")
        table[column] = cells
    return table
