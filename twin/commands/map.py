"""`twin map LOG...`: a first column map, and a list of the signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import say
from twin.errors import BadInput


@dataclass(frozen=True, kw_only=True)
class Map:
    """Write a first column map of a log, guessed from names and physics."""

    log: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """The log, or the files it is in."""
    out: Path | None = None
    """File for the map; by default <name of the log>.toml."""
    dbc: tuple[Path, ...] = ()
    """Files that say what is in CAN frames."""
    quiet: bool = False
    """Print errors only."""


def main(args: Sequence[str]) -> int:
    """Read the files, guess, list the signals, write the map."""
    options = parse(Map, args, prog="twin map")
    if not options.log:
        raise BadInput("no log is named; twin map LOG [LOG...]")
    out = options.out or Path(f"{options.log[0].resolve().stem}.toml")
    if out.exists():
        raise BadInput(f"{out} exists; name another file with --out")
    if not out.parent.is_dir():
        raise BadInput(f"--out {out}: there is no directory {out.parent}")
    from twin import logs
    from twin.io.atomic import write_text
    from twin.logs.mapping import text
    from twin.logs.mapping.guess import guesses

    found = logs.found_in_all(options.log, logs.Reading(dbc=options.dbc))
    told = {name: guesses(each) for name, each in found.items()}
    write_text(out, text.map_of(told, tuple(str(d.resolve()) for d in options.dbc)))
    if not options.quiet:
        listed = list(zip(*text.rows(told), strict=True))
        if listed:
            heads = ("signal", "rate", "range", "holes", "taken for")
            words, ranks = (True, False, True, False, True), (0, 3, 2, 1, 0)
            print_table([
                Column(heading=h, cells=c, text=w, rank=r)
                for h, c, w, r in zip(heads, listed, words, ranks, strict=True)
            ])  # fmt: skip
        unsure = sum(not g.sure for t in told.values() for g in t.quantities)
        say(f"{out}: {unsure} of its lines are guesses; they say '# ?'")
        for name, each in found.items():
            for note in each.notes:
                say(f"note: {name}: {note}")
    return 0
