"""`twin compare DIR DIR`: two drives beside each other, in a table and on a page."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from twin.commands.output import check_files
from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import say
from twin.errors import BadInput
from twin.io.atomic import made

if TYPE_CHECKING:
    from twin.pipeline.compared import Compared, Row
    from twin.pipeline.compared_drives import Drive

HEADERS = ("quantity", "A", "B", "B - A")


@dataclass(frozen=True, kw_only=True)
class Compare:
    """Set two drives beside each other: two runs, or a log and a simulation of the same job."""

    first: Annotated[Path, tyro.conf.Positional]
    """Folder of a run or of a log: A."""
    second: Annotated[Path, tyro.conf.Positional]
    """Folder of another: B."""
    out: Path | None = None
    """File for the page; by default runs/<A>-and-<B>.html."""
    quiet: bool = False
    """Print errors only."""
    json: bool = False
    """Print the comparison as JSON instead of a table."""


def main(args: Sequence[str]) -> int:
    """Compare, write the page, print the table."""
    _check_folders(args)
    options = parse(Compare, args, prog="twin compare")
    check_files(out=options.out)
    from twin.pipeline.compared import compared

    found = compared(options.first, options.second)
    path = options.out or _default(found)
    _write(found, path, f"twin compare {shlex.join(args)}")
    if options.json:
        print(json.dumps(found.plain(), indent=2))
    elif not options.quiet:
        _say(found, path)
    return 0


def _check_folders(args: Sequence[str]) -> None:
    """Refuse another number of folders than two, unless help is asked for."""
    words = [a for before, a in pairwise(("", *args)) if before != "--out"]
    folders = [a for a in words if not a.startswith("-")]
    if len(folders) != 2 and not {"-h", "--help"} & set(args):
        given = f", not {len(folders)}" if folders else ""
        raise BadInput(f"twin compare needs two folders{given}: twin compare DIR DIR")


def _default(found: Compared) -> Path:
    names = [drive.folder.resolve().name for drive in (found.a, found.b)]
    return Path("runs") / f"{names[0]}-and-{names[1]}.html"


def _write(found: Compared, path: Path, command: str) -> None:
    from twin.report import compare_page

    about = found.plain()
    sides = [
        compare_page.Side(compare_page.summary(about[key]), drive.rows, drive.chosen, slip_of)
        for key, drive, slip_of in zip("ab", (found.a, found.b), found.slip_of, strict=True)
    ]
    names = [drive.folder.resolve().name for drive in (found.a, found.b)]
    with made(path.parent):
        compare_page.write(
            path, (sides[0], sides[1]), title=f"{names[0]} and {names[1]}", headers=HEADERS,
            lines=[cells(row) for row in found.rows], where=found.where, notes=found.notes,
            command=command,
        )  # fmt: skip


def cells(row: Row) -> list[str]:
    """A row as text: quantity with its unit, both values, their difference."""
    digits = _digits(row)
    numbers = [_text(row.a, f".{digits}f"), _text(row.b, f".{digits}f")]
    return [f"{row.quantity} [{row.unit}]", *numbers, _text(row.difference, f"+.{digits}f")]


def _digits(row: Row) -> int:
    """Decimals: none for thousands, two for small numbers."""
    largest = max(abs(value) for value in (row.a, row.b) if value is not None)
    return 0 if largest >= 200.0 else 1 if largest >= 50.0 else 2


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else f"{value:{form}}"


def _say(found: Compared, path: Path) -> None:
    for name, drive in (("A", found.a), ("B", found.b)):
        say(f"{name}: {_about(drive)}", indent=3)
    say(f"compared {found.where}", style="italic")
    lines = list(zip(*(cells(row) for row in found.rows), strict=True))
    print_table(
        [
            Column(heading=heading, cells=column, text=i == 0)
            for i, (heading, column) in enumerate(zip(HEADERS, lines, strict=True))
        ]
    )
    for note in found.notes:
        say(f"note: {note}", style="dim", indent=2)
    say(str(path))


def _about(drive: Drive) -> str:
    return f"{drive.folder}, {drive.kind}, {drive.record.setup.machine}"
