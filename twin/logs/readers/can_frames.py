"""CAN traces as arrays of frames, by python-can: candump, Vector ASC and BLF, PEAK TRC."""

from __future__ import annotations

import io
import re
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


def _all(opened: Callable[[], Iterable[Plain]]) -> list[Plain]:
    """Every data frame that can be read. Raises BadInput where none can."""
    frames: list[Plain] = []
    try:
        frames.extend(m for m in opened() if not (m.is_error_frame or m.is_remote_frame))
    except OSError:
        raise
    except Exception as error:  # what python-can raises is not documented
        if not frames:
            why = f"{type(error).__name__}: {error}"
            raise BadInput(f"not a CAN trace that can be read ({why})") from None
    if not frames:
        raise BadInput("a CAN trace without a data frame")
    return frames


def _frames(messages: list[Plain], losses: tuple[Loss, ...]) -> Frames:
    data = np.full((len(messages), 8), 0xFF, np.uint8)
    for row, message in enumerate(messages):
        part = message.data[:8]
        data[row, : len(part)] = np.frombuffer(bytes(part), np.uint8)
    epoch_ns = np.array([round(m.timestamp * 1e9) for m in messages], np.int64)
    order = np.arange(len(messages))
    back = np.diff(epoch_ns)
    if (back < 0).any() and back.min() > -SMALL_DISORDER_NS:  # two channels, written in turn
        order = np.argsort(epoch_ns, kind="stable")
    return Frames(
        epoch_ns=epoch_ns[order],
        identifier=np.array([m.arbitration_id for m in messages], np.int64)[order],
        extended=np.array([m.is_extended_id for m in messages], bool)[order],
        channel=np.array([str(m.channel) for m in messages], np.str_)[order],
        data=data[order],
        length=np.array([min(len(m.data), 8) for m in messages], np.int64)[order],
        losses=losses,
    )
