"""`twin validate`: repeat every check of VALIDATION.md and write the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from twin.commands.bench import print_rows
from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.terminal import counting, say
from twin.errors import BadInput, check_range
from twin.io.atomic import write_text
from twin.vehicle import files

if TYPE_CHECKING:
    from twin.validate.check import Check

BROKEN_PROMISE = 1


@dataclass(frozen=True, kw_only=True)
class Validate(Output):
    """Check the twin against mechanics, published laws and tables, and field measurements."""

    jobs: int = 1
    """Number of processes; -1 for one per core."""
    out: Path | None = None
    """File for the page in Markdown, such as VALIDATION.md."""
    report: Path | None = None
    """File for an HTML page: failed checks, and a figure and a table of each layer."""
    machine: str | None = None
    """Check what mechanics asks of this machine, a name or a file, and nothing else."""
    quick: bool = False
    """Use one seed of each field run: the same rows with more scatter, within a minute."""


def main(args: Sequence[str]) -> int:
    """Run every check; status 1 where a row fails."""
    options = parse(Validate, args, prog="twin validate")
    if options.jobs != -1:
        check_range("jobs", options.jobs, 1, 1024)
    check_files(json=options.json, out=options.out, report=options.report)
    if options.machine is not None:
        files.machine(options.machine)
        for name in ("quick", "out"):
            if getattr(options, name):
                raise BadInput(f"--{name} would not be read with --machine; leave one of them out")
    from twin.compute.parallel import reporting
    from twin.validate import page, suite

    with counting("validating", "checks", shown=options.talks) as report, reporting(report):
        if options.machine is None:
            found = suite.checks(jobs=options.jobs, quick=options.quick)
        else:
            found = suite.of_machine(options.machine, jobs=options.jobs)
    measured = [check.row for of_layer in found.values() for check in of_layer]
    deliver(measured, options.json)
    if options.out is not None:
        write_text(options.out, page.text(found, quick=options.quick))
    if options.report is not None:
        _report(found, options.report, quick=options.quick)
    failed = [check for of_layer in found.values() for check in of_layer if not check.passed]
    if options.talks:
        print_rows(measured)
        said = f"{len(measured)} rows, {len(failed)} fail"
        say("; ".join([said, *(", ".join(c.name) for c in failed)]))
    return BROKEN_PROMISE if failed else 0


def _report(found: Mapping[str, Sequence[Check]], path: Path, *, quick: bool) -> None:
    from twin.report import rows
    from twin.validate.suite import LAYERS

    sections = {LAYERS[layer]: [c.row for c in checks] for layer, checks in found.items()}
    about = "Sources, reasons and what is not validated stand in VALIDATION.md."
    command = "twin validate --quick" if quick else "twin validate"
    rows.write_checks(path, "Validation", about, sections, command)
