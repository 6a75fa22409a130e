"""NMEA 0183 sentences in a file: framing and checksums by `pynmeagps`, and UNIHEADING's own."""

from __future__ import annotations

import datetime
import math
import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from twin.logs.readers.nmea_fields import Fields, number_of, time_of_day_ms
from twin.logs.readers.nmea_kinds import OWN_LAYOUTS, READERS, layout

_CANDIDATE = re.compile(
    rb"\$[A-Z][A-Z0-9]{3,9},[^$\r\n]*?\*[0-9A-Fa-f]{2}|#UNIHEADINGA,[^#\r\n]*?\*[0-9A-Fa-f]{8}"
)
_UNTIMED = frozenset({"TRA", "HPR"})
"""Sentences whose time is that of a fix which may have come before: they belong to their burst."""


@dataclass(frozen=True, kw_only=True)
class Sentence:
    """Values of one sentence."""

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
    """Whether a checksum, or its absence, showed it."""


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
    kind = name if name in OWN_LAYOUTS else kind
    kind = "PASHR" if name == "PASHR" else kind
    kind = "PTNLAVR" if name == "PTNL" and payload[:1] == ["AVR"] else kind
    if kind not in READERS:
        return Sentence(line=line, kind=kind)
    fields = dict(zip(layout(kind), payload, strict=False))
    try:
        told = READERS[kind](Fields(fields, payload))
        time_ms = time_of_day_ms(fields["time"]) if fields.get("time") else None
        time_ms = None if kind in _UNTIMED else time_ms
    except (ValueError, IndexError, OverflowError, KeyError) as error:
        return Unusable(line, f"{kind} cannot be read ({error}): {text[:60]!r}", False)
    return Sentence(
        line=line, kind=kind, date=told.date,
        day_ms=time_ms if told.day_ms is None else told.day_ms,
        values={k: v for k, v in told.values.items() if not math.isnan(v)},
        rank=told.rank + 0.05 * (talker == "GN"), digits=told.digits, void=told.void,
    )  # fmt: skip


def _uniheading(line: int, text: str) -> Sentence | Unusable:
    """`#UNIHEADINGA,...;SOL_COMPUTED,type,length,heading,pitch,...*crc`, CRC-32 of Unicore."""
    body, _, given = text[1:].partition("*")
    if unicore_crc(body.encode("ascii", "replace")) != int(given, 16):
        return Unusable(line, "with a wrong checksum", True)
    fields = body.partition(";")[2].split(",")
    try:
        solved = fields[0] == "SOL_COMPUTED" and fields[1] != "NONE"
        values = {"heading_deg": number_of(fields[3])} if solved else {}
    except (ValueError, IndexError) as error:
        return Unusable(line, f"UNIHEADING cannot be read ({error}): {text[:60]!r}", False)
    return Sentence(line=line, kind="UNIHEADING", values=values, rank=1.5)


def unicore_crc(body: bytes) -> int:
    """CRC-32 with the polynomial 0xEDB88320, begun at 0 and not inverted at its end."""
    return zlib.crc32(body, 0xFFFFFFFF) ^ 0xFFFFFFFF
