"""Figures of a run as inline SVG. Truth is black, estimators in the colour-blind safe palette."""

from __future__ import annotations

import html
import io
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.palette import SEA, TRUTH_COLOUR, colours
from twin.scores import at, moving, seconds
from twin.streams import Streams, Table

Array = NDArray[Any]
Estimates = Mapping[str, Table]

WIDTH_IN, HEIGHT_IN = 5.6, 2.7
MOST_POINTS = 700
"""A line is thinned to this many points; the page shows no more."""

NEES_BLOCK_S, LEAST_KW = 5.0, 0.001
POWERS = {
    "drawbar": ("power_drawbar_w",),
    "slip": ("power_slip_long_w", "power_slip_lat_w"),
    "rolling": ("power_rolling_w",),
    "tyres, furrow wall": ("power_tyre_w", "power_wall_w", "power_depth_wheel_w"),
    "engine's own": ("power_parasitic_w",),
    "transmission": ("power_transmission_w", "power_driveline_w"),
}
"""What is drawn of the power balance, from the terms of truth."""

SMALLEST_M = 1e-3
"""Sideslip that never reaches this is not drawn [m]."""

STYLE: Any = {
    "svg.fonttype": "none",  # text stays text, in the page's own font
    "font.family": "sans-serif",
    "font.size": 10.0,
    "legend.fontsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#666",
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "path.simplify": True,
}


def slip(truth: Table | None, estimates: Estimates, window: tuple[float, float] | None) -> str:
    """Slip against time, truth and every estimate with its +-2 sd band; the window is tinted."""
    estimates = {name: moving(table) for name, table in estimates.items()}

    def draw(axes: Axes) -> None:
        if window:
            axes.axvspan(*window, color="#f2f2f2", lw=0, zorder=0)
        _estimate_lines(axes, estimates, "slip", "slip_sd", percent=True)
        _line(axes, truth, "slip", "truth", TRUTH_COLOUR, scale=100.0, width=1.4)
        _limits(axes, [*_columns(truth, estimates, "slip")], 100.0)
        axes.set(xlabel="time [s]", ylabel="slip [%]")

    return svg("Slip of the driven axle over time", draw)


def histogram(truth: Table, estimates: Estimates, window: tuple[float, float]) -> str:
    """Distribution of the slip error inside the window."""
    errors = {
        name: _finite(_slip_error(truth, table, window))
        for name, table in estimates.items()
        if "slip" in table
    }
    values = [e for e in errors.values() if len(e)]
    if not values:
        return ""
    reach = float(np.quantile(np.abs(np.concatenate(values)), 0.995)) * 100.0
    edges = np.linspace(-reach, reach, 61) if reach > 0 else np.linspace(-1.0, 1.0, 61)

    def draw(axes: Axes) -> None:
        for name, colour in colours(estimates).items():
            if len(errors.get(name, [])):
                counts, _ = np.histogram(100.0 * errors[name], edges)
                density = counts / (len(errors[name]) * (edges[1] - edges[0]))
                axes.stairs(density, edges, color=colour, label=name, lw=1.3)
        axes.axvline(0.0, color=TRUTH_COLOUR, lw=0.8)
        axes.set(xlabel="estimate - truth [% slip]", ylabel="density")

    return svg("Distribution of the slip error", draw)


def sideslip(truth: Table | None, estimates: Estimates) -> str:
    """Sideslip amount at the centre of gravity against time."""
    columns = _columns(truth, estimates, "sideslip_m")
    if not any(np.any(np.abs(c) > SMALLEST_M) for c in columns):
        return ""

    def draw(axes: Axes) -> None:
        _estimate_lines(axes, estimates, "sideslip_m", "sideslip_sd_m")
        _line(axes, truth, "sideslip_m", "truth", TRUTH_COLOUR, width=1.4)
        axes.set(xlabel="time [s]", ylabel="sideslip [m]")

    return svg("Sideslip at the centre of gravity over time", draw)


def path(truth: Table | None, streams: Streams) -> str:
    """Where it drove: GNSS antenna, and the rear-axle centre where truth is known."""
    has_fixes = "gnss" in streams and "east_m" in streams["gnss"]
    has_truth = truth is not None and "east_m" in truth
    if not (has_fixes or has_truth):
        return ""

    def draw(axes: Axes) -> None:
        if has_fixes:
            fixes = thinned(streams["gnss"])
            axes.plot(fixes["east_m"], fixes["north_m"], ".", ms=3.0, color=SEA, label="antenna")
        if truth is not None and has_truth:
            rows = thinned(truth)
            axes.plot(rows["east_m"], rows["north_m"], color=TRUTH_COLOUR, label="truth, rear axle")
        axes.set(xlabel="east [m]", ylabel="north [m]")
        _widen(axes)

    return svg("Path, east and north", draw)


def draft(truth: Table | None) -> str:
    """Draft, and below it depth."""
    if truth is None or not np.any(np.abs(truth.get("draft_n", np.zeros(1))) > 1.0):
        return ""

    def draw(upper: Axes, lower: Axes) -> None:
        _line(upper, truth, "draft_n", "", TRUTH_COLOUR, scale=1e-3)
        _line(lower, truth, "depth_m", "", TRUTH_COLOUR, scale=100.0)
        lower.invert_yaxis()
        upper.set(ylabel="draft [kN]")
        lower.set(xlabel="time [s]", ylabel="depth [cm]")

    return svg("Draft and depth of ploughing over time", draw, rows=2)


def speeds(truth: Table | None, estimates: Estimates) -> str:
    """Speed over ground and wheel speed against time."""
    if not _columns(truth, estimates, "speed_mps"):
        return ""

    def draw(axes: Axes) -> None:
        _estimate_lines(axes, estimates, "speed_mps", "")
        _line(axes, truth, "wheel_speed_mps", "wheels (w R), truth", SEA)
        _line(axes, truth, "speed_mps", "ground, truth", TRUTH_COLOUR, width=1.4)
        axes.set(xlabel="time [s]", ylabel="speed [m/s]")

    return svg("Speeds over time", draw)


def power(truth: Table | None, window: tuple[float, float] | None) -> str:
    """Where the engine's power goes: means over the window."""
    if truth is None or window is None or "power_engine_w" not in truth:
        return ""
    time = seconds(truth)
    inside = (time >= window[0]) & (time <= window[1])
    means = {
        label: 1e-3 * sum(float(np.mean(np.abs(truth[c][inside]))) for c in terms if c in truth)
        for label, terms in POWERS.items()
    }
    means = {label: kw for label, kw in means.items() if kw > LEAST_KW}
    whole = 1e-3 * float(np.mean(np.abs(truth["power_engine_w"][inside])))
    if not means or whole <= LEAST_KW:
        return ""

    def draw(axes: Axes) -> None:
        places = np.arange(len(means))[::-1]
        values = np.array(list(means.values()))
        axes.barh(places, values, color="#0072B2", height=0.65)
        for place, kw in zip(places, values, strict=True):
            axes.text(kw, place, f" {kw:.1f} kW, {kw / whole:.0%}", va="center")
        axes.set_yticks(places, list(means))
        axes.set(xlabel=f"of {whole:.1f} kW at the engine", xlim=(0.0, 1.4 * float(values.max())))
        axes.grid(False)

    return svg("Where the engine's power goes", draw, left=0.25)


def nees(truth: Table | None, estimates: Estimates, window: tuple[float, float] | None) -> str:
    """Squared slip error over reported variance, means of blocks of time; 1 is honest."""
    if truth is None or window is None or "slip" not in truth:
        return ""
    edges = np.linspace(*window, max(2, min(41, round((window[1] - window[0]) / NEES_BLOCK_S) + 1)))
    lines = {}
    for name, table in estimates.items():
        if "slip" not in table or "slip_sd" not in table:
            continue
        error = table["slip"] - at(truth, "slip", table["epoch_ns"])
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = (error / table["slip_sd"]) ** 2
        known = np.isfinite(ratio)
        time = seconds(table)[known]
        count, _ = np.histogram(time, edges)
        total, _ = np.histogram(time, edges, weights=ratio[known])
        if np.any(count):
            lines[name] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    if not lines:
        return ""

    def draw(axes: Axes) -> None:
        for name, colour in colours(estimates).items():
            if name in lines:
                middle = 0.5 * (edges[1:] + edges[:-1])
                axes.plot(middle, lines[name], color=colour, marker=".", lw=1.0, label=name)
        axes.axhline(1.0, color=TRUTH_COLOUR, lw=0.8)
        axes.set(xlabel="time [s]", ylabel="NEES of slip", yscale="log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("{x:g}")

    return svg("Squared slip error over reported variance", draw, left=0.16)


def thinned(table: Table, most: int = MOST_POINTS) -> Table:
    """Every k-th row, at most about `most` of them."""
    stride = max(1, len(table["epoch_ns"]) // most)
    return {name: column[::stride] for name, column in table.items()}


def _estimate_lines(
    axes: Axes, estimates: Estimates, column: str, sd: str, *, percent: bool = False
) -> None:
    scale = 100.0 if percent else 1.0
    for name, colour in colours(estimates).items():
        table = estimates[name]
        if column not in table or not len(table["epoch_ns"]):
            continue
        rows = thinned(table)
        time, middle = seconds(rows), scale * rows[column]
        if sd in rows:
            reach = 2.0 * scale * rows[sd]
            axes.fill_between(time, middle - reach, middle + reach, color=colour, alpha=0.18, lw=0)
        axes.plot(time, middle, color=colour, lw=0.8, label=name)


def _line(
    axes: Axes,
    table: Table | None,
    column: str,
    label: str,
    colour: str,
    *,
    scale: float = 1.0,
    width: float = 1.0,
) -> None:
    if table is None or column not in table:
        return
    rows = thinned(table)
    axes.plot(seconds(rows), scale * rows[column], color=colour, lw=width, label=label)


def _columns(truth: Table | None, estimates: Estimates, column: str) -> list[Array]:
    tables = [t for t in (truth, *estimates.values()) if t is not None]
    return [t[column] for t in tables if column in t]


def _limits(axes: Axes, columns: list[Array], scale: float) -> None:
    """Vertical limits from the bulk of the values, so one spike does not flatten the rest."""
    values = _finite(np.concatenate(columns)) if columns else np.empty(0)
    if len(values):
        low, high = scale * np.quantile(values, [0.005, 0.995])
        margin = 0.12 * max(high - low, 0.5)
        axes.set_ylim(low - margin, high + margin)


def _widen(axes: Axes) -> None:
    """Never show less than 2 m of north or east: a straight line is not a zigzag."""
    for get, put in ((axes.get_xlim, axes.set_xlim), (axes.get_ylim, axes.set_ylim)):
        low, high = get()
        spare = max(0.0, 2.0 - (high - low)) / 2.0
        put(low - spare, high + spare)


def _slip_error(truth: Table, table: Table, window: tuple[float, float]) -> Array:
    time = seconds(table)
    rows = (time >= window[0]) & (time <= window[1])
    return np.asarray(table["slip"] - at(truth, "slip", table["epoch_ns"]))[rows]


def _finite(values: Array) -> Array:
    return values[np.isfinite(values)]


def svg(
    title: str,
    draw: Callable[..., None],
    rows: int = 1,
    *,
    left: float = 0.14,
    height_in: float = HEIGHT_IN,
) -> str:
    """Draw into a fresh figure and give it as an SVG element with a title for screen readers."""
    height_in *= 1.0 + 0.5 * (rows - 1)
    with _style():
        figure = Figure(figsize=(WIDTH_IN, height_in))
        axes = [figure.add_subplot(rows, 1, i + 1) for i in range(rows)]
        draw(*axes)
        _legend(axes[0])
        figure.subplots_adjust(
            left=left,
            right=0.985,
            top=1.0 - 0.28 / height_in,
            bottom=0.5 / height_in,
            hspace=0.3,
        )
        text = io.StringIO()
        metadata = {"Date": None, "Creator": None, "Format": None, "Type": None}
        figure.savefig(text, format="svg", metadata=metadata, transparent=True)
    element = text.getvalue()
    element = element[element.index("<svg") :]
    label = f'<svg role="img" aria-label="{html.escape(title)}" class="figure" '
    return element.replace("<svg ", label, 1)


def _legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    named = [(h, label) for h, label in zip(handles, labels, strict=True) if label]
    if named:
        chosen, names = zip(*named, strict=True)
        place: Any = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.98), "borderaxespad": 0.0}
        axes.legend(chosen, names, ncols=5, handlelength=1.2, columnspacing=1.2, **place)


@contextmanager
def _style() -> Iterator[None]:
    with mpl.rc_context(STYLE):
        yield
