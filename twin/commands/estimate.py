"""`twin estimate LOG`: the same estimators on a recorded drive."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.parse import parse
from twin.commands.run import DEFAULT_ESTIMATORS, load_estimators, status
from twin.commands.terminal import console, counting, print_scores
from twin.errors import BadInput
from twin.scores.table import slip_lines

if TYPE_CHECKING:
    from twin.pipeline.result import Result


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Run the estimators on a recorded drive: a run folder, CSV, Parquet or NMEA 0183."""

    log: Annotated[Path, tyro.conf.Positional]
    """The log."""
    map: Path | None = None
    """TOML that says which column is what, and in which unit."""
    reader: str | None = None
    """What reads it, csv, parquet, nmea or run-folder, or module:Name of your own."""
    out: Path | None = None
    """Folder to write; runs/<name of the log> by default."""
    estimators: str = DEFAULT_ESTIMATORS
    """Names, or module:Name of your own, separated by commas."""
    view: bool = False
    """Open the recording when done."""
    quiet: bool = False
    """Say nothing but errors."""
    json: bool = False
    """Print scores and slip as JSON instead of tables."""


def main(args: Sequence[str]) -> int:
    """Read a log, run the estimators, write the folder, print what they say."""
    options = parse(Estimate, args, prog="twin estimate")
    from twin.io import run_folder

    directory = options.out or Path("runs") / options.log.resolve().stem
    if directory.resolve() == options.log.resolve():
        raise BadInput(f"--out {directory} is the log itself; choose another folder")
    run_folder.refuse_foreign(directory)
    estimators = load_estimators(options.estimators)
    from twin import logs
    from twin.pipeline.log import estimate

    reader = None if options.reader is None else logs.reader(options.reader)
    shown = not (options.quiet or options.json)
    with counting("estimating", "estimators", shown=shown) as told:
        result = estimate(options.log, options.map, estimators=estimators, reader=reader, told=told)
    result.save(directory, command=f"twin estimate {shlex.join(args)}")
    _say(result, directory, options)
    if options.view:
        from twin import viz

        viz.view(directory / "run.rrd")
    return status(result)


def _say(result: Result, directory: Path, options: Estimate) -> None:
    if options.json:
        print(json.dumps(result.scores, indent=2))
    elif not options.quiet:
        out = console()
        print_scores(result.scores)
        notes = [f"note: {note}" for note in result.notes]
        files = f"{directory}/report.html, {directory}/run.rrd"
        for line in (*slip_lines(result.scores), *notes, files):
            out.print(line, highlight=False, markup=False)
