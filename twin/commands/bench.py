"""`twin bench`: measured speed and memory, as rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from twin.commands.output import Output, check_files, deliver
from twin.commands.parse import parse
from twin.commands.terminal import console, waiting

COLUMNS = ("published", "reference", "low", "high", "unit", "passed")


@dataclass(frozen=True, kw_only=True)
class Bench(Output):
    """Measure speed and memory on this machine, beside the values promised."""


def main(args: Sequence[str]) -> int:
    """Measure, print, and write the rows where asked."""
    options = parse(Bench, args, prog="twin bench")
    check_files(json=options.json)
    from twin.bench import bench

    with waiting("measuring", shown=options.talks):
        measured = bench.rows()
    if options.talks:
        print_rows(measured)
    deliver(measured, options.json)
    return 0


def print_rows(measured: Sequence[Mapping[str, Any]]) -> None:
    """Rows as a table of case, quantity, value and what was promised."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for header, justify in (("case", "left"), ("quantity", "left"), ("ours", "right")):
        table.add_column(header, justify=justify)  # type: ignore[arg-type]
    shown = [key for key in COLUMNS if any(key in row for row in measured)]
    for header in shown:
        table.add_column(header)
    for row in measured:
        values = [_text(row.get(key)) for key in ("ours", *shown)]
        table.add_row(str(row["case"]), str(row["quantity"]), *values)
    console().print(table)


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "NO"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
