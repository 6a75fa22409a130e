"""Errors of an estimator on a log after times without GNSS.

A log of a user has no truth. The speed of the GNSS receiver replaces the truth: the GNSS samples of
regular time intervals are removed ("hidden") before the estimator runs, and the estimate at the end
of each interval is compared with the speed of the receiver. Pure functions on tables and streams.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.scores.phases import SCORED
from twin.streams import Setup, Streams, Table

Array = NDArray[np.float64]
Errors = tuple[Array, Array, Array]
"""Errors of speed [m/s] and slip, and the slip's squared error over its variance, by place."""

LEARN_S = 30.0
"""Time before GNSS is hidden for the first time [s]."""
SEEN_TIMES, MOST_SEEN_S = 4.0, 20.0
"""GNSS is then visible for 4 times the hidden time, at most for the hidden time plus 20 s."""
MOVING_MPS = 0.5
"""At the end of a hidden time the machine must drive faster than this [m/s]."""
PLACES, MOST_PASSES = 30, 8
"""A short log is passed up to 8 times with its places shifted, until there are 30 of them."""
SLOW_MPS = 0.05
"""The least speed that a slip is divided by, as slip is defined [m/s]."""
DEFAULT_SD_MPS = 0.05
"""Taken for the receiver's noise where nobody states it [m/s]."""


@dataclass(frozen=True)
class Score:
    """Errors of speed and slip of an estimator after `hidden_s` seconds without GNSS."""

    estimator: str
    hidden_s: float
    n: int
    """Number of hidden times at whose ends the machine drives."""
    speed_rms_mps: float | None
    """Root mean square of the speed error [m/s]; None if an estimate is missing."""
    slip_rms: float | None
    """Root mean square of the slip error [-]; the reference slip uses the receiver's speed."""
    in_2sd: float | None
    """Share of the slip errors within 2 sd [-]; the sd includes the noise of the receiver."""
    phases: Mapping[str, Mapping[str, float | int | None]] = field(default_factory=dict)
    """Phase (work, turn or road) -> `n`, `speed_rms_mps`, `slip_rms` and `in_2sd` in the phase."""


def period_s(hidden_s: float) -> float:
    """Time from the start of a hidden interval to the start of the next [s].

    period = hidden_s + min(4 hidden_s, 20 s + hidden_s)

    Args:
        hidden_s: length of a hidden interval [s].
    """
    return hidden_s + min(SEEN_TIMES * hidden_s, MOST_SEEN_S + hidden_s)


def passes(setup: Setup, streams: Streams, hidden_s: float) -> Iterator[NDArray[np.int64]]:
    """Start epochs of the hidden intervals [ns], one array of shape (k,) for each pass.

    start = first GNSS sample + 30 s + (i + pass / passes) period,   i = 0, 1, ...

    Args:
        setup: set-up of the sensors, for the mounting angle of the GNSS heading.
        streams: streams of the log.
        hidden_s: length of a hidden interval [s].
    """
    seen = streams["gnss"]["epoch_ns"][np.isfinite(speeds(setup, streams))]
    if not len(seen):
        return
    period = period_s(hidden_s)
    room = (seen[-1] - seen[0]) * 1e-9 - LEARN_S - hidden_s
    count = int(min(MOST_PASSES, max(1, np.ceil(PLACES * period / max(room, period)))))
    for shift in range(count):
        first = LEARN_S + period * shift / count
        starts = np.arange(first, LEARN_S + max(room, 0.0), period)
        if len(starts):
            yield seen[0] + np.round(starts * 1e9).astype(np.int64)


def without_gnss(streams: Streams, start_ns: NDArray[np.int64], hidden_s: float) -> Streams:
    """Streams without the GNSS samples in (start, start + hidden_s] of each start.

    Args:
        streams: streams of the log.
        start_ns: start epochs of the hidden intervals [ns], ascending. Shape (k,).
        hidden_s: length of a hidden interval [s].
    """
    inside = place_of(streams["gnss"]["epoch_ns"], start_ns, hidden_s) >= 0
    seen = {name: column[~inside] for name, column in streams["gnss"].items()}
    return Streams({**streams.tables, "gnss": seen}, streams.frames)


def place_of(
    epoch_ns: NDArray[np.int64], start_ns: NDArray[np.int64], hidden_s: float
) -> NDArray[np.int64]:
    """Index of the hidden interval that contains each epoch; -1 outside all. Shape (n,).

    Args:
        epoch_ns: epochs [ns]. Shape (n,).
        start_ns: start epochs of the hidden intervals [ns], ascending. Shape (k,).
        hidden_s: length of a hidden interval [s].
    """
    place = np.searchsorted(start_ns, epoch_ns, side="left") - 1
    since = epoch_ns - start_ns[np.maximum(place, 0)]
    return np.where((place >= 0) & (since <= round(hidden_s * 1e9)), place, -1)


def speeds(setup: Setup, streams: Streams) -> Array:
    """Speed of the GNSS receiver at each GNSS sample [m/s]; NaN without a fix. Shape (n,).

    v = v_east cos h + v_north sin h   if the sample has a heading
    v = hypot(v_east, v_north)         otherwise

    v_east, v_north: velocity in the east-north frame [m/s]. h: heading of the machine from east,
    positive to the left [rad], which is the GNSS heading less the mounting angle of `setup`.
    """
    east, north, heading, quality = (
        streams.column("gnss", name).astype(np.float64)
        for name in ("v_east_mps", "v_north_mps", "heading_rad", "quality")
    )
    heading = heading - (setup.gnss.heading_mount_rad if setup.gnss else 0.0)
    along = east * np.cos(heading) + north * np.sin(heading)
    speed = np.where(np.isfinite(heading), along, np.hypot(east, north))
    return np.asarray(np.where(quality == 0.0, np.nan, speed))


def ends(
    setup: Setup, streams: Streams, table: Table, start_ns: NDArray[np.int64], hidden_s: float
) -> tuple[list[int], list[bool]]:
    """Rows of `gnss` at the ends of the hidden intervals, and whether each has an estimate.

    The row of an interval is the last GNSS sample that is not newer than the last estimate in the
    interval. An interval has no row if the machine is slower than 0.5 m/s at this sample.

    Args:
        setup: set-up of the sensors.
        streams: streams of the log, with all GNSS samples.
        table: estimates; only `epoch_ns` [ns] is used.
        start_ns: start epochs of the hidden intervals [ns], ascending. Shape (k,).
        hidden_s: length of a hidden interval [s].
    """
    gnss, epoch_ns = streams["gnss"]["epoch_ns"], table["epoch_ns"]
    measured = speeds(setup, streams)
    own = place_of(epoch_ns, start_ns, hidden_s)
    place = place_of(gnss, start_ns, hidden_s)
    rows: list[int] = []
    spoken: list[bool] = []
    for i in range(len(start_ns)):
        inside = epoch_ns[own == i]
        newest = inside.max() if len(inside) else np.iinfo(np.int64).max
        at = np.flatnonzero((place == i) & (gnss <= newest) & np.isfinite(measured))
        if len(at) and abs(measured[at[-1]]) > MOVING_MPS:
            rows.append(int(at[-1]))
            spoken.append(len(inside) > 0)
    return rows, spoken


def errors(
    setup: Setup, streams: Streams, table: Table, start_ns: NDArray[np.int64], hidden_s: float
) -> Errors:
    """Errors of an estimator at the ends of the hidden intervals, three arrays of shape (m,).

    The arrays are speed error v - v_gnss [m/s], slip error [-] and slip error^2 / variance [-].

    slip error = (w - v) / max(|w|, |v|) - (w - v_gnss) / max(|w|, |v_gnss|)
    variance   = slip_sd^2 + (sd_gnss max(|w|, |v|) / max(|w|, |v_gnss|)^2)^2

    v, w: estimated speeds of the machine over ground and of the driven wheels [m/s]. v_gnss: speed
    of the GNSS receiver [m/s], sd_gnss: standard deviation of v_gnss [m/s]. slip_sd: standard
    deviation of the slip that the estimator reports [-]. `ends` chooses the samples. The errors of
    an interval are NaN if the interval has no estimate.

    Args:
        setup: set-up of the sensors.
        streams: streams of the log, with all GNSS samples.
        table: estimates that were made without the hidden GNSS samples.
        start_ns: start epochs of the hidden intervals [ns], ascending. Shape (k,).
        hidden_s: length of a hidden interval [s].
    """
    gnss = streams["gnss"]["epoch_ns"]
    measured = speeds(setup, streams)
    rows, spoken = ends(setup, streams, table, start_ns, hidden_s)
    sd = streams.column("gnss", "velocity_sd_mps").astype(np.float64)
    stated = setup.gnss.velocity_sd_mps if setup.gnss else DEFAULT_SD_MPS
    sd = np.where(sd > 0.0, sd, stated)
    true, noise, when = measured[rows], sd[rows], gnss[rows]
    v, w, slip_sd = (
        np.where(spoken, _at(table, name, when), np.nan)
        for name in ("speed_mps", "wheel_speed_mps", "slip_sd")
    )
    headed = np.isfinite(streams.column("gnss", "heading_rad").astype(np.float64)[rows])
    true = np.where(headed | (v >= 0.0) | np.isnan(v), true, -true)
    scale = np.maximum(np.maximum(np.abs(w), np.abs(true)), SLOW_MPS)
    slip = (w - v) / np.maximum(np.maximum(np.abs(w), np.abs(v)), SLOW_MPS) - (w - true) / scale
    by_noise = noise * np.where(np.abs(true) > np.abs(w), np.abs(w), scale) / scale**2
    return v - true, slip, slip**2 / (slip_sd**2 + by_noise**2)


def _at(table: Table, name: str, epoch_ns: NDArray[np.int64]) -> Array:
    """A column at other epochs, linear between the rows; NaN before the first."""
    if name not in table or not len(table["epoch_ns"]):
        return np.full(len(epoch_ns), np.nan)
    start = table["epoch_ns"][0]
    own = (table["epoch_ns"] - start).astype(np.float64)
    return np.asarray(
        np.interp((epoch_ns - start).astype(np.float64), own, table[name], left=np.nan)
    )


def summed_up(
    estimator: str,
    hidden_s: float,
    of_passes: list[Errors],
    phase_of_passes: list[NDArray[np.int64]] | None = None,
) -> Score:
    """The score of an estimator over the errors of all passes.

    Args:
        estimator: name of the estimator.
        hidden_s: length of a hidden interval [s].
        of_passes: result of `errors` for each pass.
        phase_of_passes: phase code of each error of each pass; None if the phases are unknown.
    """
    speed, slip, squared = (np.concatenate(part) for part in zip(*of_passes, strict=True))
    by_phase = {}
    if phase_of_passes is not None:
        code = np.concatenate(phase_of_passes)
        for name, phase in SCORED.items():
            if (chosen := code == phase).any():
                by_phase[name] = _sums(speed[chosen], slip[chosen], squared[chosen])
    return Score(estimator, hidden_s, **_sums(speed, slip, squared), phases=by_phase)


def _sums(speed: Array, slip: Array, squared: Array) -> dict[str, Any]:
    known = squared[np.isfinite(squared)]
    inside = float(np.mean(known <= 4.0)) if len(known) else None
    return {
        "n": len(speed), "speed_rms_mps": _rms(speed), "slip_rms": _rms(slip), "in_2sd": inside,
    }  # fmt: skip


def _rms(error: Array) -> float | None:
    """None where there is no error, or where the estimator is silent at any place."""
    if not len(error) or not np.isfinite(error).all():
        return None
    return float(np.sqrt(np.mean(error**2)))
