"""`twin reproduce PAPER`: published figures and ours side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twin import rows as rows_file
from twin.commands.bench import print_rows
from twin.commands.parse import parse
from twin.commands.terminal import console
from twin.errors import BadInput, UnknownName, check_range
from twin.reproduce import ABOUT, REGISTRY, STORIES

if TYPE_CHECKING:
    from twin.reproduce.story import Story

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
    report: Path | None = None
    """File for an HTML page: what is reached and why, figures, every row."""


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
    for option, file in (("json", options.json), ("report", options.report)):
        if file is not None and not file.parent.is_dir():
            raise BadInput(f"--{option} {file}: there is no directory {file.parent}")
    module, _, function = REGISTRY[args[0]].partition(":")
    console(stderr=True).print(f"{ABOUT[args[0]]}; {options.trials} seeds", highlight=False)
    measured = getattr(import_module(module), function)(trials=options.trials, jobs=options.jobs)
    print_rows(measured)
    told = _told(args[0], measured)
    for text in told.paragraphs:
        console().print(text, highlight=False, markup=False)
    if options.json is not None:
        rows_file.write(measured, options.json)
    if options.report is not None:
        from twin.reproduce import story

        story.write(options.report, f"{args[0]}: published and ours", measured, told)
    return 0 if all(r.get("passed", True) for r in measured) else BROKEN_PROMISE


def _told(name: str, measured: list[dict[str, Any]]) -> Story:
    """What the experiment says of its rows; what it is about, if it says nothing."""
    from twin.reproduce.story import Story

    if name not in STORIES:
        return Story(paragraphs=(f"{ABOUT[name]}.",))
    module, _, function = STORIES[name].partition(":")
    told: Story = getattr(import_module(module), function)(measured)
    return told
