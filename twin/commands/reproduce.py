"""`twin reproduce PAPER`: compare published results with the twin's."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from twin.commands.bench import print_rows
from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.terminal import counting, say
from twin.errors import BadInput, UnknownName, check_range
from twin.io.plain import Plain
from twin.reproduce import ABOUT, REGISTRY, STORIES

if TYPE_CHECKING:
    from twin.reproduce.story import Story

BROKEN_PROMISE = 1


@dataclass(frozen=True, kw_only=True)
class Reproduce(Output):
    """Repeat an experiment of a paper and compare the published results with the twin's."""

    trials: int = 16
    """Number of seeds of each case."""
    jobs: int = 1
    """Number of processes; -1 for one per core."""
    report: Path | None = None
    """File for an HTML page: agreement with the paper, figures, every row."""


def main(args: Sequence[str]) -> int:
    """Run an experiment by name. The status is 1 if a row with a tolerance fails."""
    if not args or args[0].startswith("-"):
        if args and args[0] in ("-h", "--help"):
            parse(Reproduce, ["--help"], prog="twin reproduce PAPER")
        raise BadInput(f"twin reproduce needs the name of an experiment: {', '.join(REGISTRY)}")
    if args[0] not in REGISTRY:
        raise UnknownName("experiment", args[0], REGISTRY)
    options = parse(Reproduce, args[1:], prog=f"twin reproduce {args[0]}")
    check_range("trials", options.trials, 1, 10000)
    check_files(json=options.json, report=options.report)
    from twin.compute.parallel import reporting

    module, _, function = REGISTRY[args[0]].partition(":")
    if options.talks:
        say(f"{ABOUT[args[0]]}; {options.trials} seeds", stderr=True)
    with counting(args[0], "runs", shown=options.talks) as report:
        experiment = getattr(import_module(module), function)
        with reporting(report):
            measured = experiment(trials=options.trials, jobs=options.jobs)
    said = _said(args[0], measured)
    if options.talks:
        print_rows(measured)
        for text in said.paragraphs:
            say(text)
    deliver(measured, options.json)
    if options.report is not None:
        from twin.reproduce import story

        command = f"twin reproduce {shlex.join(args)}"
        title = f"{args[0]}: published results and the twin's"
        story.write(options.report, title, measured, said, command)
    return 0 if all(r.get("passed", True) for r in measured) else BROKEN_PROMISE


def _said(name: str, measured: list[dict[str, Plain]]) -> Story:
    """The text of the experiment about its rows; its description where it has none."""
    from twin.reproduce.story import Story

    if name not in STORIES:
        return Story(paragraphs=(f"{ABOUT[name]}.",))
    module, _, function = STORIES[name].partition(":")
    said: Story = getattr(import_module(module), function)(measured)
    return said
