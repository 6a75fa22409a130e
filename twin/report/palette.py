"""Looks of truth and estimates, the same in every figure and recording; figures' style.

Okabe & Ito (2008), Color Universal Design: distinct in every kind of colour vision.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

TRUTH_COLOUR = "#000000"
SEA = "#009E73"
_COLOURS = ("#D55E00", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9", "#009E73")
_OWN = {
    "ratio": 0, "four-state": 1, "slip-ekf": 2, "slip-ekf-smooth": 3, "ima-pkf": 4, "pkf": 5,
    "four-state-printed": 3, "ratio-front": 4,
}  # fmt: skip
"""Estimator -> the colour that it has unless another of the same figure has it already."""
_MARKS, _LINES = "os^Dv", ("-", "--", ":", "-.")

FIGURE: Any = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#666",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
}
"""What all figures have in common, as matplotlib calls it."""


class Look(NamedTuple):
    """How an estimator is drawn."""

    colour: str
    mark: str
    line: str


def looks(names: Iterable[str]) -> dict[str, Look]:
    """Name -> its look: its own colour, else the first free one.

    Where there are more names than colours the colours come again, with other marks and lines.
    """
    wanted = list(dict.fromkeys(names))
    places: dict[str, int] = {}
    for name in wanted:
        if _OWN.get(name) not in (None, *places.values()):
            places[name] = _OWN[name]
    free = (i for i in range(len(wanted) + len(_COLOURS)) if i not in set(places.values()))
    for name in wanted:
        if name not in places:
            places[name] = next(free)
    return {name: _look(places[name]) for name in wanted}


def colours(names: Iterable[str]) -> dict[str, str]:
    """Name -> colour `#rrggbb`, in the order of the names."""
    return {name: look.colour for name, look in looks(names).items()}


def _look(place: int) -> Look:
    again, colour = divmod(place, len(_COLOURS))
    return Look(_COLOURS[colour], _MARKS[again % len(_MARKS)], _LINES[again % len(_LINES)])
