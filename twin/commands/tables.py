"""Tables as wide as the terminal: columns are left out, numbers and names never cut.

A column has a rank. The one of the greatest rank is left out first, and a line below the table
names what was left out; columns of rank 0 always stay. Text may break between its words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from twin.commands.terminal import console, say

GAP = 2
"""Spaces between two columns."""
COMFORTABLE = 22
"""Text breaks between words down to this width, before a column is left out."""


@dataclass(frozen=True, kw_only=True)
class Column:
    """A heading and the cells below it."""

    heading: str
    cells: Sequence[str]
    rank: int = 0
    """The greatest is left out first; 0 stays."""
    text: bool = False
    """Whether it holds words, on the left, rather than numbers, on the right."""

    @property
    def widest(self) -> int:
        """Width in which nothing breaks."""
        return max(map(_cells, (self.heading, *self.cells)))

    @property
    def narrowest(self) -> int:
        """Width in which no word and no number breaks."""
        words = [word for cell in (self.heading, *self.cells) for word in cell.split()]
        return max(map(_cells, words), default=0)

    @property
    def needed(self) -> int:
        """Least width [characters]; where those of all columns do not fit, a column is left out."""
        if self.text:
            return max(self.narrowest, min(self.widest, COMFORTABLE))
        return max(map(_cells, (*self.heading.split(), *self.cells)))


def fit(columns: Sequence[Column], width: int) -> tuple[list[Column], list[int]]:
    """The columns that a width has room for, and the width of each.

    Where even those of rank 0 are too wide, they are given what they need and the line is longer.
    """
    kept = list(columns)
    while _total([c.needed for c in kept]) > width and any(c.rank for c in kept):
        kept.remove(max(reversed(kept), key=lambda column: column.rank))
    widths = [column.needed for column in kept]
    if _total(widths) > width:
        widths = [column.narrowest for column in kept]
    whole = [column.needed if not column.text else 0 for column in kept]
    for wanted in (whole, [column.widest for column in kept]):
        widths = _widened(widths, wanted, width)
    return kept, widths


def print_table(columns: Sequence[Column]) -> None:
    """Print what fits, and say which columns do not."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    out = console()
    kept, widths = fit(columns, out.width)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, GAP - 1, 0, 0))
    for column, width in zip(kept, widths, strict=True):
        justify = "left" if column.text else "right"
        table.add_column(Text(column.heading), justify=justify, width=width, overflow="fold")  # type: ignore[arg-type]
    for cells in zip(*(column.cells for column in kept), strict=True):
        table.add_row(*map(Text, cells))
    columns_of_terminal, out.width = out.width, max(out.width, _total(widths))
    out.print(table, width=_total(widths))
    left_out = [column.heading for column in columns if column not in kept]
    if left_out:
        say(f"left out to fit {columns_of_terminal} columns: {', '.join(left_out)}", style="dim")


def _cells(text: str) -> int:
    """How many places of a terminal a text takes."""
    from rich.cells import cell_len

    return cell_len(text)


def _widened(widths: Sequence[int], wanted: Sequence[int], width: int) -> list[int]:
    """Widths as near to those wanted as a total allows; what lacks most is given first."""
    given = list(widths)
    for _ in range(width - _total(given)):
        lacking = [want - got for want, got in zip(wanted, given, strict=True)]
        if max(lacking) <= 0:
            break
        given[lacking.index(max(lacking))] += 1
    return given


def _total(widths: Sequence[int]) -> int:
    return sum(widths) + GAP * (len(widths) - 1)
