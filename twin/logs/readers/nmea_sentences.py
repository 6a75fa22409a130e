"""NMEA 0183 sentences as values: framing, checksums and field names by `pynmeagps`.

Layouts it does not know are named here: PANDA and PAOGI of AgOpenGPS boards, KSXT, HPR and
UNIHEADING of Unicore and ComNav receivers, after their makers' manuals.
"""

from __future__ import annotations

import datetime
import math
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from twin.logs.units import UNITS

_CANDIDATE = re.compile(
    rb"\$[A-Z][A-Z0-9]{3,9},[^$\r\n]*?\*[0-9A-Fa-f]{2}|#UNIHEADINGA,[^#\r\n]*?\*[0-9A-Fa-f]{8}"
)
_KNOT, _KMH = UNITS["speed"]["kn"], UNITS["speed"]["km/h"]
_NAN = math.nan
_GOOD = {4: 0.6, 5: 0.5, 2: 0.4, 3: 0.4, 1: 0.3, 7: 0.2, 8: 0.1, 6: 0.1}
"""How good a GGA quality is, for two sentences of one time."""
_GNS_QUALITY = {"R": 4, "F": 5, "D": 2, "P": 3, "A": 1, "E": 6, "M": 7, "S": 8}
_BOARD = (
    "time", "lat", "NS", "lon", "EW", "quality", "numSV", "HDOP", "alt", "diffAge", "spd",
    "heading",
)  # fmt: skip
_OWN_LAYOUTS: dict[str, tuple[str, ...]] = {
    "HPR": ("time", "heading", "pitch", "roll", "quality"),
    "PANDA": _BOARD,
    "PAOGI": _BOARD,
    "KSXT": (
        "stamp", "lon", "lat", "alt", "heading", "pitch", "track", "spd", "roll", "quality",
        "headQuality", "numSVaux", "numSV",
    ),
}  # fmt: skip
_UNTIMED = frozenset({"TRA", "HPR"})
"""Sentences whose time is that of a fix which may have come before: they belong to their burst."""
NO_HEADING = 65535.0
"""What a PANDA board without an IMU writes for the heading."""


@dataclass(frozen=True, kw_only=True)
class Sentence:
    """What one sentence tells."""

    line: int
    kind: str
    day_ms: int | None = None
    """Time of day of a sentence that has one."""
    date: datetime.date | None = None
    values: Mapping[str, float] = field(default_factory=dict)
    rank: float = 1.0
    """Of two sentences of one time, the higher counts."""
    digits: int = 0
    """Decimals of the minutes of a position."""
    void: bool = False
    """The receiver says that it has no fix."""


@dataclass(frozen=True)
class Unusable:
    """A line that holds no sentence that can be used."""

    line: int
    why: str
    checked: bool
    """Whether a checksum, or its absence, told so."""


def sentences(content: bytes) -> Iterator[Sentence | Unusable]:
    """Every sentence of a file, whatever stands around them: prefixes, tag blocks, binary."""
    for line, text in enumerate(content.split(b"\n"), 1):
        found = _CANDIDATE.findall(text)
        if not found:
            clean = text.strip(b"\r\0 \t\xef\xbb\xbf")
            if clean and clean.isascii() and not clean.startswith((b"#", b"!")):
                yield Unusable(line, "that are no sentence with a checksum", True)
        for each in found:
            yield _sentence(line, each.decode("ascii", "replace"))


def _sentence(line: int, text: str) -> Sentence | Unusable:
    if text.startswith("#"):
        return _uniheading(line, text)
    from pynmeagps import calc_checksum, get_parts  # lazily: 0.1 s that other logs do not need

    content, talker, kind, payload, given = get_parts(text)
    if "\ufffd" in text or calc_checksum(content).upper() != given.upper():
        return Unusable(line, "with a wrong checksum", True)
    name = talker + kind
    kind = name if name in _OWN_LAYOUTS else kind
    kind = "PASHR" if name == "PASHR" else kind
    kind = "PTNLAVR" if name == "PTNL" and payload[:1] == ["AVR"] else kind
    if kind not in _READERS:
        return Sentence(line=line, kind=kind)
    fields = dict(zip(_layout(kind), payload, strict=False))
    try:
        told = _READERS[kind](_Fields(fields, payload))
        time_ms = _time_of_day_ms(fields["time"]) if fields.get("time") else None
        time_ms = None if kind in _UNTIMED else time_ms
    except (ValueError, IndexError, OverflowError, KeyError) as error:
        return Unusable(line, f"{kind} cannot be read ({error}): {text[:60]!r}", False)
    return Sentence(
        line=line, kind=kind, date=told.date,
        day_ms=time_ms if told.day_ms is None else told.day_ms,
        values={k: v for k, v in told.values.items() if not math.isnan(v)},
        rank=told.rank + 0.05 * (talker == "GN"), digits=told.digits, void=told.void,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class _Told:
    """What the fields of a sentence say."""

    values: Mapping[str, float] = field(default_factory=dict)
    rank: float = 1.0
    digits: int = 0
    date: datetime.date | None = None
    day_ms: int | None = None
    void: bool = False


def _layout(kind: str) -> tuple[str, ...]:
    from pynmeagps import NMEA_PAYLOADS_GET, NMEA_PAYLOADS_GET_PROP

    if kind in ("PASHR", "PTNLAVR"):
        return tuple(NMEA_PAYLOADS_GET_PROP[kind[1:]])
    return _OWN_LAYOUTS.get(kind) or tuple(NMEA_PAYLOADS_GET[kind])


class _Fields:
    """The fields of a sentence by name."""

    def __init__(self, named: Mapping[str, str], payload: list[str]) -> None:
        self._named, self.payload = named, payload

    def __getitem__(self, name: str) -> str:
        return self._named.get(name, "").strip()

    def number(self, name: str) -> float:
        """A field as a number; NaN when empty."""
        return _number(self[name])

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


def _gga(f: _Fields) -> _Told:
    f.need(9)
    quality = f.number("quality")
    values = {"quality": quality, "satellites": f.number("numSV")}
    rank = 3.0 + _GOOD.get(int(quality) if quality == quality else 0, 0.0)
    if not quality > 0:
        return _Told(values=values, rank=rank)
    place, digits = f.place()
    return _Told(values={**values, **place, "height_m": f.number("alt")}, rank=rank, digits=digits)


def _gns(f: _Fields) -> _Told:
    f.need(9)
    modes = [_GNS_QUALITY[m] for m in f["posMode"] if m in _GNS_QUALITY]
    quality = max(modes, key=lambda q: _GOOD[q], default=0)
    values = {"quality": float(quality), "satellites": f.number("numSV")}
    rank = 2.5 + _GOOD.get(quality, 0.0)
    if not quality:
        return _Told(values=values, rank=rank)
    place, digits = f.place()
    return _Told(values={**values, **place, "height_m": f.number("alt")}, rank=rank, digits=digits)


def _rmc(f: _Fields) -> _Told:
    f.need(9)
    if f["status"] != "A" or f["posMode"] == "N":
        return _Told(void=True)
    place, digits = f.place()
    values = {**place, "speed_mps": f.number("spd") * _KNOT, "course_deg": f.number("cog")}
    return _Told(values=values, date=_date(f["date"]), digits=digits)


def _vtg(f: _Fields) -> _Told:
    """VTG by its unit letters T, M, N, K, wherever they stand; km/h, which are finer, first.

    Where all letters are blank, or in the four fields of NMEA 0183 before 2.0, the order counts.
    """
    f.need(4)
    if f.payload[8:] and f.payload[8].strip() == "N":
        return _Told(void=True)
    if len(f.payload) < 8 or not any(letter.strip() for letter in f.payload[1:8:2]):
        numbers = f.payload[:4] if len(f.payload) < 8 else f.payload[0:8:2]
        course, _, knots, kmh = (_number(number.strip()) for number in numbers)
        return _velocity(course, knots, kmh)
    by_letter = {
        letter.strip(): _number(value.strip())
        for value, letter in zip(f.payload[0:8:2], f.payload[1:8:2], strict=True)
    }
    if not {"N", "K"} & set(by_letter) or "T" not in by_letter:
        raise ValueError(f"unit letters {', '.join(f.payload[1:8:2])}")
    return _velocity(by_letter["T"], by_letter.get("N", _NAN), by_letter.get("K", _NAN))


def _velocity(course_deg: float, knots: float, kmh: float) -> _Told:
    speed_mps = knots * _KNOT if math.isnan(kmh) else kmh * _KMH
    return _Told(values={"course_deg": course_deg, "speed_mps": speed_mps}, rank=2.0)


def _gll(f: _Fields) -> _Told:
    f.need(5)
    if f["status"] == "V" or f["posMode"] == "N":
        return _Told(void=True)
    place, digits = f.place()
    return _Told(values=place, digits=digits)


def _zda(f: _Fields) -> _Told:
    year, month, day = (f.number(name) for name in ("year", "month", "day"))
    if not 2000 <= year < 2080:
        return _Told()
    return _Told(date=datetime.date(int(year), int(month), int(day)))


def _tra(f: _Fields) -> _Told:
    """TRA and HPR of Unicore and others: heading of two antennas."""
    solved = f.number("quality") > 0
    return _Told(values={"heading_deg": f.number("heading")} if solved else {}, rank=1.5)


def _avr(f: _Fields) -> _Told:
    """PTNL,AVR of Trimble: yaw of two antennas."""
    solved = f.number("gpsQual") > 0
    return _Told(values={"heading_deg": f.number("yaw")} if solved else {}, rank=1.5)


def _hdt(f: _Fields) -> _Told:
    return _Told(values={"heading_deg": f.number("headingT")})


def _ths(f: _Fields) -> _Told:
    return _Told() if f["mi"] == "V" else _Told(values={"heading_deg": f.number("headt")})


def _pashr(f: _Fields) -> _Told:
    another = not f["utctime"][:1].isdigit()  # of Ashtech's sentences
    if another or f.number("gnssQual") == 0:
        return _Told()
    return _Told(values={"heading_deg": f.number("trueHdg")}, rank=1.5)


def _board(f: _Fields, degrees: float) -> _Told:
    f.need(12)
    if not f.number("quality") > 0:
        return _Told(void=True)
    fix, heading = _gga(f), f.number("heading")
    values = {**fix.values, "speed_mps": f.number("spd") * _KNOT}
    if heading != NO_HEADING:
        values["heading_deg"] = heading * degrees
    return _Told(values=values, rank=2.0, digits=fix.digits)


def _panda(f: _Fields) -> _Told:
    """Heading of the board's IMU in tenths of a degree."""
    return _board(f, 0.1)


def _paogi(f: _Fields) -> _Told:
    """Heading of two antennas in degrees."""
    return _board(f, 1.0)


def _ksxt(f: _Fields) -> _Told:
    f.need(13)
    stamp, quality = f["stamp"], f.number("quality")
    day_ms = _time_of_day_ms(stamp[8:])
    date = datetime.date(int(stamp[:4]), int(stamp[4:6]), int(stamp[6:8]))
    if not quality > 0:
        return _Told(day_ms=day_ms, date=date, void=True)
    values = {
        "latitude_deg": f.number("lat"), "longitude_deg": f.number("lon"),
        "height_m": f.number("alt"), "course_deg": f.number("track"),
        "speed_mps": f.number("spd") * _KMH, "satellites": f.number("numSV"),
        "quality": {1.0: 1.0, 2.0: 5.0, 3.0: 4.0}.get(quality, _NAN),
    }  # fmt: skip
    if f.number("headQuality") > 0:
        values["heading_deg"] = f.number("heading")
    return _Told(values=values, rank=2.0, digits=9, date=date, day_ms=day_ms)


_READERS: dict[str, Callable[[_Fields], _Told]] = {
    "GGA": _gga, "GNS": _gns, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt, "THS": _ths,
    "PASHR": _pashr, "PANDA": _panda, "PAOGI": _paogi, "KSXT": _ksxt, "GLL": _gll, "ZDA": _zda,
    "TRA": _tra, "HPR": _tra, "PTNLAVR": _avr,
}  # fmt: skip


def _uniheading(line: int, text: str) -> Sentence | Unusable:
    """`#UNIHEADINGA,...;SOL_COMPUTED,type,length,heading,pitch,...*crc`, CRC-32 of Unicore."""
    body, _, given = text[1:].partition("*")
    if unicore_crc(body.encode("ascii", "replace")) != int(given, 16):
        return Unusable(line, "with a wrong checksum", True)
    fields = body.partition(";")[2].split(",")
    try:
        solved = fields[0] == "SOL_COMPUTED" and fields[1] != "NONE"
        values = {"heading_deg": _number(fields[3])} if solved else {}
    except (ValueError, IndexError) as error:
        return Unusable(line, f"UNIHEADING cannot be read ({error}): {text[:60]!r}", False)
    return Sentence(line=line, kind="UNIHEADING", values=values, rank=1.5)


def unicore_crc(body: bytes) -> int:
    """CRC-32 with the polynomial 0xEDB88320, begun at 0 and not inverted at its end."""
    return zlib.crc32(body, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _time_of_day_ms(text: str) -> int:
    match = re.fullmatch(r"(\d\d)(\d\d)(\d\d)(\.\d{0,9})?", text.strip(), re.ASCII)
    if match is None:
        raise ValueError(f"time {text!r} is not hhmmss.ss")
    h, m, s = int(match[1]), int(match[2]), int(match[3])
    if h > 23 or m > 59 or s > 60:
        raise ValueError(f"time {text!r} is not a time of day")
    fraction = match[4] if match[4] and len(match[4]) > 1 else "0"
    return ((h * 60 + m) * 60 + s) * 1000 + round(float(fraction) * 1000)


def _date(ddmmyy: str) -> datetime.date | None:
    """A date; None for what a receiver writes before it knows the day (its years 80 to 99)."""
    if not ddmmyy:
        return None
    if not re.fullmatch(r"\d{6}", ddmmyy, re.ASCII):
        raise ValueError(f"date {ddmmyy!r} is not ddmmyy")
    year = int(ddmmyy[4:])
    return None if year >= 80 else datetime.date(2000 + year, int(ddmmyy[2:4]), int(ddmmyy[:2]))


def _number(text: str) -> float:
    """A field as a number; NaN when empty."""
    if not text:
        return _NAN
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)", text, re.ASCII) or len(text) > 24:
        raise ValueError(f"{text!r} is not a number")
    return float(text)


def _degrees(text: str, hemisphere: str, letters: str, digits: int) -> float:
    """An angle written (d)ddmm.mmmm with its hemisphere letter, in degrees."""
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
    return sign * (degrees + minutes / 60.0)
