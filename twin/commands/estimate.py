"""`twin estimate LOG`: the same estimators on a recorded drive."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from twin.commands.parse import parse
from twin.commands.run import DEFAULT_ESTIMATORS, load_estimators
from twin.commands.terminal import Stopwatch, console, counting, print_scores
from twin.errors import BadInput
from twin.scores.table import slip_lines

if TYPE_CHECKING:
    from twin.io.run_folder import Record, RunLike
    from twin.logs import Log
    from twin.pipeline.log_check import SteadySlip
    from twin.streams import Table


MOVING_MPS = 0.5
"""Slip below this speed says nothing and is left out of the summary [m/s]."""


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
    from twin import logs
    from twin.io import run_folder as runfolder

    directory = options.out or Path("runs") / options.log.resolve().stem
    if directory.resolve() == options.log.resolve():
        raise BadInput(f"--out {directory} is the log itself; choose another folder")
    runfolder.refuse_foreign(directory)
    estimators = load_estimators(options.estimators)
    reader = None if options.reader is None else logs.reader(options.reader)
    log, steady = _prepared(logs.read(options.log, options.map, reader))
    shown = not (options.quiet or options.json)
    with counting("estimating", "estimators", shown=shown) as told:
        record = estimated(log, estimators, reference=_reference(log, options.log), told=told)
    table = findings(record, options.log.stem, log, steady)
    runfolder.write(
        record, table, directory, pictures=_pictures(f"twin estimate {shlex.join(args)}")
    )
    _say(table, directory, options)
    if options.view:
        from twin import viz

        viz.view(directory / "run.rrd")
    return 0


def estimated(
    log: Log,
    estimators: Mapping[str, Any],
    *,
    reference: Table | None = None,
    told: Callable[[int, int], None] = lambda done, total: None,
) -> Record:
    """The estimates of every estimator over the whole log."""
    from twin.io.run_folder import Record
    from twin.pipeline import estimating

    watch = Stopwatch()
    estimates = {}
    for done, (name, estimator) in enumerate(estimators.items()):
        told(done, len(estimators))
        estimates[name] = estimating.estimates(name, estimator, log.setup, log.streams)
    return Record(
        setup=log.setup,
        streams=log.streams,
        truth=reference,
        estimates=estimates,
        wall_s=watch.seconds(),
    )


def findings(record: Record, name: str, log: Log, steady: SteadySlip | None) -> dict[str, Any]:
    """Scores where the log has a reference, the slip of each estimator, steady work and notes."""
    from twin.scores import scores

    table = scores.score(record.truth, record.estimates, scenario=name, seed=None)
    table["slip"] = {n: slip_summary(t) for n, t in record.estimates.items()}
    if steady is not None:
        table["steady_slip"] = {n: steady_summary(log, t) for n, t in record.estimates.items()}
    table["notes"] = list(log.notes)
    if steady is not None:
        table["steady"] = {
            "slip_median": steady.median, "slip_low": steady.low, "slip_high": steady.high,
            "n": steady.n, "rule": steady.rule, "scale": steady.scale.scale,
            "scale_low": steady.scale.low, "scale_high": steady.scale.high,
            "scale_n": steady.scale.n, "scale_rule": steady.scale.rule,
            "lag_s": _known(steady.lag_s),
        }  # fmt: skip
    return table


def slip_summary(estimates: Table) -> dict[str, float | int | None]:
    """Median, 5 % and 95 % of the estimated slip while driving faster than 0.5 m/s."""
    if "slip" not in estimates:
        return _quantiles(np.empty(0))
    slip = np.asarray(estimates["slip"], np.float64)
    speed = np.asarray(estimates.get("speed_mps", np.full(len(slip), np.inf)), np.float64)
    return _quantiles(slip[np.abs(speed) > MOVING_MPS])


def steady_summary(log: Log, estimates: Table) -> dict[str, float | int | None]:
    """The same over the rows of steady work, as the map's rule chooses them."""
    from twin import logs
    from twin.scores import scores

    _, wheel_mps = logs.paired_speeds(log.streams)
    epoch_ns = log.streams["wheels"]["epoch_ns"]
    chosen = logs.choose(log.rules["steady"], log.rows, epoch_ns, wheel_mps)
    if "slip" not in estimates or not len(estimates["epoch_ns"]):
        return _quantiles(np.empty(0))
    return _quantiles(scores.at(estimates, "slip", epoch_ns[chosen]))


def _quantiles(slip: np.ndarray[Any, Any]) -> dict[str, float | int | None]:
    known = slip[np.isfinite(slip)]
    if not len(known):
        return {"median": None, "p05": None, "p95": None, "n": 0}
    p05, median, p95 = (float(q) for q in np.quantile(known, (0.05, 0.5, 0.95)))
    return {"median": median, "p05": p05, "p95": p95, "n": len(known)}


def _prepared(log: Log) -> tuple[Log, SteadySlip | None]:
    """The log with wheel speeds scaled to zero slip where its map gives the rules."""
    from twin.pipeline import log_check as logcheck

    if "zero_slip" not in log.rules:
        return log, None
    scaled = logcheck.scaled(log, logcheck.log_scale(log).scale)
    return scaled, logcheck.steady_slip(log) if "steady" in log.rules else None


def _reference(log: Log, path: Path) -> Table | None:
    """The log's own reference; for a run folder, its truth."""
    from twin.io import run_folder as runfolder

    truth = path / runfolder.TRUTH
    if log.reference is None and path.is_dir() and truth.exists():
        return runfolder.read_parquet(truth)
    return log.reference


def _pictures(command: str) -> Mapping[str, Any]:
    from twin import report

    return {"report.html": partial(report.write, command=command), "run.rrd": _record}


def _record(run: RunLike, scores: Mapping[str, Any], path: Path) -> None:
    from twin import viz

    viz.log(
        path,
        streams=run.streams,
        setup=run.setup,
        estimates=run.estimates,
        reference=run.truth,
        notes=scores["notes"],
    )


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _say(table: Mapping[str, Any], directory: Path, options: Estimate) -> None:
    if options.json:
        print(json.dumps(table, indent=2))
    elif not options.quiet:
        out = console()
        print_scores(table)
        notes = [f"note: {note}" for note in table["notes"]]
        for line in (*slip_lines(table), *notes, f"{directory}/report.html, {directory}/run.rrd"):
            out.print(line, highlight=False, markup=False)
