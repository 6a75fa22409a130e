"""UBX, u-blox' binary messages, by pyubx2: NAV-PVT, NAV-RELPOSNED and NAV-ATT."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.losses import Loss
from twin.logs.reader import Reader
from twin.logs.readers.nmea import KEYS
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.plugins.extras import needed

_NAV_PVT = b"\xb5\x62\x01\x07"
_UNIX = datetime.datetime(1970, 1, 1)


class Ubx(Reader):
    """A log of a u-blox receiver, which names its own quantities."""

    name = "UBX"

    def fits(self, path: Path, head: bytes) -> bool:
        """By a NAV-PVT message in its head, or its suffix."""
        return not path.is_dir() and (_NAV_PVT in head or path.suffix.lower() == ".ubx")

    def found(self, path: Path, reading: Reading) -> Found:
        """Its epochs. Raises BadInput."""
        ubx = needed("pyubx2", "ubx", "UBX logs", "pyubx2")
        epochs: dict[int, dict[str, float]] = {}
        heading: dict[float, float] = {}
        broken: list[int] = []
        count = 0
        with path.open("rb") as file:
            reader = ubx.UBXReader(
                file, protfilter=ubx.UBX_PROTOCOL, quitonerror=0, validate=ubx.VALCKSUM,
                errorhandler=lambda error: broken.append(count),
            )  # fmt: skip
            for _, message in reader:
                count += 1
                if message is not None:
                    _take(message, epochs, heading)
        if not epochs:
            raise BadInput("no NAV-PVT message with a valid time and fix")
        times = sorted(epochs)
        for values in epochs.values():
            values["heading_deg"] = heading.get(values.pop("week_ms"), np.nan)
        epoch_ns = np.array(times, np.int64)
        columns = {
            column: np.array([epochs[t].get(column, np.nan) for t in times])
            for column, _ in KEYS.values()
        }
        columns = {c: v for c, v in columns.items() if np.isfinite(v).any()}
        gnss = {k: {"column": c, "unit": u} for k, (c, u) in KEYS.items() if c in columns}
        losses: tuple[Loss, ...] = ()
        if broken:
            rows = np.array(broken, np.int64)
            losses = (Loss("messages", rows, count, "messages that are damaged", checked=True),)
        return Found(
            signals={c: Signal(v, epoch_ns) for c, v in columns.items()},
            own_map={"gnss": gnss}, losses=losses,
        )  # fmt: skip


def _take(message: Plain, epochs: dict[int, dict[str, float]], heading: dict[float, float]) -> None:
    """Add a message; headings by their time of the week, as NAV-PVT has it too."""
    if message.identity == "NAV-PVT" and message.validDate and message.validTime:
        stamp = datetime.datetime(
            message.year, message.month, message.day, message.hour, message.min,
            min(message.second, 59),
        )  # fmt: skip
        time_ns = (stamp - _UNIX) // datetime.timedelta(seconds=1) * 10**9 + int(message.nano)
        time_ns = round(time_ns / 1_000_000) * 1_000_000  # nano is off by the clock's own error
        fix = bool(message.gnssFixOk) and message.fixType in (2, 3, 4)
        quality = {0: 2.0 if message.diffSoln else 1.0, 1: 5.0, 2: 4.0}[message.carrSoln]
        epochs[time_ns] = {
            "quality": quality if fix else 0.0, "satellites": float(message.numSV),
            "week_ms": float(message.iTOW),
        }  # fmt: skip
        if fix:
            epochs[time_ns] |= {
                "latitude_deg": message.lat, "longitude_deg": message.lon,
                "height_m": message.hMSL * 1e-3, "speed_mps": message.gSpeed * 1e-3,
                "course_deg": message.headMot,
            }  # fmt: skip
    elif message.identity == "NAV-RELPOSNED" and getattr(message, "relPosHeadingValid", 0):
        heading[float(message.iTOW)] = message.relPosHeading
    elif message.identity == "NAV-ATT" and message.accHeading < 90.0:
        heading.setdefault(float(message.iTOW), message.heading)
