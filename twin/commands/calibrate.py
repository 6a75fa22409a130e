"""`twin calibrate LOG... --machine FILE`: the machine and the soil that explain a log."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.output import STDOUT, Output, check_files, check_folder
from twin.commands.parse import parse
from twin.commands.terminal import say, waiting
from twin.errors import BadInput

if TYPE_CHECKING:
    from twin.calibration.result import Calibration


@dataclass(frozen=True, kw_only=True)
class Calibrate(Output):
    """Find the machine and the soil that explain a recorded drive, and name what it leaves open."""

    log: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """The recorded drive, or the files it is in; or a TOML file of points at the PTO."""
    map: Path | None = None
    """TOML file that gives the meaning and the unit of each column."""
    machine: str = ""
    """What is believed of the machine before: a name of twin list, or a TOML file."""
    implement: str | None = None
    """The implement: a name or a file; by default the machine's usual one."""
    soil: str = "tilled"
    """What is believed of the soil before: a preset of twin list, or a soil's file."""
    law: str = "brixius"
    """Soil law that is fitted: brixius, bekker, or your own as module:function."""
    parameters: str = ""
    """What is fitted, separated by commas; by default all that the log can determine."""
    hold_out: str = ""
    """FIRST,LAST: seconds of the log that are never fitted; by default the last quarter of work."""
    starts: int = 3
    """How many random starts the fit has."""
    seed: int = 0
    """Of the random starts."""
    jobs: int = 1
    """Threads."""
    out: Path | None = None
    """Folder for all files; by default that of the machine's file, or the working directory."""


def main(args: Sequence[str]) -> int:
    """Read a log, fit, write the files, print what was found."""
    options = parse(Calibrate, args, prog="twin calibrate")
    if not options.log:
        raise BadInput("no log is named; twin calibrate LOG --machine FILE")
    if not options.machine:
        raise BadInput("--machine is missing; a machine's file, or a name of twin list, would do")
    for log in options.log:
        if not log.exists():
            raise BadInput(f"{log}: there is no such file")
    check_folder("out", options.out)
    check_files(json=options.json)
    for option in ("starts", "jobs"):
        if getattr(options, option) < 1:
            raise BadInput(f"--{option} {getattr(options, option)}: 1 or more would do")
    held = _span(options.hold_out)
    from twin.calibration.calibrate import calibrate
    from twin.io.atomic import made, write_text
    from twin.scenario import Soil

    given = Path(options.machine)
    folder = options.out or (given.parent if given.suffix == ".toml" else Path())
    stem = given.stem if given.suffix in (".toml", ".xml") else options.machine
    names = [n.strip() for n in options.parameters.split(",") if n.strip()]
    with made(folder), waiting("calibrating", shown=options.talks):
        found = calibrate(
            options.log, options.map, machine=options.machine, parameters=names or None,
            hold_out_s=held, implement=options.implement,
            soil=Soil(preset=options.soil, law=options.law), seed=options.seed,
            starts=options.starts, jobs=options.jobs, resume=folder / f".{stem}.calibrating.json",
        )  # fmt: skip
    paths = found.save(folder, stem, f"twin calibrate {shlex.join(args)}")
    if options.json == STDOUT:
        print(json.dumps(found.scores, indent=2))
    elif options.json is not None:
        write_text(options.json, json.dumps(found.scores, indent=2) + "\n")
    if options.talks:
        _say(found, paths)
    return 0


def _span(text: str) -> tuple[float, float] | None:
    """Two rising numbers. Raises BadInput."""
    if not text:
        return None
    try:
        first, last = (float(part) for part in text.split(","))
    except ValueError:
        first, last = 1.0, 0.0
    if not first < last:
        raise BadInput(f"--hold-out {text}: two rising numbers of seconds, as 600,900, would do")
    return first, last


def _say(found: Calibration, paths: dict[str, Path]) -> None:
    from twin.calibration.page import HEADERS, about, rows, scores, settling
    from twin.commands.tables import Column, print_table

    cells = list(zip(*rows(found), strict=True))
    print_table([
        Column(heading=heading, cells=column, text=heading in ("parameter", "unit", "verdict"),
               rank=1 if heading == "before" else 0)
        for heading, column in zip(HEADERS, cells, strict=True)
    ])  # fmt: skip
    for line in (*about(found), *found.together):
        say(line)
    for line in settling(found):
        say(f"what would settle {line}")
    for name, value in scores(found):
        say(f"held back: {name} {value}")
    for note in found.notes:
        say(f"note: {note}", style="dim")
    say(", ".join(str(path) for path in paths.values()))
