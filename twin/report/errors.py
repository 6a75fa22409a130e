"""Figures of the errors of estimates, with the smallest error that sensors and motion allow."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from twin.io.plain import Plain
from twin.report.draw import Array, Drawing, Estimates, finite
from twin.report.palette import TRUTH_COLOUR, looks
from twin.scores.scores import at, seconds
from twin.streams import Table

Window = tuple[float, float]

BLOCK_S, BLOCKS = 5.0, (20, 40)
"""Errors over time are means of blocks: their length, and the least and the largest number."""
BOUNDS: tuple[tuple[str, Plain], ...] = (("causal", "--"), ("offline", ":"))
"""Of `estimators.bounds`, each with its line."""
NEES_SHOWN = (0.3, 3.0)
"""The axis of the NEES reaches at least so far."""
_DEG = 180.0 / np.pi


def histogram(
    truth: Table, estimates: Estimates, window: Window, bound: Mapping[str, float]
) -> Drawing | None:
    """Distribution of the slip error inside the window, and that of the causal bound."""
    errors = {
        name: finite(error[inside(table, window)])
        for name, table in estimates.items()
        if (error := error_of(truth, table, "slip")) is not None
    }
    values = [e for e in errors.values() if len(e)]
    if not values:
        return None
    reach = float(np.quantile(np.abs(np.concatenate(values)), 0.995)) * 100.0
    edges = np.linspace(-reach, reach, 61) if reach > 0 else np.linspace(-1.0, 1.0, 61)

    def draw(axes: Axes) -> None:
        for name, (colour, _, style) in looks(estimates).items():
            if len(errors.get(name, [])):
                counts, _ = np.histogram(100.0 * errors[name], edges)
                density = counts / (len(errors[name]) * (edges[1] - edges[0]))
                axes.stairs(density, edges, color=colour, ls=style, label=name, lw=1.3)
        if (sd := 100.0 * bound.get("slip_causal", 0.0)) > 0.0:
            at_ = np.linspace(-min(4.0 * sd, reach), min(4.0 * sd, reach), 121)
            density = np.exp(-0.5 * (at_ / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi))
            axes.plot(at_, density, "--", color=TRUTH_COLOUR, lw=1.0, label="bound, causal")
        axes.axvline(0.0, color=TRUTH_COLOUR, lw=0.8)
        axes.set(xlabel="estimate - truth [% slip]", ylabel="density [1/%]")

    return Drawing(title="Distribution of the slip error", draw=draw)


def slip_error(
    truth: Table, estimates: Estimates, window: Window, bound: Mapping[str, float]
) -> Drawing | None:
    """RMS of the slip error over time, and the bounds as lines."""
    bounds = {w: bound[f"slip_{w}"] for w, _ in BOUNDS if f"slip_{w}" in bound}
    blocks = _blocks(truth, estimates, "slip", window)
    drawn = _error_drawing(blocks, estimates, bounds, "RMS error [% slip]", 100.0)
    return Drawing(title="RMS of the slip error over time", draw=drawn) if blocks else None


def angle_error(
    truth: Table, estimates: Estimates, window: Window, bound: Mapping[str, float]
) -> Drawing | None:
    """RMS of the error of the sideslip angle over time, and the bounds as lines."""
    bounds = {w: bound[f"sideslip_{w}_rad"] for w, _ in BOUNDS if f"sideslip_{w}_rad" in bound}
    blocks = _blocks(truth, estimates, "sideslip_rad", window)
    drawn = _error_drawing(blocks, estimates, bounds, "RMS error of the angle [°]", _DEG)
    title = "RMS of the error of the sideslip angle over time"
    return Drawing(title=title, draw=drawn) if blocks else None


def nees(truth: Table, estimates: Estimates, window: Window) -> Drawing | None:
    """Squared slip error over reported variance, means over blocks of time; 1 is consistent."""
    blocks = _blocks(truth, estimates, "slip", window, consistency=True)
    if not blocks:
        return None

    def draw(axes: Axes) -> None:
        _lines(axes, blocks, estimates)
        axes.axhline(1.0, color=TRUTH_COLOUR, lw=0.8)
        axes.set(ylabel="NEES of slip [-]", yscale="log")
        low, high = axes.get_ylim()
        low, high = min(low, NEES_SHOWN[0]), max(high, NEES_SHOWN[1])
        axes.set_ylim(low, high)
        wide = high > 30.0 * low
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())

    return Drawing(title="Squared slip error over reported variance", draw=draw, left=0.16)


def error_of(truth: Table, table: Table, column: str) -> Array | None:
    """Estimate less truth at the estimate's epochs; None where either has no such column."""
    if column not in table or column not in truth:
        return None
    return np.asarray(table[column] - at(truth, column, table["epoch_ns"]))


def inside(table: Table, window: Window) -> Array:
    """Rows of a table within a window."""
    time = seconds(table)
    return np.asarray((time >= window[0]) & (time <= window[1]))


def block_means(table: Table, values: Array, window: Window) -> tuple[Array, Array]:
    """Middles of the window's blocks [s], and the mean of a column in each; NaN in an empty one."""
    count = int(np.clip(round((window[1] - window[0]) / BLOCK_S), *BLOCKS))
    edges = np.linspace(*window, count + 1)
    known = np.isfinite(values)
    time = seconds(table)[known]
    counts, _ = np.histogram(time, edges)
    total, _ = np.histogram(time, edges, weights=values[known])
    means = np.where(counts > 0, total / np.maximum(counts, 1), np.nan)
    return 0.5 * (edges[1:] + edges[:-1]), means


def _blocks(
    truth: Table, estimates: Estimates, column: str, window: Window, *, consistency: bool = False
) -> dict[str, tuple[Array, Array]]:
    """Time and mean square error in blocks of each estimate; over its variance if so asked."""
    found = {}
    for name, table in estimates.items():
        error = error_of(truth, table, column)
        if error is None or (consistency and f"{column}_sd" not in table):
            continue
        sd = table[f"{column}_sd"] if consistency else 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            time, means = block_means(table, (error / sd) ** 2, window)
        if np.isfinite(means).any():
            found[name] = time, means
    return found


def _lines(axes: Axes, blocks: Mapping[str, tuple[Array, Array]], estimates: Estimates) -> None:
    for name, (colour, _, style) in looks(estimates).items():
        if name in blocks:
            axes.plot(*blocks[name], style, color=colour, marker=".", lw=1.0, label=name)
    axes.set_xlabel("time [s]")


def _error_drawing(
    blocks: Mapping[str, tuple[Array, Array]],
    estimates: Estimates,
    bounds: Mapping[str, float],
    label: str,
    scale: float,
) -> Callable[[Axes], None]:
    """Roots of mean squares over time, and below them the bounds."""

    def draw(axes: Axes) -> None:
        rms = {name: (time, scale * np.sqrt(square)) for name, (time, square) in blocks.items()}
        _lines(axes, rms, estimates)
        for when, style in BOUNDS:
            if when in bounds:
                level, name = scale * bounds[when], f"bound, {when}"
                axes.axhline(level, color=TRUTH_COLOUR, ls=style, lw=1.1, label=name)
        axes.set_ylabel(label)
        axes.set_ylim(bottom=0.0)

    return draw
