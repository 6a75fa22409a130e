"""Events in words: plough in and out, fix lost and regained, rocks, unused frames, the end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import rerun as rr

from twin.plugins.lookup import Thing
from twin.streams import Streams, Table
from twin.viz.paths import EVENTS
from twin.viz.tools import Array, times

if TYPE_CHECKING:
    from twin.trajectory.end import End

FIXES = {4: "fixed", 5: "float", 2: "differential", 1: "single", 0: "none"}
FIXED = 4
STANDING_MPS, STANDING_S = 0.1, 10.0
"""A recorded drive stands where its ground speed stays below this for so long."""
ROCK_SHARE, ROCK_WINDOW = 0.5, 25
"""A rock is seen where draft exceeds its median over a second by half of a rock's peak."""


class Event(NamedTuple):
    """A line of the log."""

    epoch_ns: int
    text: str
    level: str = "INFO"


def log_events(recording: rr.RecordingStream, found: Iterable[Event]) -> None:
    """All events of a run or a drive, in order."""
    found = sorted(found)
    if not found:
        return
    stamps = times({"epoch_ns": np.array([e.epoch_ns for e in found], np.int64)})
    text, level = [e.text for e in found], [e.level for e in found]
    recording.send_columns(EVENTS, stamps, rr.TextLog.columns(text=text, level=level))


def events(
    truth: Table, streams: Streams, scenario: Thing, end: End | None = None
) -> Iterator[Event]:
    """What happened in a run: the truth's events, then those that a sensor reports."""
    epoch_ns = truth.get("epoch_ns", np.empty(0, np.int64))
    start_ns = int(epoch_ns[0]) if len(epoch_ns) else 0
    depth_m = truth.get("depth_m", np.zeros(len(epoch_ns)))
    for row, inside in _changes(depth_m > 0.0):
        yield Event(int(epoch_ns[row]), "plough in the ground" if inside else "plough out")
    for row, deep in _changes(truth.get("ploughing", np.zeros(len(epoch_ns), bool))):
        if deep:
            yield Event(int(epoch_ns[row]), f"full depth, {100.0 * depth_m[row]:.0f} cm")
    soil = getattr(scenario, "soil", None)
    if getattr(soil, "rocks_per_100m2", 0.0) > 0.0:
        yield from _rocks(truth, soil.rock_kn)  # type: ignore[union-attr]
    if "gnss" in streams:
        gnss = streams["gnss"]
        kept = gnss["epoch_ns"] >= start_ns
        yield from _fixes({k: v[kept] for k, v in gnss.items()})
    if "camera" in streams and "used" in streams["camera"]:
        camera = streams["camera"]
        kept = camera["epoch_ns"] >= start_ns
        kept &= np.cumsum(kept) > 1  # the first frame has none before it to be compared with
        for row, used in _changes(camera["used"][kept] > 0, before=True):
            text = "odometry finds its way again" if used else "odometry loses its way"
            level = "INFO" if used else "WARN"
            yield Event(int(camera["epoch_ns"][kept][row]), text, level)
    if end is not None and len(epoch_ns):
        yield Event(int(epoch_ns[-1]), str(end), "INFO" if end.as_planned else "ERROR")


def drive_events(streams: Streams, notes: Sequence[str] = ()) -> Iterator[Event]:
    """What happened in a recorded drive: what was found in reading it, fixes, where it stood."""
    starts = [int(t["epoch_ns"][0]) for t in streams.tables.values() if len(t["epoch_ns"])]
    yield from (Event(min(starts, default=0), note) for note in notes)
    gnss: Table = streams.tables.get("gnss", {})
    yield from _fixes(gnss)
    if {"v_east_mps", "v_north_mps"} <= gnss.keys():
        yield from _stops(gnss["epoch_ns"], np.hypot(gnss["v_east_mps"], gnss["v_north_mps"]))


def _stops(epoch_ns: Array, speed_mps: Array) -> Iterator[Event]:
    """Stops: where each begins, and where the machine goes on."""
    edges = [row for row, _ in _changes(np.append(speed_mps < STANDING_MPS, False))]
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        last = min(after, len(epoch_ns) - 1)
        stood_s = float(epoch_ns[last] - epoch_ns[first]) * 1e-9
        if stood_s >= STANDING_S:
            yield Event(int(epoch_ns[first]), f"stands for {stood_s:.0f} s")
            if after < len(epoch_ns):
                yield Event(int(epoch_ns[after]), "drives")


def _fixes(gnss: Table) -> Iterator[Event]:
    quality = gnss.get("quality", np.empty(0))
    if not len(quality):
        return
    known = np.where(np.isfinite(quality), quality, 0).astype(int)
    for row in np.flatnonzero(np.diff(known)) + 1:
        name = FIXES.get(known[row], f"quality {known[row]}")
        text = "GNSS fixed again" if known[row] == FIXED else f"GNSS {name}"
        yield Event(int(gnss["epoch_ns"][row]), text, "INFO" if known[row] == FIXED else "WARN")


def _rocks(truth: Table, rock_kn: float) -> Iterator[Event]:
    from scipy.ndimage import median_filter

    draft_n = truth["draft_n"]
    over_n = draft_n - median_filter(draft_n, 2 * ROCK_WINDOW + 1)
    deep = truth.get("ploughing", np.ones(len(draft_n), bool))
    for row, hit in _changes((over_n > ROCK_SHARE * 1e3 * rock_kn) & deep):
        if hit:
            peak_kn = 1e-3 * float(np.max(draft_n[row : row + ROCK_WINDOW]))
            yield Event(int(truth["epoch_ns"][row]), f"rock: draft {peak_kn:.0f} kN", "WARN")


def _changes(flag: Array, *, before: bool = False) -> Iterator[tuple[int, bool]]:
    """Rows where a flag changes, and to what; in the first row, where it was otherwise `before`."""
    flag = np.asarray(flag, bool)
    for row in np.flatnonzero(np.diff(flag, prepend=before)):
        yield int(row), bool(flag[row])
