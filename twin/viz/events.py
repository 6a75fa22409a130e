"""What happened, in words: plough in and out, fix lost and found, rocks, frames unused, the end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.streams import Streams, Table
from twin.viz.paths import EVENTS
from twin.viz.tools import times

Array = NDArray[Any]

FIXES = {4: "fixed", 5: "float", 2: "differential", 1: "single", 0: "none"}
FIXED = 4
ROCK_SHARE, ROCK_WINDOW = 0.5, 25
"""A rock is seen where draft exceeds its median over a second by half of a rock's peak."""


class Event(NamedTuple):
    """A line of the log."""

    epoch_ns: int
    text: str
    level: str = "INFO"


def log_events(
    recording: rr.RecordingStream, truth: Table, streams: Streams, scenario: Any, ended: str
) -> None:
    """All events of a run, in order."""
    found = sorted(events(truth, streams, scenario, ended))
    if not found:
        return
    stamps = times({"epoch_ns": np.array([e.epoch_ns for e in found], np.int64)})
    text, level = [e.text for e in found], [e.level for e in found]
    recording.send_columns(EVENTS, stamps, rr.TextLog.columns(text=text, level=level))


def events(truth: Table, streams: Streams, scenario: Any, ended: str = "") -> Iterator[Event]:
    """What happened in a run: truth's events, then those that a sensor tells of itself."""
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
        for row, used in _changes(camera["used"][kept] > 0):
            text = "odometry finds its way again" if used else "odometry loses its way"
            level = "INFO" if used else "WARN"
            yield Event(int(camera["epoch_ns"][kept][row]), text, level)
    if ended and len(epoch_ns):
        good = ended == "course driven"
        yield Event(int(epoch_ns[-1]), ended, "INFO" if good else "ERROR")


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


def _changes(flag: Array) -> Iterator[tuple[int, bool]]:
    """Rows where a flag changes, and to what; a flag that begins true changed in the first row."""
    flag = np.asarray(flag, bool)
    for row in np.flatnonzero(np.diff(flag, prepend=False)):
        yield int(row), bool(flag[row])
