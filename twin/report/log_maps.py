"""Maps of a recorded drive: slip at work, and the path by activity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from twin.logs.activity import ACTIVITIES, WORKING, Activity, smoothed
from twin.logs.summary import Stretch
from twin.report.draw import Array, Drawing, as_map
from twin.report.log_figures import COLOURS, MOST_DOTS
from twin.streams import Table

SLIP_COLOURS = "viridis"
MARGIN_M = 15.0
"""Shown around the field."""


def slip_map(rows: Table, done: Activity, high: Sequence[Stretch]) -> Drawing | None:
    """Where slip was how high at work; the stretches of the highest slip are numbered."""
    if not {"east_m", "north_m", "slip"} <= set(rows):
        return None
    east, north = rows["east_m"], rows["north_m"]
    placed = np.isfinite(east) & np.isfinite(north)
    at_work = np.where(done[WORKING], rows["slip"], np.nan)
    values = 100.0 * smoothed(at_work, rows)
    seen = placed & np.isfinite(values) & done[WORKING]
    if not seen.any():
        return None
    dots = np.flatnonzero(seen)[:: 1 + int(seen.sum()) // MOST_DOTS]
    low, top = (float(q) for q in np.quantile(values[seen], (0.02, 0.98)))

    def draw(axes: Axes) -> None:
        _track(axes, rows, placed, "#c8c8c8", 0.7)
        look: Any = {"cmap": SLIP_COLOURS, "vmin": min(low, 0.0), "vmax": max(top, low + 0.1)}
        drawn = axes.scatter(
            east[dots], north[dots], c=values[dots], s=7.0, lw=0, zorder=3, rasterized=True, **look
        )
        _numbers(axes, high)
        _extent(axes, east[seen], north[seen])
        axes.set(xlabel="east [m]", ylabel="north [m]")
        place = axes.inset_axes((0.0, 1.04, 1.0, 0.03))
        assert axes.figure is not None
        bar = axes.figure.colorbar(drawn, cax=place, orientation="horizontal", extend="both")
        bar.set_label("slip at work [%]")
        place.xaxis.set_ticks_position("top")
        place.xaxis.set_label_position("top")

    return Drawing(title="Slip on the field", draw=draw, height_in=4.8, above_in=0.65)


def activity_map(rows: Table, done: Activity) -> Drawing | None:
    """Where the machine worked, turned and drove."""
    if not {"east_m", "north_m"} <= set(rows):
        return None
    placed = np.isfinite(rows["east_m"]) & np.isfinite(rows["north_m"])
    if not placed.any():
        return None

    def draw(axes: Axes) -> None:
        for code, colour in COLOURS.items():
            chosen = placed & done[code]
            if chosen.any():
                _track(axes, rows, chosen, colour, 1.0, ACTIVITIES[code])
        standing = placed & ~np.isin(done.code, list(COLOURS))
        if standing.any():
            places = rows["east_m"][standing], rows["north_m"][standing]
            axes.plot(*places, ".", color="#777777", ms=3.0, label="standing", rasterized=True)
        axes.set(xlabel="east [m]", ylabel="north [m]")
        as_map(axes)

    return Drawing(title="Path by activity", draw=draw, height_in=4.8)


def _track(
    axes: Axes, rows: Table, chosen: NDArray[np.bool_], colour: str, width: float, label: str = ""
) -> None:
    """The path through the chosen rows, open where rows between were not chosen or not there."""
    steps_s = np.diff(rows["epoch_ns"], append=rows["epoch_ns"][-1:]) * 1e-9
    whole = chosen & ~(steps_s > 1.5 * rows["duration_s"])
    east = np.where(chosen, rows["east_m"], np.nan)
    north = np.where(chosen, rows["north_m"], np.nan)
    cuts = np.flatnonzero(chosen & ~whole) + 1
    axes.plot(
        np.insert(east, cuts, np.nan), np.insert(north, cuts, np.nan),
        color=colour, lw=width, label=label or None, solid_capstyle="round", rasterized=True,
    )  # fmt: skip


def _numbers(axes: Axes, high: Sequence[Stretch]) -> None:
    for number, stretch in enumerate(high, 1):
        if stretch.east_m is None or stretch.north_m is None:
            continue
        box: Any = {"boxstyle": "circle,pad=0.25", "fc": "white", "ec": "#333333", "lw": 0.8}
        place: Any = {"ha": "center", "va": "center", "fontsize": 8, "bbox": box, "zorder": 5}
        axes.annotate(str(number), (stretch.east_m, stretch.north_m), **place)


def _extent(axes: Axes, east: Array, north: Array) -> None:
    """The field: where 98 % of the work was, with a margin; a metre is as long both ways."""
    low, high = np.quantile(np.column_stack([east, north]), (0.01, 0.99), axis=0)
    axes.dataLim.set_points(np.array([low - MARGIN_M, high + MARGIN_M]))
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
