"""`twin bench`: measure speed and memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import waiting
from twin.errors import BadInput
from twin.io.plain import Plain
from twin.io.result_rows import Rows

RANKS = {"published": 0, "reference": 2, "low": 3, "high": 3, "unit": 1, "passed": 0}
"""Column of a row -> its rank: the greatest is left out first, 0 never."""


@dataclass(frozen=True, kw_only=True)
class Bench(Output):
    """Measure speed and memory on this computer and compare them with the promised values."""

    machine: str | None = None
    """Measure the physics step of this machine, a name or a file, and nothing else."""
    against: Path | None = None
    """Another checkout's folder: compare CPU times of commands in fresh processes, in turn."""
    cases: str = ""
    """With --against: which cases, separated by commas; all of them when empty."""
    rounds: int = 3
    """With --against: measurements of each case in each checkout."""


def main(args: Sequence[str]) -> int:
    """Measure, print, and write the rows where asked."""
    options = parse(Bench, args, prog="twin bench")
    check_files(json=options.json)
    if options.rounds < 1:
        raise BadInput(f"rounds = {options.rounds} is too few; 1 or more")
    with waiting("measuring", shown=options.talks):
        measured = _measured(options)
    if options.talks:
        print_rows(measured)
    deliver(measured, options.json)
    return 0


def _measured(options: Bench) -> Rows:
    if options.against is None:
        if options.cases:
            raise BadInput("--cases would not be read: it needs --against")
        from twin.bench import bench

        return bench.rows() if options.machine is None else bench.step_rows(options.machine)
    if options.machine is not None:
        raise BadInput("--machine would not be read: it needs no --against")
    from twin.bench import against

    cases = [case for case in options.cases.split(",") if case]
    return against.rows(options.against, cases, options.rounds)


def print_rows(measured: Sequence[Mapping[str, Plain]]) -> None:
    """Print rows as a table: case, quantity, value, promised value."""
    columns = [
        Column(heading=name, cells=[str(row[name]) for row in measured], text=True)
        for name in ("case", "quantity")
    ]
    for name, rank in {"ours": 0, **RANKS}.items():
        if any(name in row for row in measured):
            cells = [_text(row.get(name)) for row in measured]
            columns.append(Column(heading=name, cells=cells, rank=rank, text=name == "unit"))
    print_table(columns)


def _text(value: Plain) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "NO"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
