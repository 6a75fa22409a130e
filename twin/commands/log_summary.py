"""What was found of a recorded drive on the terminal: tables, then what was assumed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from twin.commands.tables import Column, print_table
from twin.commands.terminal import say
from twin.io.plain import Plain
from twin.scores.log_table import (
    ACTIVITY_RANKS,
    PROTOCOL_RANKS,
    SLIP_RANKS,
    activity_rows,
    assumptions,
    fuel_sentences,
    protocol_rows,
    slip_rows,
)


def print_log(scores: Mapping[str, Plain]) -> None:
    """Print slip by estimator, time and fuel by activity, the protocol, and what was assumed."""
    _print("slip", SLIP_RANKS, slip_rows(scores), names=2)
    _print("time, slip and fuel", ACTIVITY_RANKS, activity_rows(scores), names=1)
    for line in fuel_sentences(scores):
        say(line)
    _print("recording protocol", PROTOCOL_RANKS, protocol_rows(scores), names=len(PROTOCOL_RANKS))
    for line in assumptions(scores):
        say(f"note: {line}", style="dim", indent=2)


def _print(
    title: str, ranks: Mapping[str, int], rows: Sequence[Sequence[str]], *, names: int
) -> None:
    """A table; its first `names` columns hold words. A column without anything is left out."""
    if not rows:
        return
    say(title, style="italic")
    cells = list(zip(*rows, strict=True))
    print_table(
        [
            Column(heading=heading, cells=column, rank=rank, text=i < names)
            for i, ((heading, rank), column) in enumerate(zip(ranks.items(), cells, strict=True))
            if any(cell != "-" for cell in column)
        ]
    )
