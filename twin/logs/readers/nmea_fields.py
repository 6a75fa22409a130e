"""The fields of an NMEA sentence as values: numbers, angles, times of day and dates.

Each raises ValueError for text that is none.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Mapping


class Fields:
    """The fields of a sentence by name."""

    def __init__(self, named: Mapping[str, str], payload: list[str]) -> None:
        self._named, self.payload = named, payload

    def __getitem__(self, name: str) -> str:
        return self._named.get(name, "").strip()

    def number(self, name: str) -> float:
        """A field as a number; NaN when empty."""
        return number_of(self[name])

    def need(self, count: int) -> None:
        """Raise ValueError unless there are as many fields."""
        if len(self.payload) < count:
            raise ValueError(f"{len(self.payload)} fields")

    def place(self) -> tuple[dict[str, float], int]:
        """Latitude and longitude [deg], and the decimals of their minutes."""
        latitude = _degrees(self["lat"], self["NS"], "NS", 2)
        longitude = _degrees(self["lon"], self["EW"], "EW", 3)
        digits = len(self["lat"].partition(".")[2])
        return {"latitude_deg": latitude, "longitude_deg": longitude}, digits


def time_of_day_ms(text: str) -> int:
    """Milliseconds since midnight of a field written hhmmss.ss. Raises ValueError."""
    match = re.fullmatch(r"(\d\d)(\d\d)(\d\d)(\.\d{0,9})?", text.strip(), re.ASCII)
    if match is None:
        raise ValueError(f"time {text!r} is not hhmmss.ss")
    h, m, s = int(match[1]), int(match[2]), int(match[3])
    if h > 23 or m > 59 or s > 60:
        raise ValueError(f"time {text!r} is not a time of day")
    fraction = match[4] if match[4] and len(match[4]) > 1 else "0"
    return ((h * 60 + m) * 60 + s) * 1000 + round(float(fraction) * 1000)


def date_of(ddmmyy: str) -> datetime.date | None:
    """A date; None for what a receiver writes before it knows the day (its years 80 to 99).

    Raises:
        ValueError: not ddmmyy, or no day of the calendar.
    """
    if not ddmmyy:
        return None
    if not re.fullmatch(r"\d{6}", ddmmyy, re.ASCII):
        raise ValueError(f"date {ddmmyy!r} is not ddmmyy")
    year = int(ddmmyy[4:])
    return None if year >= 80 else datetime.date(2000 + year, int(ddmmyy[2:4]), int(ddmmyy[:2]))


def number_of(text: str) -> float:
    """A field as a number; NaN when empty. Raises ValueError."""
    if not text:
        return math.nan
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)", text, re.ASCII) or len(text) > 24:
        raise ValueError(f"{text!r} is not a number")
    return float(text)


def _degrees(text: str, hemisphere: str, letters: str, digits: int) -> float:
    """An angle written (d)ddmm.mmmm with its hemisphere letter, in degrees."""
    if not text and not hemisphere:
        return math.nan
    if not re.fullmatch(rf"\d{{{digits + 2}}}(\.\d*)?", text, re.ASCII) or len(text) > 24:
        raise ValueError(f"{text!r} is not an angle of {digits} digits of degrees and minutes")
    if len(hemisphere) != 1 or hemisphere not in letters:
        raise ValueError(f"hemisphere {hemisphere!r} is not one of {letters[0]}, {letters[1]}")
    degrees, minutes = int(text[:digits]), float(text[digits:])
    if minutes >= 60.0 or degrees + minutes / 60.0 > (90.0 if digits == 2 else 180.0):
        raise ValueError(f"{text!r} is not an angle")
    sign = 1.0 if hemisphere == letters[0] else -1.0
    return sign * (degrees + minutes / 60.0)
