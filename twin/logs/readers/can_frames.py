"""CAN traces as arrays of frames, by python-can: candump, Vector ASC and BLF, PEAK TRC."""

from __future__ import annotations

import io
import re
from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.losses import Loss
from twin.plugins.extras import needed

LOG_LINE = re.compile(
    rb"^\((\d+\.\d+)\) +(\S+) +([0-9A-Fa-f]{3,8}#R?[0-9A-Fa-f]*|[0-9A-Fa-f]{3,8}##[0-9A-Fa-f]+)"
    rb"(?: [TR])?$"
)
"""A line of candump -l."""
SHOWN_LINE = re.compile(
    rb"^\((\d+\.\d+)\) +(\S+) +([0-9A-Fa-f]{3,8}) +\[(\d+)\] +((?:[0-9A-Fa-f]{2} ?)*)"
)
"""A line of candump -ta."""
SMALL_DISORDER_NS = 1_000_000_000


@dataclass(frozen=True)
class Frames:
    """Frames of a bus in order of time; a frame is as long as its data, the rest is 0xFF."""

    epoch_ns: NDArray[np.int64]
    identifier: NDArray[np.int64]
    extended: NDArray[np.bool_]
    channel: NDArray[np.str_]
    data: NDArray[np.uint8]
    """Shape (n, 8)."""
    length: NDArray[np.int64]
    losses: tuple[Loss, ...] = ()


def read_frames(path: Path, head: bytes) -> Frames:
    """All data frames. Raises BadInput."""
    can = needed("can", "can", "CAN traces", "python-can")
    if head.startswith(b"LOGG"):
        with path.open("rb") as binary:
            return _frames(_all(lambda: can.BLFReader(binary)), ())
    if path.suffix.lower() in (".trc", ".asc") or is_asc(head):
        peak = path.suffix.lower() == ".trc"
        with path.open(encoding="latin-1") as text:
            opened = (lambda: can.TRCReader(text)) if peak else (
                lambda: can.ASCReader(text, relative_timestamp=False)
            )  # fmt: skip
            return _frames(_all(opened), ())
    lines, losses = _candump(path.read_bytes())
    return _frames(_all(lambda: can.CanutilsLogReader(lines)), losses)


def is_asc(head: bytes) -> bool:
    """Whether a file begins as Vector's ASC does."""
    return head.lstrip()[:5].lower() == b"date " and b"base " in head[:400].lower()


def is_candump(head: bytes) -> bool:
    """Whether most of the first lines are candump's."""
    lines = [line.strip(b"\r\0 ") for line in head.split(b"\n")[:-1][:20] if line.strip()]
    known = sum(bool(LOG_LINE.match(line) or SHOWN_LINE.match(line)) for line in lines)
    return known > 0.5 * len(lines)


def _candump(content: bytes) -> tuple[io.StringIO, tuple[Loss, ...]]:
    """Lines as candump -l writes them; what is none is left out and counted."""
    good, bad = [], []
    lines = content.split(b"\n")
    for number, line in enumerate(lines, 1):
        clean = line.strip(b"\r\0 \t")
        if LOG_LINE.match(clean):
            good.append(clean)
        elif shown := SHOWN_LINE.match(clean):
            data = shown[5].replace(b" ", b"")
            good.append(b"(%b) %b %b#%b" % (shown[1], shown[2], shown[3], data))
        elif clean:
            bad.append(number)
    if not good:
        raise BadInput("no frame as candump writes it")
    text = io.StringIO("\n".join(line.decode("ascii", "replace") for line in good) + "\n")
    if not bad:
        return text, ()
    says = f"line {bad[0]} is no frame as candump writes it"
    return text, (Loss("frames", np.array(bad, np.int64), len(good) + len(bad), says),)


class _Kept:
    """Frames so far, as packed numbers: a bus sends millions of them."""

    def __init__(self) -> None:
        self.epoch_ns, self.identifier = array("q"), array("q")
        self.extended, self.length = array("b"), array("b")
        self.data = bytearray()
        self.channel: list[int] = []
        self.channels: dict[str, int] = {}
        self.broken = ""
        """Why reading stopped before the end, if it did."""

    def take(self, message: Plain) -> None:
        """Add a data frame."""
        body = bytes(message.data[:8])
        self.epoch_ns.append(round(message.timestamp * 1e9))
        self.identifier.append(message.arbitration_id)
        self.extended.append(message.is_extended_id)
        self.length.append(len(body))
        self.data += body.ljust(8, b"\xff")
        self.channel.append(self.channels.setdefault(str(message.channel), len(self.channels)))


def _all(opened: Callable[[], Iterable[Plain]]) -> _Kept:
    """Every data frame that can be read. Raises BadInput where none can."""
    frames = _Kept()
    try:
        for message in opened():
            if not (message.is_error_frame or message.is_remote_frame):
                frames.take(message)
    except OSError:
        raise
    except Exception as error:  # what python-can raises is not documented
        frames.broken = f"{type(error).__name__}: {error}"
        if not frames.epoch_ns:
            raise BadInput(f"not a CAN trace that can be read ({frames.broken})") from None
    if not frames.epoch_ns:
        raise BadInput("a CAN trace without a data frame")
    return frames


def _frames(kept: _Kept, losses: tuple[Loss, ...]) -> Frames:
    epoch_ns = np.array(kept.epoch_ns, np.int64)
    order = np.arange(len(epoch_ns))
    back = np.diff(epoch_ns)
    if (back < 0).any() and back.min() > -SMALL_DISORDER_NS:  # two channels, written in turn
        order = np.argsort(epoch_ns, kind="stable")
    names = np.array(list(kept.channels), np.str_)
    if kept.broken:
        count = len(epoch_ns) + 1
        says = f"frame {count} cannot be read, and what comes after it ({kept.broken})"
        losses = (*losses, Loss("frames", np.array([count], np.int64), count, says))
    return Frames(
        epoch_ns=epoch_ns[order],
        identifier=np.array(kept.identifier, np.int64)[order],
        extended=np.array(kept.extended, bool)[order],
        channel=names[np.array(kept.channel, np.int64)][order],
        data=np.frombuffer(bytes(kept.data), np.uint8).reshape(-1, 8)[order],
        length=np.array(kept.length, np.int64)[order],
        losses=losses,
    )
