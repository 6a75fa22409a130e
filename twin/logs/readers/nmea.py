"""NMEA 0183: sentences gathered into one GNSS epoch per UTC time.

GGA, GNS, RMC, PANDA, PAOGI and KSXT carry the time; VTG and the headings belong to the sentences of
their burst. A day rolls over when the time of day falls by more than half a day, or where a date
says so; with a date, times count from 1970, without one from the first midnight.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.losses import Loss
from twin.logs.reader import Reader
from twin.logs.readers.nmea_sentences import Sentence, Unusable, sentences
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.streams import Array

_DAY_MS = 86_400_000
_UNIX_ORDINAL = datetime.date(1970, 1, 1).toordinal()
_SENTENCE = re.compile(rb"\$[A-Z][A-Z0-9]{3,9},[^$\r\n]*\*[0-9A-Fa-f]{2}")
KEYS: dict[str, tuple[str, str]] = {
    "latitude": ("latitude_deg", "deg"), "longitude": ("longitude_deg", "deg"),
    "height": ("height_m", "m"), "speed": ("speed_mps", "m/s"), "course": ("course_deg", "deg"),
    "heading": ("heading_deg", "deg"), "quality": ("quality", "1"),
    "satellites": ("satellites", "1"),
}  # fmt: skip
"""Key of [gnss] -> signal and its unit. Angles clockwise from north as in the sentences."""
EARTH_M = 6.37e6
CLEARLY = 0.5
"""Share of the other's misfit at which one order of the sentences of a burst is clearly right."""
FEWEST = 8
_PLACE = ("latitude_deg", "longitude_deg", "height_m")


class Nmea(Reader):
    """NMEA 0183, which names its own quantities."""

    name = "NMEA"

    def fits(self, path: Path, head: bytes) -> bool:
        """By a sentence in its head, or its suffix."""
        named = path.suffix.lower() in (".nmea", ".nme")
        return not path.is_dir() and (named or bool(_SENTENCE.search(head)))

    def found(self, path: Path, reading: Reading) -> Found:
        """Its epochs. Raises BadInput if no sentence can be used."""
        told = list(sentences(path.read_bytes()))
        usable = [s for s in told if isinstance(s, Sentence)]
        losses = _losses([s for s in told if isinstance(s, Unusable)], len(told))
        notes = []
        void = sum(s.void for s in usable)
        if void:
            notes.append(f"{void} sentences in which the receiver says it has no fix left out")
        epochs = _gathered(usable)
        if not epochs.time_ms:
            why = losses[0].says if losses else notes[0] if notes else "is it an NMEA 0183 log?"
            raise BadInput(f"no GGA or RMC sentence with a correct checksum and a fix; {why}")
        if epochs.orphans:
            notes.append(f"{epochs.orphans} lines before the first time left out")
        columns = epochs.columns()
        gnss = {
            key: {"column": column, "unit": unit}
            for key, (column, unit) in KEYS.items()
            if column in columns
        }
        epoch_ns = epochs.epoch_ns()
        return Found(
            signals={name: Signal(values, epoch_ns) for name, values in columns.items()},
            own_map={"gnss": gnss}, losses=tuple(losses), notes=tuple(notes),
        )  # fmt: skip


def _losses(unusable: Sequence[Unusable], of: int) -> list[Loss]:
    """Lines by what is wrong with them."""
    losses = []
    for why in dict.fromkeys(u.why for u in unusable if u.checked):
        rows = np.array([u.line for u in unusable if u.why == why], np.int64)
        says = f"lines {why} (first at line {rows[0]})"
        losses.append(Loss("sentences", rows, of, says, checked=True))
    broken = [u for u in unusable if not u.checked]
    if broken:
        rows = np.array([u.line for u in broken], np.int64)
        losses.append(Loss("sentences", rows, of, f"line {rows[0]}: {broken[0].why}"))
    return losses


def _gathered(usable: Sequence[Sentence]) -> _Epochs:
    """The epochs, with sentences that have no time before or after those of their burst.

    Where one of the two makes speeds that fit the positions much better, it counts. Else a log that
    begins with a sentence without a time and ends with one that has it is whole only if they lead.
    """
    both = {leading: _Epochs(leading=leading) for leading in (False, True)}
    for epochs in both.values():
        for sentence in usable:
            epochs.take(sentence)
    misfit = {leading: epochs.misfit_mps() for leading, epochs in both.items()}
    for leading in (False, True):
        if misfit[leading] < CLEARLY * misfit[not leading]:
            return both[leading]
    told = [s for s in usable if s.values or s.void]
    ends = bool(told) and told[0].day_ms is None and told[-1].day_ms is not None
    return both[ends]


class _Epochs:
    """Epochs so far: the time of each in milliseconds, and its values with their ranks."""

    def __init__(self, *, leading: bool) -> None:
        self.time_ms: list[int] = []
        self.orphans = 0
        self._leading = leading
        self._values: list[dict[str, tuple[float, float]]] = []
        self._digits: list[int] = []
        self._waiting: list[Sentence] = []
        self._day = 0
        self._first_date: int | None = None
        self._open = False

    def take(self, sentence: Sentence) -> None:
        """Add one sentence to the epoch it belongs to."""
        if sentence.day_ms is None:
            self._untimed(sentence)
            return
        if sentence.void:
            self._open, self._waiting = False, []
            return
        self._begin(sentence.day_ms, sentence.date)
        self._add(sentence)
        for waiting in self._waiting:
            self._add(waiting)
        self._waiting = []

    def _untimed(self, sentence: Sentence) -> None:
        if self._leading:
            self._waiting.append(sentence)
        elif not self.time_ms:
            self.orphans += bool(sentence.values)
        elif self._open:
            self._add(sentence)

    def _begin(self, day_ms: int, date: datetime.date | None) -> None:
        last_ms = self.time_ms[-1] if self.time_ms else None
        if last_ms is not None and day_ms < last_ms % _DAY_MS - _DAY_MS // 2:
            self._day = last_ms // _DAY_MS + 1
        if date is not None:
            if self._first_date is None:
                self._first_date = date.toordinal() - self._day
            if date.toordinal() >= self._first_date:
                self._day = date.toordinal() - self._first_date
        self._open = True
        time_ms = self._day * _DAY_MS + day_ms
        if time_ms != last_ms:
            self.time_ms.append(time_ms)
            self._values.append({})
            self._digits.append(0)

    def _add(self, sentence: Sentence) -> None:
        values = self._values[-1]
        for key, value in sentence.values.items():
            if sentence.rank >= values.get(key, (0.0, 0.0))[0]:
                values[key] = sentence.rank, value
                if key == "latitude_deg":
                    self._digits[-1] = sentence.digits

    def misfit_mps(self) -> float:
        """How far, at the median, speeds are off those of the positions; NaN without both."""
        columns = self.columns()
        if not {"latitude_deg", "longitude_deg", "speed_mps"} <= set(columns):
            return np.nan
        lat, lon = np.radians(columns["latitude_deg"]), np.radians(columns["longitude_deg"])
        time_s = self.epoch_ns() * 1e-9
        north, east = EARTH_M * np.diff(lat), EARTH_M * np.cos(lat[1:]) * np.diff(lon)
        step_s = np.where(np.diff(time_s) > 0.0, np.diff(time_s), np.nan)
        between = np.hypot(east, north) / step_s
        by_place = 0.5 * (between[1:] + between[:-1])
        off = np.abs(columns["speed_mps"][1:-1] - by_place)
        off = off[np.isfinite(off)]
        return float(np.median(off)) if len(off) >= FEWEST else np.nan

    def epoch_ns(self) -> NDArray[np.int64]:
        """Times of the epochs [ns]."""
        start_ms = 0
        if self._first_date is not None:
            start_ms = (self._first_date - _UNIX_ORDINAL) * _DAY_MS
        return (np.array(self.time_ms, np.int64) + start_ms) * 1_000_000

    def columns(self) -> dict[str, Array]:
        """What the epochs hold, NaN where one has it not; a column that is all NaN is none.

        A position of RMC alone, with fewer decimals than the log's GGA have, would jump.
        """
        coarse = self._coarse()
        columns = {}
        for name, _ in KEYS.values():
            values = np.array([v.get(name, (0.0, np.nan))[1] for v in self._values])
            if name in _PLACE:
                values[coarse] = np.nan
            if np.isfinite(values).any():
                columns[name] = values
        return columns

    def _coarse(self) -> NDArray[np.bool_]:
        ranks = np.array([v.get("latitude_deg", (0.0, 0.0))[0] for v in self._values])
        digits = np.array(self._digits)
        best = digits[ranks >= 2.0].max(initial=0)
        return np.asarray((ranks < 1.5) & (ranks > 0.0) & (digits < best))
