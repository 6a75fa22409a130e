"""`twin export DIR --as FORMAT`: a run as the files of a real machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from twin.commands.parse import parse
from twin.commands.terminal import say
from twin.errors import BadInput


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write the streams of a run as the files of a real machine, with the map that reads them."""

    directory: Annotated[Path, tyro.conf.Positional]
    """Run folder."""
    as_: Annotated[str, tyro.conf.arg(name="as")]
    """candump, nmea, mcap or csv."""
    out: Path | None = None
    """New folder for the files; by default <run folder>-<format>."""
    quiet: bool = False
    """Print errors only."""


def main(args: Sequence[str]) -> int:
    """Read a run's streams, write them."""
    options = parse(Export, args, prog="twin export")
    from twin import logs
    from twin.logs.export import export

    if not options.directory.is_dir():
        raise BadInput(f"{options.directory} is no run folder; twin run writes folders below runs/")
    log = logs.read(options.directory)
    name = options.directory.resolve().name
    directory = options.out or options.directory.resolve().parent / f"{name}-{options.as_}"
    if directory.exists():
        raise BadInput(f"{directory} exists; name another folder with --out")
    lost = export(log.streams, log.setup, options.as_, directory)
    if not options.quiet:
        for path in sorted(directory.rglob("*")):
            if path.is_file():
                say(str(path))
        if lost:
            say(f"note: {options.as_} does not hold {', '.join(lost)}")
    return 0
