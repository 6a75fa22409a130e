"""Scheduled faults of the sensors' wires, counters and clocks, as they occur in real logs.

Faults of GNSS reception (corrections, masked or blocked sky) are in `twin.sensors.fix`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import UnknownName, check_range
from twin.sensors import camera
from twin.sensors.own import State
from twin.streams import Table

REAR = ("ticks_rl", "ticks_rr")
STAMPS = ("epoch_ns", "arrival_ns")


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One fault in a run."""

    kind: str
    """One of twin.sensors.faults.KINDS."""
    start_s: float
    """Start of the fault, from the start of the run [s]."""
    duration_s: float
    """Duration of the fault [s]."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName("sensor fault", self.kind, KINDS)
        check_range("fault.start_s", self.start_s, 0.0, 1e6)
        check_range("fault.duration_s", self.duration_s, 0.01, 1e6)


Mask = NDArray[np.bool_]
Held = dict[str, State]
"""State of a fault from chunk to chunk."""
Change = Callable[[Table, Mask, Held], Table]


def _dropped(table: Table, during: Mask, held: Held) -> Table:
    return {name: column[~during] for name, column in table.items()}


def _spike(table: Table, during: Mask, held: Held) -> Table:
    out = dict(table)
    for name in ("v_east_mps", "v_north_mps"):
        out[name] = np.where(during, table[name] + 3.0, table[name])
    return out


def _frozen(table: Table, during: Mask, held: Held, going: Sequence[str] = STAMPS) -> Table:
    """All values stay as they were in the last sample before; those `going` go on."""
    before = np.flatnonzero(~during)
    out = dict(table)
    for name, column in table.items():
        if name in going:
            continue
        newest = np.maximum.accumulate(np.where(during, -1, np.arange(len(column))))
        if len(column):
            last = held.get(name, column[0])
            out[name] = np.concatenate([[last], column])[newest + 1].astype(column.dtype)
        if len(before):
            held[name] = column[before[-1]]
    return out


def _late(table: Table, during: Mask, held: Held) -> Table:
    """Half a second late; what was sent after it does not overtake it."""
    sent = table["arrival_ns"] + np.where(during, 500_000_000, 0)
    ordered = np.maximum.accumulate(np.concatenate([[held.get("last_ns", 0)], sent]))
    held["last_ns"] = int(ordered[-1])
    return {**table, "arrival_ns": ordered[1:]}


def _missed(share: float, wheels: Sequence[str]) -> Change:
    """Counters that miss a share of their ticks, and go on from there."""

    def change(table: Table, during: Mask, held: Held) -> Table:
        out = dict(table)
        for name in wheels:
            if name not in table or not len(table[name]):
                continue
            count = table[name]
            step = np.diff(count, prepend=held.get(f"{name} count", count[0]))
            passed = held.get(f"{name} passed", 0) + np.cumsum(np.where(during, step, 0))
            held[f"{name} count"], held[f"{name} passed"] = count[-1], passed[-1]
            out[name] = count - np.floor(share * passed).astype(count.dtype)
        return out

    return change


def _saturated(table: Table, during: Mask, held: Held) -> Table:
    out = dict(table)
    for name in ("accel_x_mps2", "accel_y_mps2"):
        out[name] = np.where(during, np.clip(table[name], -0.3, 0.3), table[name])
    return out


def _biased(table: Table, during: Mask, held: Held) -> Table:
    return {**table, "accel_x_mps2": table["accel_x_mps2"] + np.where(during, 0.3, 0.0)}


def _back(table: Table, during: Mask, held: Held) -> Table:
    """The unit's clock jumps back by a fifth of a second."""
    return {**table, "epoch_ns": table["epoch_ns"] - np.where(during, 200_000_000, 0)}


def _hung(table: Table, during: Mask, held: Held) -> Table:
    """The same picture again and again, under new numbers."""
    return _frozen(table, during, held, (*STAMPS, "frame", camera.HALVED))


def _covered(table: Table, during: Mask, held: Held) -> Table:
    shown = table[camera.SHOWN]
    return {**table, camera.SHOWN: np.where(during, camera.DARK, shown)}


def _halved(table: Table, during: Mask, held: Held) -> Table:
    return {**table, camera.HALVED: during.astype(np.int8)}


KINDS: dict[str, tuple[str, str, Change]] = {
    "gnss-dropout": ("gnss", "no message from the receiver", _dropped),
    "gnss-spike": ("gnss", "3 m/s too much to the east and to the north", _spike),
    "gnss-frozen": ("gnss", "the receiver repeats its last values", _frozen),
    "gnss-late": ("gnss", "messages half a second later than before", _late),
    "wheels-stuck": ("wheels", "both rear counters stand", _missed(1.0, REAR)),
    "wheel-stuck": ("wheels", "the left rear counter stands", _missed(1.0, REAR[:1])),
    "wheel-missed": (
        "wheels",
        "the left rear counter misses every tenth tick",
        _missed(0.1, REAR[:1]),
    ),
    "imu-saturated": ("imu", "accelerations cut off at 0.3 m/s2", _saturated),
    "imu-bias": ("imu", "0.3 m/s2 on the forward acceleration", _biased),
    "imu-back": ("imu", "the clock jumps back by 0.2 s", _back),
    "camera-black": ("camera", "the lens is covered", _covered),
    "camera-frozen": ("camera", "the camera repeats its last frame", _hung),
    "camera-dropout": ("camera", "no frame arrives", _dropped),
    "camera-half": ("camera", "frames of half the resolution", _halved),
}
"""Kind of fault -> its stream, its description, and the function that changes the samples."""


def fail(
    faults: Sequence[Fault], stream: str, table: Table, start_ns: int, held: Mapping[int, Held]
) -> tuple[Table, dict[int, Held]]:
    """Apply the faults to a stream's samples; return the samples and the states of the faults.

    Args:
        faults: all faults of the run, in the order in which they are applied.
        stream: name of the stream; faults of other streams are skipped.
        table: the stream's samples in a chunk.
        start_ns: instant from which `start_s` of the faults counts.
        held: states of the faults after the last chunk, by their index in `faults`.
    """
    after = {i: dict(memory) for i, memory in held.items()}
    for i, fault in enumerate(faults):
        of, _, change = KINDS[fault.kind]
        if of != stream:
            continue
        time_s = (table["epoch_ns"] - start_ns) * 1e-9
        during = (time_s >= fault.start_s) & (time_s < fault.start_s + fault.duration_s)
        table = change(table, during, after.setdefault(i, {}))
    return table, after
