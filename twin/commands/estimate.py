"""`twin estimate LOG`: run estimators on a recorded drive."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.output import check_files, check_folder
from twin.commands.parse import parse, seconds
from twin.commands.run import DEFAULT_ESTIMATORS, load_estimators, status
from twin.commands.terminal import counting, say
from twin.errors import BadInput

if TYPE_CHECKING:
    from twin.pipeline.result import Result


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Run the estimators on a recorded drive: a run folder, a table, NMEA, CAN, UBX or a bag."""

    log: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """The recorded drive, or the files it is in; the clock of the first counts."""
    map: Path | None = None
    """TOML file that gives the meaning and the unit of each column."""
    reader: str | None = None
    """What reads it: bag, can, csv, mat, nmea, parquet, run-folder, ubx or module:Name."""
    strict: bool = False
    """Refuse a log with a single bad row."""
    offset: tuple[str, ...] = ()
    """FILE=SECONDS, how far a file's clock is ahead of the first's; else the speeds say it."""
    out: Path | None = None
    """Folder for the results; by default runs/<name of the log>."""
    csv: Path | None = None
    """File for the estimates as CSV, with units in the names of its columns."""
    figures: Path | None = None
    """Folder for the report's figures as SVG and PDF, one column (85 mm) wide."""
    estimators: str = DEFAULT_ESTIMATORS
    """Estimators, separated by commas: names, or module:Name of your own."""
    hide: str = ""
    """Hide GNSS for these times [s], such as 1,10,30,60, at regular places while driving, and score
    the speed that each estimator predicts."""
    tuning: Path | None = None
    """File of `twin tune`: other noises of some of the estimators."""
    view: bool = False
    """Open the recording in the rerun viewer at the end."""
    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print the scores and slip as JSON instead of tables."""


def main(args: Sequence[str]) -> int:
    """Read a log, run the estimators, write the folder, print the result."""
    options = parse(Estimate, args, prog="twin estimate")
    if not options.log:
        raise BadInput("no log is named; twin estimate LOG [LOG...]")
    absent = [log for log in options.log if options.reader is None and not log.exists()]
    if absent:  # before anything heavy is loaded
        raise BadInput(f"{absent[0]}: there is no such file")
    from twin.io import run_folder

    directory = options.out or Path("runs") / options.log[0].resolve().stem
    if directory.resolve() in [log.resolve() for log in options.log]:
        raise BadInput(f"--out {directory} is the log itself; choose another folder")
    run_folder.refuse_foreign(directory)
    check_folder("figures", options.figures)
    check_files(csv=options.csv)
    estimators = load_estimators(options.estimators)
    from twin import logs
    from twin.pipeline.log import estimate

    reader = None if options.reader is None else logs.reader(options.reader)
    shown = not (options.quiet or options.json)
    with counting("estimating", "estimators", shown=shown) as report:
        result = estimate(
            options.log, options.map, estimators=estimators, reader=reader, progress=report,
            strict=options.strict, offset_s=offsets(options.offset),
            hide_s=seconds("hide", options.hide), tuning=options.tuning,
        )  # fmt: skip
    result.save(directory, command=f"twin estimate {shlex.join(args)}")
    if options.figures is not None:
        result.figures(options.figures)
    csv_time = None if options.csv is None else result.csv(options.csv)
    _say(result, directory, options, csv_time)
    if options.view:
        from twin import viz

        viz.view(directory / "run.rrd")
    return status(result)


def offsets(words: Sequence[str]) -> dict[str, float]:
    """File -> seconds from words as `gnss.nmea=3.7`. Raises BadInput."""
    found = {}
    for word in words:
        name, equals, seconds = word.rpartition("=")
        try:
            found[name] = float(seconds)
        except ValueError:
            equals = ""
        if not (name and equals and abs(found[name]) < 1e10):
            raise BadInput(f"--offset {word} is not FILE=SECONDS, as gnss.nmea=3.7")
    return found


def _say(result: Result, directory: Path, options: Estimate, csv_time: str | None) -> None:
    if options.json:
        print(json.dumps(result.scores, indent=2))
    elif not options.quiet:
        from twin.commands.log_summary import print_log
        from twin.commands.score_table import print_hidden, print_scores

        print_scores(result.scores)
        print_hidden(result.scores)
        print_log(result.scores)
        if csv_time is not None:
            say(f"{options.csv}: {csv_time}")
        say(f"{directory}/report.html, {directory}/run.rrd")
