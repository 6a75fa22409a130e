"""Reads each kind of NMEA sentence: finds its fields by name, gives values in the log's units.

Layouts that `pynmeagps` does not know are named here: PANDA and PAOGI of AgOpenGPS boards, KSXT and
HPR of Unicore and ComNav receivers, after their makers' manuals.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from twin.logs.readers.nmea_fields import Fields, date_of, number_of, time_of_day_ms
from twin.logs.units import UNITS

_KNOT, _KMH = UNITS["speed"]["kn"], UNITS["speed"]["km/h"]
_GOOD = {4: 0.6, 5: 0.5, 2: 0.4, 3: 0.4, 1: 0.3, 7: 0.2, 8: 0.1, 6: 0.1}
"""How good a GGA quality is, for two sentences of one time."""
_GNS_QUALITY = {"R": 4, "F": 5, "D": 2, "P": 3, "A": 1, "E": 6, "M": 7, "S": 8}
_BOARD = (
    "time", "lat", "NS", "lon", "EW", "quality", "numSV", "HDOP", "alt", "diffAge", "spd",
    "heading",
)  # fmt: skip
OWN_LAYOUTS: dict[str, tuple[str, ...]] = {
    "HPR": ("time", "heading", "pitch", "roll", "quality"),
    "PANDA": _BOARD,
    "PAOGI": _BOARD,
    "KSXT": (
        "stamp", "lon", "lat", "alt", "heading", "pitch", "track", "spd", "roll", "quality",
        "headQuality", "numSVaux", "numSV",
    ),
}  # fmt: skip
NO_HEADING = 65535.0
"""What a PANDA board without an IMU writes for the heading."""


@dataclass(frozen=True, kw_only=True)
class SentenceValues:
    """Values read from the fields of one NMEA sentence."""

    values: Mapping[str, float] = field(default_factory=dict)
    rank: float = 1.0
    digits: int = 0
    date: datetime.date | None = None
    day_ms: int | None = None
    void: bool = False


def layout(kind: str) -> tuple[str, ...]:
    """Names of the fields of a kind, in their order."""
    from pynmeagps import NMEA_PAYLOADS_GET, NMEA_PAYLOADS_GET_PROP

    if kind in ("PASHR", "PTNLAVR"):
        return tuple(NMEA_PAYLOADS_GET_PROP[kind[1:]])
    return OWN_LAYOUTS.get(kind) or tuple(NMEA_PAYLOADS_GET[kind])


def _gga(f: Fields) -> SentenceValues:
    f.need(9)
    quality = f.number("quality")
    values = {"quality": quality, "satellites": f.number("numSV")}
    rank = 3.0 + _GOOD.get(int(quality) if quality == quality else 0, 0.0)
    if not quality > 0:
        return SentenceValues(values=values, rank=rank)
    place, digits = f.place()
    return SentenceValues(
        values={**values, **place, "height_m": f.number("alt")}, rank=rank, digits=digits
    )


def _gns(f: Fields) -> SentenceValues:
    f.need(9)
    modes = [_GNS_QUALITY[m] for m in f["posMode"] if m in _GNS_QUALITY]
    quality = max(modes, key=lambda q: _GOOD[q], default=0)
    values = {"quality": float(quality), "satellites": f.number("numSV")}
    rank = 2.5 + _GOOD.get(quality, 0.0)
    if not quality:
        return SentenceValues(values=values, rank=rank)
    place, digits = f.place()
    return SentenceValues(
        values={**values, **place, "height_m": f.number("alt")}, rank=rank, digits=digits
    )


def _rmc(f: Fields) -> SentenceValues:
    f.need(9)
    if f["status"] != "A" or f["posMode"] == "N":
        return SentenceValues(void=True)
    place, digits = f.place()
    values = {**place, "speed_mps": f.number("spd") * _KNOT, "course_deg": f.number("cog")}
    return SentenceValues(values=values, date=date_of(f["date"]), digits=digits)


def _vtg(f: Fields) -> SentenceValues:
    """VTG by its unit letters T, M, N, K, wherever they stand; km/h, which are finer, first.

    Where all letters are blank, or in the four fields of NMEA 0183 before 2.0, the order counts.
    """
    f.need(4)
    if f.payload[8:] and f.payload[8].strip() == "N":
        return SentenceValues(void=True)
    if len(f.payload) < 8 or not any(letter.strip() for letter in f.payload[1:8:2]):
        numbers = f.payload[:4] if len(f.payload) < 8 else f.payload[0:8:2]
        course, _, knots, kmh = (number_of(number.strip()) for number in numbers)
        return _velocity(course, knots, kmh)
    by_letter = {
        letter.strip(): number_of(value.strip())
        for value, letter in zip(f.payload[0:8:2], f.payload[1:8:2], strict=True)
    }
    if not {"N", "K"} & set(by_letter) or "T" not in by_letter:
        raise ValueError(f"unit letters {', '.join(f.payload[1:8:2])}")
    return _velocity(by_letter["T"], by_letter.get("N", math.nan), by_letter.get("K", math.nan))


def _velocity(course_deg: float, knots: float, kmh: float) -> SentenceValues:
    speed_mps = knots * _KNOT if math.isnan(kmh) else kmh * _KMH
    return SentenceValues(values={"course_deg": course_deg, "speed_mps": speed_mps}, rank=2.0)


def _gll(f: Fields) -> SentenceValues:
    f.need(5)
    if f["status"] == "V" or f["posMode"] == "N":
        return SentenceValues(void=True)
    place, digits = f.place()
    return SentenceValues(values=place, digits=digits)


def _zda(f: Fields) -> SentenceValues:
    year, month, day = (f.number(name) for name in ("year", "month", "day"))
    if not 2000 <= year < 2080:
        return SentenceValues()
    return SentenceValues(date=datetime.date(int(year), int(month), int(day)))


def _tra(f: Fields) -> SentenceValues:
    """TRA and HPR of Unicore and others: heading of two antennas."""
    solved = f.number("quality") > 0
    return SentenceValues(values={"heading_deg": f.number("heading")} if solved else {}, rank=1.5)


def _avr(f: Fields) -> SentenceValues:
    """PTNL,AVR of Trimble: yaw of two antennas."""
    solved = f.number("gpsQual") > 0
    return SentenceValues(values={"heading_deg": f.number("yaw")} if solved else {}, rank=1.5)


def _hdt(f: Fields) -> SentenceValues:
    return SentenceValues(values={"heading_deg": f.number("headingT")})


def _ths(f: Fields) -> SentenceValues:
    return (
        SentenceValues()
        if f["mi"] == "V"
        else SentenceValues(values={"heading_deg": f.number("headt")})
    )


def _pashr(f: Fields) -> SentenceValues:
    another = not f["utctime"][:1].isdigit()  # of Ashtech's sentences
    if another or f.number("gnssQual") == 0:
        return SentenceValues()
    return SentenceValues(values={"heading_deg": f.number("trueHdg")}, rank=1.5)


def _board(f: Fields, degrees: float) -> SentenceValues:
    f.need(12)
    if not f.number("quality") > 0:
        return SentenceValues(void=True)
    fix, heading = _gga(f), f.number("heading")
    values = {**fix.values, "speed_mps": f.number("spd") * _KNOT}
    if heading != NO_HEADING:
        values["heading_deg"] = heading * degrees
    return SentenceValues(values=values, rank=2.0, digits=fix.digits)


def _panda(f: Fields) -> SentenceValues:
    """Heading of the board's IMU in tenths of a degree."""
    return _board(f, 0.1)


def _paogi(f: Fields) -> SentenceValues:
    """Heading of two antennas in degrees."""
    return _board(f, 1.0)


def _ksxt(f: Fields) -> SentenceValues:
    f.need(13)
    stamp, quality = f["stamp"], f.number("quality")
    day_ms = time_of_day_ms(stamp[8:])
    date = datetime.date(int(stamp[:4]), int(stamp[4:6]), int(stamp[6:8]))
    if not quality > 0:
        return SentenceValues(day_ms=day_ms, date=date, void=True)
    values = {
        "latitude_deg": f.number("lat"), "longitude_deg": f.number("lon"),
        "height_m": f.number("alt"), "course_deg": f.number("track"),
        "speed_mps": f.number("spd") * _KMH, "satellites": f.number("numSV"),
        "quality": {1.0: 1.0, 2.0: 5.0, 3.0: 4.0}.get(quality, math.nan),
    }  # fmt: skip
    if f.number("headQuality") > 0:
        values["heading_deg"] = f.number("heading")
    return SentenceValues(values=values, rank=2.0, digits=9, date=date, day_ms=day_ms)


READERS: dict[str, Callable[[Fields], SentenceValues]] = {
    "GGA": _gga, "GNS": _gns, "RMC": _rmc, "VTG": _vtg, "HDT": _hdt, "THS": _ths,
    "PASHR": _pashr, "PANDA": _panda, "PAOGI": _paogi, "KSXT": _ksxt, "GLL": _gll, "ZDA": _zda,
    "TRA": _tra, "HPR": _tra, "PTNLAVR": _avr,
}  # fmt: skip
"""Kind -> values of its fields."""
