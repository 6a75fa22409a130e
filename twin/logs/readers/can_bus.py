"""The bus of a tractor as signals: by name as the standards have them, and by a DBC."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.reader import Reader
from twin.logs.readers import bus_parameters as bus
from twin.logs.readers.can_frames import Frames, is_asc, is_candump, read_frames
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.plugins.extras import needed

_SUFFIXES = (".candump", ".asc", ".blf", ".trc")


class Can(Reader):
    """A trace of a CAN bus, which names its own quantities as far as standards do."""

    name = "CAN"

    def fits(self, path: Path, head: bytes) -> bool:
        """By its suffix or its first lines."""
        if path.is_dir():
            return False
        known = head.startswith(b"LOGG") or is_asc(head) or is_candump(head)
        return known or path.suffix.lower() in _SUFFIXES

    def found(self, path: Path, reading: Reading) -> Found:
        """The signals of its frames. Raises BadInput if it has none that is known."""
        with path.open("rb") as file:
            frames = read_frames(path, file.read(4096))
        decoded = [*_standard(frames), *_by_dbc(frames, reading.dbc)]
        if not decoded:
            groups = np.unique(bus.group_of(frames.identifier[frames.extended]))
            raise BadInput(
                f"{len(frames.epoch_ns)} frames of {len(groups)} groups, and none that is known by"
                ' name; dbc = "FILE" in [log] says what is in them'
            )
        named, repeated = _named(decoded), 0
        signals = {}
        for name, each in named.items():
            kept = np.append(np.diff(each.epoch_ns) != 0, True)  # of one stamp, the last counts
            repeated += int((~kept).sum())
            signals[name] = Signal(each.values[kept], each.epoch_ns[kept])
        notes = [f"{repeated} values of a stamp that is repeated left out"] if repeated else []
        return Found(
            signals=signals, own_map=_own_map(named), losses=frames.losses, notes=tuple(notes)
        )


@dataclass(frozen=True)
class _Decoded:
    """One signal from one sender on one channel."""

    group: int
    name: str
    sender: str
    epoch_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    unit: str = ""
    key: str = ""


def _standard(frames: Frames) -> Iterator[_Decoded]:
    """What the standards name, by sender."""
    group = np.where(frames.extended, bus.group_of(frames.identifier), -1)
    sender = frames.identifier & 0xFF
    for pgn in np.unique(group):
        if int(pgn) not in bus.GROUPS:
            continue
        for channel in np.unique(frames.channel[group == pgn]):
            for address in np.unique(sender[(group == pgn) & (frames.channel == channel)]):
                rows = (group == pgn) & (sender == address) & (frames.channel == channel)
                who = f"{address:02X}" if len(np.unique(frames.channel)) == 1 else (
                    f"{address:02X}/{channel}"
                )  # fmt: skip
                yield from _of_group(int(pgn), who, frames.epoch_ns[rows], frames.data[rows])


def _of_group(
    pgn: int, who: str, epoch_ns: NDArray[np.int64], data: NDArray[np.uint8]
) -> Iterator[_Decoded]:
    if pgn in bus.FAST_PACKET:
        epoch_ns, data = joined(epoch_ns, data)
    label = bus.GROUPS[pgn]
    for p in bus.PARAMETERS:
        if p.pgn == pgn and len(data):
            values = p.of(data)
            if pgn in bus.BACKWARD and p.name == "speed":
                backward = data[:, bus.BACKWARD[pgn] - 1] & 0b11 == 0
                values = np.where(backward, -values, values)
            if pgn in bus.RIGHT_IS_POSITIVE:
                values = -values
            yield _Decoded(pgn, f"{label}.{p.name}", who, epoch_ns, values, p.unit, p.key)
    if pgn == 65215:
        axle = bus.AXLE.of(data)
        yield _Decoded(pgn, f"{label}.front_axle", who, epoch_ns, axle, "km/h")
        for wheel, (_, byte) in bus.EBC2_WHEELS.items():
            raw = data[:, byte - 1 : byte]
            own = bus.Parameter(pgn, "", 1, 1, bus.RELATIVE.scale, bus.RELATIVE.offset, "").of(raw)
            yield _Decoded(
                pgn, f"{label}.wheel_{wheel}", who, epoch_ns, axle + own, "km/h",
                f"wheels.speed_{wheel}",
            )  # fmt: skip
    if pgn == 129029 and len(data):
        method = (bus.unsigned(data, 32, 1) >> np.uint64(4)).astype(np.float64)
        quality = np.where(method <= 8, method, np.nan)
        yield _Decoded(pgn, f"{label}.quality", who, epoch_ns, quality, "1", "gnss.quality")


def joined(
    epoch_ns: NDArray[np.int64], data: NDArray[np.uint8]
) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Messages of several frames (NMEA 2000 fast packet): sequence and counter, then 6 or 7 bytes.

    A message that lacks a frame is left out. Its time is that of its first frame.
    """
    times, messages = [], []
    begun: dict[int, tuple[int, int, bytearray, int]] = {}
    for time, row in zip(epoch_ns.tolist(), data, strict=True):
        sequence, counter = int(row[0]) >> 5, int(row[0]) & 0x1F
        if counter == 0:
            begun[sequence] = (time, int(row[1]), bytearray(row[2:8].tobytes()), 0)
        elif sequence in begun and begun[sequence][3] == counter - 1:
            start, length, body, _ = begun[sequence]
            begun[sequence] = (start, length, body + row[1:8].tobytes(), counter)
        if sequence in begun and len(begun[sequence][2]) >= begun[sequence][1]:
            start, length, body, _ = begun.pop(sequence)
            times.append(start)
            messages.append(np.frombuffer(bytes(body[:length]).ljust(64, b"\xff"), np.uint8))
    if not messages:
        return np.empty(0, np.int64), np.empty((0, 64), np.uint8)
    order = np.argsort(times, kind="stable")
    return np.array(times, np.int64)[order], np.stack(messages)[order]


def _by_dbc(frames: Frames, files: tuple[Path, ...]) -> Iterator[_Decoded]:
    """What DBC files say of the frames; a message of a 29-bit identifier by its group alone."""
    if not files:
        return
    cantools = needed("cantools", "can", "DBC files", "cantools")
    for file in files:
        try:
            database = cantools.database.load_file(file, strict=False)
        except OSError as error:
            raise BadInput(f"{file}: {error.strerror or error}") from None
        except Exception as error:  # cantools' own errors have no common base
            raise BadInput(f"{file} is no DBC that can be read: {error}") from None
        for message in database.messages:
            yield from _of_message(frames, message)


def _of_message(frames: Frames, message: Plain) -> Iterator[_Decoded]:
    if message.is_extended_frame:
        wanted = bus.group_of(np.array([message.frame_id]))[0]
        rows = frames.extended & (bus.group_of(frames.identifier) == wanted)
    else:
        rows = ~frames.extended & (frames.identifier == message.frame_id)
    for identifier in np.unique(frames.identifier[rows]):
        own = np.flatnonzero(rows & (frames.identifier == identifier))
        told_of: dict[str, list[float]] = {s.name: [] for s in message.signals}
        for row in own:
            body = frames.data[row, : frames.length[row]].tobytes()
            try:
                told = message.decode(body, decode_choices=False, allow_truncated=True)
            except Exception:  # a frame that is not as the DBC says
                told = {}
            for name, values in told_of.items():
                values.append(float(told.get(name, np.nan)))
        for signal in message.signals:
            column = np.array(told_of[signal.name])
            if message.is_extended_frame and signal.length in (8, 16, 32):
                raw = (column - float(signal.offset)) / float(signal.scale)
                column = np.where(raw >= 0xFB * 2.0 ** (signal.length - 8), np.nan, column)
            yield _Decoded(
                0, f"{message.name}.{signal.name}", f"{identifier & 0xFF:02X}",
                frames.epoch_ns[own], column, signal.unit or "",
            )  # fmt: skip


def _named(decoded: list[_Decoded]) -> dict[str, _Decoded]:
    """Signals by name; where several send one, that with most values has it, others a suffix."""
    named: dict[str, _Decoded] = {}
    by_name: dict[str, list[_Decoded]] = {}
    for each in decoded:
        by_name.setdefault(each.name, []).append(each)
    for name, same in by_name.items():
        same = sorted(same, key=lambda d: -int(np.isfinite(d.values).sum()))
        named[name] = same[0]
        named |= {f"{name}@{d.sender}": d for d in same[1:]}
    return named


def _own_map(named: Mapping[str, _Decoded]) -> dict[str, dict[str, object]]:
    """What the standards' signals are; of several for one quantity that of the lowest rank."""
    chosen: dict[str, tuple[int, str]] = {}
    for name, each in named.items():
        if not each.key or not np.isfinite(each.values).any() or "@" in name:
            continue
        rank = bus.RANK.get(each.group, 0)
        if each.key not in chosen or rank < chosen[each.key][0]:
            chosen[each.key] = rank, name
    _one_source(chosen)
    own: dict[str, dict[str, object]] = {}
    for key in (*_ORDER, *sorted(set(chosen) - set(_ORDER))):
        if key in chosen:
            section, _, quantity = key.partition(".")
            name = chosen[key][1]
            own.setdefault(section, {})[quantity] = {"column": name, "unit": named[name].unit}
    return own


_ORDER = ("gnss.speed", "gnss.course", "gnss.latitude", "gnss.longitude", "machine.engine_speed")
"""What comes first, because the rest of its section is brought to its times."""


def _one_source(chosen: dict[str, tuple[int, str]]) -> None:
    """Wheel by wheel, where there is one of each driven wheel, or the one speed; not both."""
    by_wheel = {f"wheels.speed_{w}" for w in ("rl", "rr")} <= set(chosen)
    single = "wheels.driven_speed" in chosen
    if by_wheel and single:
        del chosen["wheels.driven_speed"]
    elif single:
        for wheel in ("fl", "fr", "rl", "rr"):
            chosen.pop(f"wheels.speed_{wheel}", None)
    if {"gnss.latitude", "gnss.longitude"} - set(chosen):
        for key in ("gnss.latitude", "gnss.longitude"):
            chosen.pop(key, None)
    if "gnss.speed" not in chosen:
        chosen.pop("gnss.course", None)
