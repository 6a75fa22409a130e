"""`twin bench`: measure speed and memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.tables import Column, print_table
from twin.commands.terminal import waiting
from twin.io.plain import Plain

RANKS = {"published": 0, "reference": 2, "low": 3, "high": 3, "unit": 1, "passed": 0}
"""Column of a row -> its rank: the greatest is left out first, 0 never."""


@dataclass(frozen=True, kw_only=True)
class Bench(Output):
    """Measure speed and memory on this computer and compare them with the promised values."""

    machine: str | None = None
    """Measure the physics step of this machine, a name or a file, and nothing else."""


def main(args: Sequence[str]) -> int:
    """Measure, print, and write the rows where asked."""
    options = parse(Bench, args, prog="twin bench")
    check_files(json=options.json)
    from twin.bench import bench

    with waiting("measuring", shown=options.talks):
        measured = bench.rows() if options.machine is None else bench.step_rows(options.machine)
    if options.talks:
        print_rows(measured)
    deliver(measured, options.json)
    return 0


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
