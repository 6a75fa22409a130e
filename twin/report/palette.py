"""Colours of truth and estimates, the same in the report and in the recording; figures' style.

Okabe & Ito (2008), Color Universal Design: told apart with every kind of colour vision.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

TRUTH_COLOUR = "#000000"
SEA = "#009E73"
_ESTIMATORS = ("#D55E00", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9", "#009E73")

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
PICTURE: Any = FIGURE | {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "savefig.dpi": 130,
}
"""And those that are written as files of pixels."""


def colours(names: Iterable[str]) -> dict[str, str]:
    """Name -> colour `#rrggbb`, in order of appearance."""
    return {name: _ESTIMATORS[i % len(_ESTIMATORS)] for i, name in enumerate(names)}
