"""Figures of the drive and of its estimates, over time and on a map."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from twin.report.draw import (
    Drawing,
    Estimates,
    as_map,
    columns,
    estimate_lines,
    limits,
    line,
    thinned,
)
from twin.report.palette import SEA, TRUTH_COLOUR
from twin.scores.scores import moving, seconds
from twin.streams import Streams, Table

LEAST_W, LEAST_SHARE = 1.0, 0.005
BAND, BLUE = "#b8b8b8", "#0072B2"
POWERS = {
    "drawbar": ("power_drawbar_w",),
    "slip": ("power_slip_long_w", "power_slip_lat_w"),
    "rolling": ("power_rolling_w",),
    "tyres, furrow wall": ("power_tyre_w", "power_wall_w", "power_depth_wheel_w"),
    "engine's own": ("power_parasitic_w",),
    "transmission": ("power_transmission_w", "power_driveline_w", "power_brake_w"),
    "hitch, steering": ("power_joint_w", "power_lift_w", "power_steer_w", "power_contact_w"),
}
"""Label in the figure -> terms of the power balance in truth."""

MOST_FIXES = 3000
SMALLEST_M = 1e-3
"""Sideslip that never reaches this is not drawn [m]."""


def slip(
    truth: Table | None,
    estimates: Estimates,
    window: tuple[float, float] | None,
    bound: Mapping[str, float],
) -> Drawing | None:
    """Slip against time, every estimate with its band, truth with the bound's; window tinted."""
    estimates = {name: moving(table) for name, table in estimates.items()}

    def draw(axes: Axes) -> None:
        if window:
            axes.axvspan(*window, color="#f2f2f2", lw=0, zorder=0)
        estimate_lines(axes, estimates, "slip", "slip_sd", percent=True)
        if truth and "slip" in truth and "slip_causal" in bound:
            rows, reach = thinned(truth), 200.0 * bound["slip_causal"]
            edges = (100.0 * rows["slip"] - reach, 100.0 * rows["slip"] + reach)
            axes.fill_between(
                seconds(rows), *edges, color=BAND, lw=0, zorder=2.5, label="bound, ±2 sd"
            )
        line(axes, truth, "slip", "truth", TRUTH_COLOUR, scale=100.0, width=1.0)
        limits(axes, [*columns(truth, estimates, "slip")], 100.0)
        axes.set(xlabel="time [s]", ylabel="slip [%]")

    return Drawing(title="Slip of the driven axle over time", draw=draw)


def sideslip(truth: Table | None, estimates: Estimates) -> Drawing | None:
    """Sideslip amount at the centre of gravity against time."""
    found = columns(truth, estimates, "sideslip_m")
    if not any(np.any(np.abs(c) > SMALLEST_M) for c in found):
        return None

    def draw(axes: Axes) -> None:
        estimate_lines(axes, estimates, "sideslip_m", "sideslip_sd_m")
        line(axes, truth, "sideslip_m", "truth", TRUTH_COLOUR, width=1.4)
        axes.set(xlabel="time [s]", ylabel="sideslip [m]")

    return Drawing(title="Sideslip at the centre of gravity over time", draw=draw)


def path(truth: Table | None, streams: Streams) -> Drawing | None:
    """Path of the GNSS antenna, and of the rear-axle centre where truth is known."""
    has_fixes = "gnss" in streams and "east_m" in streams["gnss"]
    has_truth = truth and "east_m" in truth
    if not (has_fixes or has_truth):
        return None

    def draw(axes: Axes) -> None:
        if has_fixes:
            fixes = thinned(streams["gnss"], MOST_FIXES)
            look: Any = {"marker": ".", "ms": 3.0, "lw": 0.0} if has_truth else {"lw": 0.8}
            axes.plot(fixes["east_m"], fixes["north_m"], color=SEA, label="antenna", **look)
        if truth and has_truth:
            rows = thinned(truth)
            axes.plot(rows["east_m"], rows["north_m"], color=TRUTH_COLOUR, label="truth, rear axle")
        axes.set(xlabel="east [m]", ylabel="north [m]")
        as_map(axes)

    return Drawing(title="Path, east and north", draw=draw)


def draft(truth: Table | None) -> Drawing | None:
    """Draft, and below it depth."""
    if not truth or not np.any(np.abs(truth.get("draft_n", np.zeros(1))) > 1.0):
        return None

    def draw(upper: Axes, lower: Axes) -> None:
        line(upper, truth, "draft_n", "", TRUTH_COLOUR, scale=1e-3)
        line(lower, truth, "depth_m", "", TRUTH_COLOUR, scale=100.0)
        lower.invert_yaxis()
        upper.set(ylabel="draft [kN]")
        lower.set(xlabel="time [s]", ylabel="depth [cm]")

    return Drawing(title="Draft and depth of ploughing over time", draw=draw, rows=2)


def speeds(truth: Table | None, estimates: Estimates) -> Drawing | None:
    """Speed over ground and wheel speed against time."""
    if not columns(truth, estimates, "speed_mps"):
        return None

    def draw(axes: Axes) -> None:
        estimate_lines(axes, estimates, "speed_mps", "")
        line(axes, truth, "wheel_speed_mps", "wheels (w R), truth", SEA)
        line(axes, truth, "speed_mps", "ground, truth", TRUTH_COLOUR, width=1.4)
        axes.set(xlabel="time [s]", ylabel="speed [m/s]")

    return Drawing(title="Speeds over time", draw=draw)


def power(truth: Table | None, window: tuple[float, float] | None) -> Drawing | None:
    """Mean power by use over the window, of that of the engine and of lost height and speed."""
    if not truth or window is None or "power_engine_w" not in truth:
        return None
    time = seconds(truth)
    part = {name: c[(time >= window[0]) & (time <= window[1])] for name, c in truth.items()}
    engine_w = float(np.mean(part["power_engine_w"]))
    stored_w = sum(_growth(part, name) for name in ("kinetic_j", "potential_j"))
    whole_w = engine_w + max(0.0, -stored_w)
    means_w = {
        label: sum(float(np.mean(part[c])) for c in terms if c in part)
        for label, terms in POWERS.items()
    } | {"height and speed": stored_w}
    means_w = {label: w for label, w in means_w.items() if w > LEAST_SHARE * whole_w}
    if whole_w <= LEAST_W or not means_w:
        return None
    unit, per_unit, digits = ("kW", 1e-3, 1) if whole_w > 1000.0 else ("W", 1.0, 0)
    total = f"of {per_unit * whole_w:.{digits}f} {unit} at the engine"
    if -stored_w > LEAST_SHARE * whole_w:
        total = total.removesuffix(" at the engine") + (
            f": engine {per_unit * engine_w:.{digits}f}, "
            f"height and speed lost {-per_unit * stored_w:.{digits}f}"
        )

    def draw(axes: Axes) -> None:
        places = np.arange(len(means_w))[::-1]
        values = per_unit * np.array(list(means_w.values()))
        axes.barh(places, values, color=BLUE, height=0.65)
        for place, value in zip(places, values, strict=True):
            said = f"{value:.{digits}f} {unit}, {value / (per_unit * whole_w):.0%}"
            beside: Any = {"xytext": (3.0, 0.0), "textcoords": "offset points", "va": "center"}
            axes.annotate(said, (value, place), **beside)
        axes.set_yticks(places, list(means_w))
        axes.set(xlabel=f"mean power [{unit}]\n{total}", xlim=(0.0, 1.5 * float(values.max())))
        axes.grid(False)

    return Drawing(title="Where power goes", draw=draw, left=0.27)


def _growth(part: Table, name: str) -> float:
    """Mean growth of a stored energy [W]."""
    if name not in part or len(part[name]) < 2:
        return 0.0
    time_s = seconds(part)
    return float(part[name][-1] - part[name][0]) / float(time_s[-1] - time_s[0])
