"""Figures of a recorded drive: slip over time and against pull, its distribution, the engine."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from twin.logs.activity import (
    ACTIVITIES,
    EMPTY,
    TURNING,
    WORKING,
    Activity,
    Pull,
    stretches,
)
from twin.logs.gaps import GAP_STEPS
from twin.logs.summary import RPM
from twin.logs.timeline import MOVING_MPS, SECOND_NS
from twin.report.clock import time_axis
from twin.report.draw import Array, Drawing, Estimates, finite
from twin.report.palette import TRUTH_COLOUR, looks
from twin.streams import Table

BLOCKS = 800
"""A long log is drawn as medians of this many blocks of time."""
TINTS = {WORKING: "#e3efe6", TURNING: "#f6ecd8", EMPTY: "#e6eaf3"}
COLOURS = {WORKING: "#009E73", TURNING: "#E69F00", EMPTY: "#0072B2"}
LEAST_IN_BIN = 5
BINS = 12
MOST_DOTS = 3000


def slip(
    rows: Table, done: Activity, estimates: Estimates, start_ns: int, reference: Table | None
) -> Drawing | None:
    """Slip over time: medians of blocks of time with 5 to 95 %; the activity is the tint.

    Where any work was found, the slip at work alone.
    """
    known = [t["slip"] for t in estimates.values() if "slip" in t]
    if not any(np.isfinite(column).any() for column in known):
        return None
    span_s = _span_s(rows)
    bulk = rows.get("slip", np.empty(0))
    works = len(bulk) > 0 and bool(np.isfinite(bulk[done[WORKING]]).any())
    level = 100.0 * (bulk[done[WORKING]] if works else bulk)
    seconds = (rows["epoch_ns"][done[WORKING]] if works else rows["epoch_ns"]) // SECOND_NS

    def draw(axes: Axes) -> None:
        _tint(axes, rows, done)
        for name, (colour, _, style) in looks(estimates).items():
            line = _slip_percent(estimates[name], start_ns, seconds)
            _band(axes, *line, span_s, colour, style, name)
        if reference is not None and "slip" in reference:
            line = _slip_percent(reference, start_ns, seconds)
            _band(axes, *line, span_s, TRUTH_COLOUR, "-", "reference")
        _limits(axes, level)
        axes.set(ylabel="slip at work [%]" if works else "slip [%]", xlim=(0.0, span_s))
        time_axis(axes, span_s)

    return Drawing(title="Slip of the driven axle over time", draw=draw, columns=2)


def slip_against(rows: Table, done: Activity, pull: Pull) -> Drawing | None:
    """Slip at work against draft, torque or load: medians and 5 to 95 % in bins of equal count."""
    if "slip" not in rows or pull.column not in rows:
        return None
    chosen = done[WORKING] & np.isfinite(rows["slip"]) & np.isfinite(rows[pull.column])
    if chosen.sum() < LEAST_IN_BIN:
        return None
    at, values = pull.scale * rows[pull.column][chosen], 100.0 * rows["slip"][chosen]

    def draw(axes: Axes) -> None:
        dots = slice(None, None, 1 + len(at) // MOST_DOTS)
        axes.plot(
            at[dots], values[dots], ".", color="#9a9a9a", ms=2.0, alpha=0.5, rasterized=True,
            label="a second",
        )  # fmt: skip
        middle, level, below, above = binned(at, values)
        bars: Any = {"fmt": "o-", "color": COLOURS[WORKING], "ms": 4.0, "lw": 1.1, "capsize": 2.5}
        axes.errorbar(
            middle,
            level,
            (level - below, above - level),
            label="median, 5th to 95th percentile",
            **bars,
        )
        _limits(axes, values)
        axes.set(xlabel=f"{pull.name} [{pull.unit}]", ylabel="slip at work [%]")

    return Drawing(title=f"Slip against {pull.name}", draw=draw)


def histogram(rows: Table, done: Activity) -> Drawing | None:
    """Share of the time of each activity by slip."""
    if "slip" not in rows or not np.isfinite(rows["slip"]).any():
        return None
    values = 100.0 * rows["slip"]
    low, high = np.quantile(finite(values), (0.01, 0.99))
    reach = max(float(high - low), 1.0)
    edges = np.linspace(low - 0.1 * reach, high + 0.1 * reach, 50)

    def draw(axes: Axes) -> None:
        for code, colour in COLOURS.items():
            chosen = done[code] & np.isfinite(values)
            if chosen.sum() < LEAST_IN_BIN:
                continue
            time_s = rows["duration_s"][chosen]
            counts, _ = np.histogram(values[chosen], edges, weights=time_s / time_s.sum())
            label = ACTIVITIES[code]
            axes.stairs(100.0 * counts, edges, color=colour, lw=1.4, label=label)
        axes.axvline(0.0, color=TRUTH_COLOUR, lw=0.8)
        axes.set(xlabel="slip [%]", ylabel="time of the activity [%]")

    return Drawing(title="Distribution of slip", draw=draw)


def engine(rows: Table, done: Activity) -> Drawing | None:
    """Engine speed, load and fuel rate over time, those that there are."""
    shown = [
        (column, label, scale)
        for column, label, scale in (
            ("engine_radps", "engine [1/min]", RPM),
            ("engine_load", "load [%]", 100.0),
            ("fuel_lph", "fuel [L/h]", 1.0),
        )
        if column in rows
    ]
    if not shown:
        return None
    span_s = _span_s(rows)

    def draw(*axes: Axes) -> None:
        for each, (column, label, scale) in zip(axes, shown, strict=True):
            _tint(each, rows, done)
            time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
            _band(each, time_s, scale * rows[column], span_s, TRUTH_COLOUR, "-", "")
            each.set(ylabel=label, xlim=(0.0, span_s))
            time_axis(each, span_s)
        for each in axes[:-1]:
            each.set_xlabel("")

    return Drawing(title="Engine and fuel over time", draw=draw, rows=len(shown), columns=2)


def blocks(time_s: Array, values: Array, span_s: float) -> tuple[Array, Array, Array, Array]:
    """Middles, medians, 5 % and 95 % of BLOCKS blocks of time; NaN where most is unknown.

    Where there are fewer values than blocks, each value is drawn.
    """
    if len(time_s) <= BLOCKS:
        return time_s, values, values, values
    edges = np.linspace(0.0, span_s, BLOCKS + 1)
    place = np.clip(np.searchsorted(edges, time_s, side="right") - 1, 0, BLOCKS - 1)
    found = np.full((3, BLOCKS), np.nan)
    order = np.argsort(place, kind="stable")
    starts = np.searchsorted(place[order], np.arange(BLOCKS + 1))
    usual = np.median(np.diff(starts)[np.diff(starts) > 0])
    for block in range(BLOCKS):
        inside = values[order[starts[block] : starts[block + 1]]]
        known = inside[np.isfinite(inside)]
        if len(known) and 2 * len(known) >= min(usual, max(len(inside), 1)):
            found[:, block] = np.quantile(known, (0.5, 0.05, 0.95))
    return 0.5 * (edges[1:] + edges[:-1]), found[0], found[1], found[2]


def binned(at: Array, values: Array) -> tuple[Array, Array, Array, Array]:
    """Medians of `at`, and medians, 5 % and 95 % of `values`, in up to BINS bins of equal count."""
    count = max(1, min(BINS, len(at) // LEAST_IN_BIN))
    parts = [part for part in np.array_split(np.argsort(at, kind="stable"), count) if len(part)]
    middle = np.array([np.median(at[part]) for part in parts])
    spread = np.array([np.quantile(values[part], (0.5, 0.05, 0.95)) for part in parts]).T
    return middle, spread[0], spread[1], spread[2]


def _slip_percent(table: Table, start_ns: int, seconds: NDArray[np.int64]) -> tuple[Array, Array]:
    """Times since the start [s] and slip [%], NaN where it hardly moves or in other seconds."""
    values = np.asarray(table.get("slip", np.full(len(table["epoch_ns"]), np.nan)), np.float64)
    if (speed := table.get("speed_mps")) is not None:
        values = np.where(np.abs(speed) > MOVING_MPS, values, np.nan)
    values = np.where(np.isin(table["epoch_ns"] // SECOND_NS, seconds), values, np.nan)
    return (table["epoch_ns"] - start_ns) * 1e-9, 100.0 * values


def _band(
    axes: Axes, time_s: Array, values: Array, span_s: float, colour: str, style: str, label: str
) -> None:
    """Draw values over time as a line with its band, open in gaps."""
    time_s, values = _opened(time_s, values)
    middle, level, below, above = blocks(time_s, values, span_s)
    axes.fill_between(middle, below, above, color=colour, alpha=0.2, lw=0)
    axes.plot(middle, level, style, color=colour, lw=0.9, marker=".", ms=1.5, label=label, zorder=3)


def _opened(time_s: Array, values: Array) -> tuple[Array, Array]:
    """The same with a NaN in each gap of time, so that no line crosses it."""
    steps = np.diff(time_s)
    if not len(steps):
        return time_s, values
    gaps = np.flatnonzero(steps > GAP_STEPS * np.median(steps)) + 1
    middles = 0.5 * (time_s[gaps] + time_s[gaps - 1])
    return np.insert(time_s, gaps, middles), np.insert(values, gaps, np.nan)


def _tint(axes: Axes, rows: Table, done: Activity) -> None:
    """The activity as a tint behind the lines."""
    start_ns = int(rows["epoch_ns"][0])
    time_s = (rows["epoch_ns"] - start_ns) * 1e-9
    for code, colour in TINTS.items():
        spans = [
            (time_s[first], time_s[after - 1] + rows["duration_s"][after - 1] - time_s[first])
            for first, after in stretches(done[code])
        ]
        if spans:
            across = axes.get_xaxis_transform()
            axes.broken_barh(spans, (0.0, 1.0), transform=across, color=colour, lw=0, zorder=0)


def _limits(axes: Axes, values: Array) -> None:
    """Vertical limits from the bulk of the values."""
    known = finite(values)
    if len(known):
        low, high = (float(q) for q in np.quantile(known, (0.01, 0.99)))
        margin = max(0.12 * (high - low), 0.5)
        axes.set_ylim(low - margin, high + margin)


def _span_s(rows: Table) -> float:
    return float(rows["epoch_ns"][-1] - rows["epoch_ns"][0]) * 1e-9 + float(rows["duration_s"][-1])
