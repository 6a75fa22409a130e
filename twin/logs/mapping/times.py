"""Which column of a table holds the times, and in which unit."""

from __future__ import annotations

import numpy as np

from twin.errors import BadInput
from twin.logs.cells import Text, numbers
from twin.logs.mapping.guessed import Guess
from twin.logs.mapping.names import is_time, unit_of
from twin.logs.signals import Found, Signal
from twin.logs.stamps import TIMESTAMP, stamps
from twin.logs.units import UNITS

_SINCE_1970_S = (1e9, 4e9)
"""What seconds since 1970 are between 2001 and 2096."""
_DAYS = (20_000.0, 80_000.0)
"""What the days of a spreadsheet are between 1954 and 2119."""


def time_of(found: Found) -> Guess | None:
    """The column of times of a table."""
    table = {n: s for n, s in found.signals.items() if s.epoch_ns is None}
    named = [n for n in table if is_time(n)]
    for name in [*named, *(n for n in table if n not in named)]:
        unit = _time_unit(name, table[name])
        if unit:
            sure = name in named
            return Guess(
                signal=name, section="log", key="time", unit=unit, sure=sure,
                why="by its name" if sure else "it rises from row to row",
            )  # fmt: skip
        if name in named:
            continue
    return None


def _time_unit(name: str, signal: Signal) -> str:
    """The unit of a column of times; nothing where it is none."""
    values = signal.values
    if not isinstance(values, Text | list) and values.dtype.kind == "M":
        return TIMESTAMP
    cells = signal.cells
    number, wrong = numbers(name, cells)
    known = number[np.isfinite(number)]
    if len(known) < 2 or wrong.mean() > 0.5:
        return TIMESTAMP if isinstance(cells, Text) and _are_stamps(name, cells) else ""
    step = np.diff(known)
    if np.mean(step > 0) < 0.9:
        return ""
    for unit, per_s in (("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        if _SINCE_1970_S[0] < known[0] / per_s < _SINCE_1970_S[1]:
            return unit
    told = unit_of(name, tuple(UNITS["time"]))
    if told:
        return told
    usual = float(np.median(step))
    if _DAYS[0] < known[0] < _DAYS[1] and usual < 0.1:
        return "days"
    whole = bool(np.all(known == np.round(known)))
    return "ms" if whole and usual >= 5.0 else "s"


def _are_stamps(name: str, cells: Text) -> bool:
    try:
        made = stamps(name, cells, TIMESTAMP)
    except BadInput:
        return False
    return bool(made.kept.mean() > 0.5)
