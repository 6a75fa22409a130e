"""`twin view DIR`: open the recording of a run folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from twin.commands.parse import parse
from twin.errors import BadInput


@dataclass(frozen=True, kw_only=True)
class View:
    """Open the recording of a run folder in the rerun viewer."""

    directory: Annotated[Path, tyro.conf.Positional]
    """Run folder or .rrd file."""


def main(args: Sequence[str]) -> int:
    """Find the recording and start the viewer."""
    options = parse(View, args, prog="twin view")
    recording = find(options.directory)
    from twin import viz

    viz.view(recording)
    return 0


def find(path: Path) -> Path:
    """The recording of a run folder, or the .rrd file itself. Raises BadInput for others."""
    if not path.exists():
        raise BadInput(f"{path} does not exist; twin run writes folders below runs/")
    recording = path / "run.rrd" if path.is_dir() else path
    if not recording.is_file():
        raise BadInput(f"{path} holds no run.rrd; it is not a run folder")
    if recording.suffix != ".rrd":
        raise BadInput(f"{path} is neither a run folder nor an .rrd file")
    return recording
