"""NMEA 0183: GGA, RMC, VTG and HDT with checksums, gathered into one GNSS epoch per UTC time.

Sentence layouts after NMEA 0183 v4. GGA and RMC carry the time; VTG and HDT belong to the time that
came last before them. A day rolls over when the time of day falls by more than half a day, or where
RMC's date says so.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import quoted
from twin.logs.units import UNITS
from twin.streams import Array

_SENTENCE = re.compile(r"\$([A-Z]{2})([A-Z]{3}),([^*$]*)\*([0-9A-Fa-f]{2})")
_KNOT = UNITS["speed"]["kn"]
_DAY_MS = 86_400_000
_NAN = math.nan

COLUMNS = (
    "latitude_rad", "longitude_rad", "height_m", "speed_mps", "course_rad", "heading_rad",
    "quality", "satellites_main",
)  # fmt: skip
"""What an epoch may hold; angles clockwise from north as in the sentences."""


@dataclass
class _Gathered:
    """Epochs so far: the time of each in milliseconds, its values, the line it began at."""

    time_ms: list[int] = field(default_factory=list)
    values: list[dict[str, float]] = field(default_factory=list)
    seen: set[str] = field(default_factory=set)
    day: int = 0
    first_date: int | None = None
    orphans: int = 0


def checksum(body: str) -> int:
    """Exclusive or of the characters between `$` and `*`."""
    total = 0
    for character in body.encode("ascii"):
        total ^= character
    return total


def read_nmea(path: Path) -> tuple[NDArray[np.int64], dict[str, Array], list[str]]:
    """Epochs [ns] from midnight of the first day, SI columns of COLUMNS (NaN: not given), notes.

    Raises:
        BadInput: no usable sentence, a field that is no number, a time out of order or repeated.
    """
    text = path.read_bytes().decode("ascii", errors="replace")
    gathered, dropped = _Gathered(), dict[str, list[int]]()
    for line, sentence in enumerate(re.split(r"\r\n|\r|\n", text), 1):
        if sentence.strip():
            reason = _take(gathered, line, sentence.strip())
            if reason:
                dropped.setdefault(reason, []).append(line)
    if not gathered.time_ms:
        raise BadInput("no GGA or RMC sentence with a correct checksum; is it an NMEA 0183 log?")
    notes = [
        f"{len(at)} lines {why} left out (first at line {at[0]})" for why, at in dropped.items()
    ]
    columns = {c: np.array([v.get(c, _NAN) for v in gathered.values]) for c in COLUMNS}
    given = {c: v for c, v in columns.items() if not np.all(np.isnan(v))}
    return np.array(gathered.time_ms, np.int64) * 1_000_000, given, notes


def _take(gathered: _Gathered, line: int, sentence: str) -> str | None:
    """Add one sentence; the reason if it cannot be used."""
    match = _SENTENCE.fullmatch(sentence)
    if match is None:
        return "that are no sentence with a checksum"
    body = sentence[1:-3]
    if not body.isascii() or checksum(body) != int(match[4], 16):
        return "with a wrong checksum"
    kind, fields = match[2], match[3].split(",")
    if kind not in _READERS:
        return None
    try:
        values = _READERS[kind](fields)
        if kind in ("GGA", "RMC"):
            if not fields[0]:
                return "without a time (no fix yet)"
            _open_epoch(gathered, kind, fields)
        elif not gathered.time_ms:
            return "before the first time"
    except (ValueError, IndexError, OverflowError) as error:
        raise BadInput(
            f"line {line}: {kind} cannot be read ({error}): {quoted(sentence)}"
        ) from None
    gathered.values[-1].update({k: v for k, v in values.items() if not math.isnan(v)})
    return None


def _open_epoch(gathered: _Gathered, kind: str, fields: list[str]) -> None:
    """Begin an epoch unless the sentence belongs to the one that is open."""
    day_ms = _time_of_day_ms(fields[0])
    last_ms = gathered.time_ms[-1] if gathered.time_ms else None
    if last_ms is not None and day_ms < last_ms % _DAY_MS - _DAY_MS // 2:
        gathered.day = last_ms // _DAY_MS + 1
    if kind == "RMC" and len(fields) > 8 and fields[8]:
        _set_date(gathered, fields[8])
    time_ms = gathered.day * _DAY_MS + day_ms
    if last_ms is not None and time_ms < last_ms:
        raise ValueError(f"time {fields[0]} is out of order")
    if time_ms == last_ms:
        if kind in gathered.seen:
            raise ValueError(f"time {fields[0]} is repeated")
        gathered.seen.add(kind)
        return
    gathered.time_ms.append(time_ms)
    gathered.values.append({})
    gathered.seen = {kind}


def _set_date(gathered: _Gathered, ddmmyy: str) -> None:
    if not re.fullmatch(r"\d{6}", ddmmyy):
        raise ValueError(f"date {ddmmyy!r} is not ddmmyy")
    day, month, year = int(ddmmyy[:2]), int(ddmmyy[2:4]), 2000 + int(ddmmyy[4:])
    date = datetime.date(year, month, day).toordinal()
    if gathered.first_date is None:
        gathered.first_date = date - gathered.day
    gathered.day = date - gathered.first_date


def _time_of_day_ms(text: str) -> int:
    match = re.fullmatch(r"(\d\d)(\d\d)(\d\d)(\.\d{1,9})?", text, re.ASCII)
    if match is None:
        raise ValueError(f"time {text!r} is not hhmmss.ss")
    h, m, s = int(match[1]), int(match[2]), int(match[3])
    if h > 23 or m > 59 or s > 60:
        raise ValueError(f"time {text!r} is not a time of day")
    return ((h * 60 + m) * 60 + s) * 1000 + round(float(match[4] or 0) * 1000)


def _gga(f: list[str]) -> dict[str, float]:
    if len(f) < 9:
        raise ValueError(f"{len(f)} fields")
    quality = _number(f[5])
    fix = quality > 0
    return {
        "latitude_rad": _angle_rad(f[1], f[2], "NS", 2) if fix else _NAN,
        "longitude_rad": _angle_rad(f[3], f[4], "EW", 3) if fix else _NAN,
        "height_m": _number(f[8]) if fix else _NAN,
        "quality": quality,
        "satellites_main": _number(f[6]),
    }


def _rmc(f: list[str]) -> dict[str, float]:
    if len(f) < 9:
        raise ValueError(f"{len(f)} fields")
    if f[1] != "A":
        return {}
    return {
        "latitude_rad": _angle_rad(f[2], f[3], "NS", 2),
        "longitude_rad": _angle_rad(f[4], f[5], "EW", 3),
        "speed_mps": _number(f[6]) * _KNOT,
        "course_rad": math.radians(_number(f[7])),
    }


def _vtg(f: list[str]) -> dict[str, float]:
    """VTG with its unit letters (T, M, N, K); speed in km/h where given, else in knots."""
    if len(f) < 8:
        raise ValueError(f"{len(f)} fields")
    kmh, knots = _number(f[6]), _number(f[4])
    speed_mps = knots * _KNOT if math.isnan(kmh) else kmh * UNITS["speed"]["km/h"]
    return {"course_rad": math.radians(_number(f[0])), "speed_mps": speed_mps}


def _hdt(f: list[str]) -> dict[str, float]:
    return {"heading_rad": math.radians(_number(f[0]))}


_READERS: dict[str, Callable[[list[str]], dict[str, float]]] = {
    "GGA": _gga, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt,
}  # fmt: skip


def _number(text: str) -> float:
    """A field as a number; NaN when empty."""
    if not text:
        return _NAN
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)", text, re.ASCII) or len(text) > 20:
        raise ValueError(f"{text!r} is not a number")
    return float(text)


def _angle_rad(text: str, hemisphere: str, letters: str, digits: int) -> float:
    """An angle written (d)ddmm.mmmm with its hemisphere letter."""
    if not text and not hemisphere:
        return _NAN
    if not re.fullmatch(rf"\d{{{digits + 2}}}(\.\d*)?", text, re.ASCII) or len(text) > 24:
        raise ValueError(f"{text!r} is not an angle of {digits} digits of degrees and minutes")
    if len(hemisphere) != 1 or hemisphere not in letters:
        raise ValueError(f"hemisphere {hemisphere!r} is not one of {letters[0]}, {letters[1]}")
    degrees, minutes = int(text[:digits]), float(text[digits:])
    if minutes >= 60.0 or degrees + minutes / 60.0 > (90.0 if digits == 2 else 180.0):
        raise ValueError(f"{text!r} is not an angle")
    sign = 1.0 if hemisphere == letters[0] else -1.0
    return sign * math.radians(degrees + minutes / 60.0)
