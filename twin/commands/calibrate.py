"""`twin calibrate LOG`: find the machine and the soil that explain a recorded drive."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import say
from twin.errors import BadInput

if TYPE_CHECKING:
    from twin.calibration.calibrate import Calibration
    from twin.calibration.held_out import Score


@dataclass(frozen=True, kw_only=True)
class Calibrate:
    """Find the machine and the soil that explain a recorded drive, and what it cannot tell."""

    log: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """The recorded drive, or the files it is in; the clock of the first counts."""
    map: Path | None = None
    """TOML file that gives the meaning and the unit of each column."""
    reader: str | None = None
    """What reads it: bag, can, csv, mat, nmea, parquet, run-folder, ubx or module:Name."""
    machine: str = ""
    """The tractor that was driven: a name of `twin list`, or a file. It is believed as its grades
    say."""
    soil: str = "tilled"
    """Soil preset that is believed before the log."""
    parameters: str = ""
    """What is fitted, separated by commas; by default all that such a log may tell of."""
    fit: str = "0:0.667"
    """Share of the steady work, by time, that is fitted: FROM:TO."""
    holdout: str = "0.667:1"
    """Share of it that is never fitted, and foretold."""
    out: Path | None = None
    """Folder for the machine's file, the posterior and the soil; by default
    calibrated/<name of the log>."""
    seed: int = 0
    """Of the starts of the search, and of the draws of intervals."""
    starts: int = 3
    """Searches, the first from what is believed."""
    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print what was found as JSON instead of tables."""


def main(args: Sequence[str]) -> int:
    """Read a log, fit, write the files, print what was found."""
    options = parse(Calibrate, args, prog="twin calibrate")
    if not options.log:
        raise BadInput("no log is named; twin calibrate LOG --machine FILE")
    absent = [log for log in options.log if options.reader is None and not log.exists()]
    if absent:  # before anything heavy is loaded
        raise BadInput(f"{absent[0]}: there is no such file")
    if not options.machine:
        raise BadInput("no machine is named; --machine with a name of twin list, or a file")
    parts = {name: _part(name, getattr(options, name)) for name in ("fit", "holdout")}
    from twin.calibration.calibrate import calibrate
    from twin.calibration.written import plain, write

    names = tuple(n.strip() for n in options.parameters.split(",") if n.strip())
    found = calibrate(
        options.log, options.map, options.machine, options.reader, parameters=names,
        soil=options.soil, fit_part=parts["fit"], held_part=parts["holdout"], seed=options.seed,
        starts=options.starts,
    )  # fmt: skip
    folder = options.out or Path("calibrated") / options.log[0].resolve().stem
    file = write(found, folder, f"twin calibrate {shlex.join(args)}")
    if options.json:
        print(json.dumps(plain(found), indent=2))
    elif not options.quiet:
        _print(found)
        say(f"{file}: twin run plough-25cm --machine {file} --posterior 30")
    return 0


def _gain(score: Score) -> str:
    if math.isnan(score.gain_low):
        return "too few blocks to tell it from the line"
    return f"gain over the line {score.gain_low:+.4f} to {score.gain_high:+.4f}: {score.verdict}"


def _part(name: str, text: str) -> tuple[float, float]:
    try:
        first, last = (float(each) for each in text.split(":"))
    except ValueError:
        raise BadInput(f"--{name} {text} is not FROM:TO, such as 0:0.667") from None
    return first, last


def _print(found: Calibration) -> None:
    values = found.parameters
    print_table([
        Column(heading="parameter", cells=[v.name for v in values], text=True),
        Column(heading="value", cells=[f"{v.value:.4g}" for v in values]),
        Column(heading="95 %", cells=[f"{v.low:.4g} to {v.high:.4g}" for v in values], rank=1),
        Column(heading="unit", cells=[v.unit for v in values], text=True, rank=2),
        Column(heading="before", cells=[f"{v.prior:.4g}" for v in values], rank=3),
        Column(heading="", cells=[v.verdict for v in values], text=True),
    ])  # fmt: skip
    for each in found.together:
        say(str(each))
    for value in values:
        if value.verdict != "identified":
            say(f"{value.name}: {value.settles} would settle it", indent=2)
    gears = ", ".join(f"{g.name} ({g.share:.0%} of the time)" for g in found.gears)
    say(f"gears: {gears or 'none found'}")
    if math.isfinite(found.lag_s):
        say(f"the receiver's speed is {found.lag_s:.2f} s late")
    score = found.holdout
    print_table([
        Column(heading="held out, slip", text=True,
               cells=["calibrated twin", "line of torque x speeds", "constant"]),
        Column(heading="rms", cells=[f"{v:.4f}" for v in
                                     (score.slip_rms, score.line_rms, score.constant_rms)]),
    ])  # fmt: skip
    say(
        f"{score.rows} rows, {score.blocks} blocks of five minutes; {score.coverage:.0%} in their "
        f"95 % band; {_gain(score)}"
    )
    for note in found.notes:
        say(note)
