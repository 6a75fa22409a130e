"""`twin reproduce PAPER`: published figures and ours side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from twin import rows as rows_file
from twin.commands.bench import print_rows
from twin.commands.parse import parse
from twin.commands.terminal import console
from twin.errors import BadInput, UnknownName, check_range
from twin.reproduce import ABOUT, REGISTRY

BROKEN_PROMISE = 1


@dataclass(frozen=True, kw_only=True)
class Reproduce:
    """Repeat a paper's experiment and print what it published beside what the twin gives."""

    trials: int = 16
    """Seeds of each case."""
    jobs: int = 1
    """Processes to run them in; -1 for one a core."""
    json: Path | None = None
    """File for the rows."""


def main(args: Sequence[str]) -> int:
    """Run an experiment by name; status 1 where a row with a promise fails."""
    if not args or args[0].startswith("-"):
        if args and args[0] in ("-h", "--help"):
            parse(Reproduce, ["--help"], prog="twin reproduce PAPER")
        raise BadInput(f"twin reproduce needs the name of an experiment: {', '.join(REGISTRY)}")
    if args[0] not in REGISTRY:
        raise UnknownName("experiment", args[0], REGISTRY)
    options = parse(Reproduce, args[1:], prog=f"twin reproduce {args[0]}")
    check_range("trials", options.trials, 1, 10000)
    if options.json is not None and not options.json.parent.is_dir():
        raise BadInput(f"--json {options.json}: there is no directory {options.json.parent}")
    module, _, function = REGISTRY[args[0]].partition(":")
    console(stderr=True).print(f"{ABOUT[args[0]]}; {options.trials} seeds", highlight=False)
    measured = getattr(import_module(module), function)(trials=options.trials, jobs=options.jobs)
    print_rows(measured)
    if options.json is not None:
        rows_file.write(measured, options.json)
    return 0 if all(r.get("passed", True) for r in measured) else BROKEN_PROMISE
