"""`twin estimate LOG`: run estimators on a recorded drive."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.output import check_folder
from twin.commands.parse import parse, seconds
from twin.commands.run import DEFAULT_ESTIMATORS, load_estimators, status
from twin.commands.score_table import print_hidden, print_scores
from twin.commands.terminal import counting, say
from twin.errors import BadInput
from twin.scores.table import slip_lines

if TYPE_CHECKING:
    from twin.pipeline.result import Result


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Run the estimators on a recorded drive: a run folder, CSV, Parquet or NMEA 0183."""

    log: Annotated[Path, tyro.conf.Positional]
    """The recorded drive."""
    map: Path | None = None
    """TOML file that gives the meaning and the unit of each column."""
    reader: str | None = None
    """What reads it, csv, parquet, nmea or run-folder, or module:Name of your own."""
    out: Path | None = None
    """Folder for the results; by default runs/<name of the log>."""
    figures: Path | None = None
    """Folder for the report's figures as SVG and PDF, one column (85 mm) wide."""
    estimators: str = DEFAULT_ESTIMATORS
    """Estimators, separated by commas: names, or module:Name of your own."""
    hide: str = ""
    """Hide GNSS for so many seconds, such as 1,10,30,60, at regular places while driving, and score
    what each estimator foretells of the receiver's speed."""
    view: bool = False
    """Open the recording in the rerun viewer at the end."""
    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print the scores and slip as JSON instead of tables."""


def main(args: Sequence[str]) -> int:
    """Read a log, run the estimators, write the folder, print the result."""
    options = parse(Estimate, args, prog="twin estimate")
    from twin.io import run_folder

    directory = options.out or Path("runs") / options.log.resolve().stem
    if directory.resolve() == options.log.resolve():
        raise BadInput(f"--out {directory} is the log itself; choose another folder")
    run_folder.refuse_foreign(directory)
    check_folder("figures", options.figures)
    estimators = load_estimators(options.estimators)
    from twin import logs
    from twin.pipeline.log import estimate

    reader = None if options.reader is None else logs.reader(options.reader)
    shown = not (options.quiet or options.json)
    with counting("estimating", "estimators", shown=shown) as told:
        result = estimate(
            options.log,
            options.map,
            estimators=estimators,
            reader=reader,
            hide_s=seconds("hide", options.hide),
            told=told,
        )
    result.save(directory, command=f"twin estimate {shlex.join(args)}")
    if options.figures is not None:
        result.figures(options.figures)
    _say(result, directory, options)
    if options.view:
        from twin import viz

        viz.view(directory / "run.rrd")
    return status(result)


def _say(result: Result, directory: Path, options: Estimate) -> None:
    if options.json:
        print(json.dumps(result.scores, indent=2))
    elif not options.quiet:
        print_scores(result.scores)
        notes = [f"note: {note}" for note in result.notes]
        files = f"{directory}/report.html, {directory}/run.rrd"
        print_hidden(result.scores)
        for line in (*slip_lines(result.scores), *notes, files):
            say(line)
