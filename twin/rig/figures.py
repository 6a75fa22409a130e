"""Figures of the rigs. Lines are measured, dots what the closed form expects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.report.palette import SEA, TRUTH_COLOUR, colours
from twin.rig.drawbar import DrawbarCurve
from twin.rig.gears import Gears
from twin.rig.park import Creep
from twin.rig.slope import CrabAngles
from twin.rig.wheel import Free, WheelCurve

Array = NDArray[np.float64]

GRADED = ("-", "--", ":", "-.")
"""Line styles of the loads."""


def wheel(curve: WheelCurve, towed: Free, title: str) -> Figure:
    """Gross and net traction, resistance, efficiency and side force against slip."""
    figure = Figure(figsize=(9.6, 6.4), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    figure.suptitle(title, x=0.01, ha="left")
    straight = _only(curve, slip_angle_rad=_smallest_angle(curve))
    _traction(axes[0], straight)
    _efficiency(axes[1], straight)
    _resistance(axes[2], straight, towed)
    _side(axes[3], curve)
    return figure


def _traction(axes: Axes, curve: WheelCurve) -> None:
    palette = colours(("gross", "net"))
    for style, part, load in _by_load(curve):
        axes.plot(
            100 * part.slip, part.gross_traction_ratio, style, color=palette["gross"],
            label=f"gross, {load}",
        )  # fmt: skip
        axes.plot(
            100 * part.slip, part.net_traction_ratio, style, color=palette["net"],
            label=f"net, {load}",
        )  # fmt: skip
    axes.axhline(0.0, color=TRUTH_COLOUR, lw=0.7)
    axes.set(title="traction ratio [-]", xlabel="slip [%]")
    axes.legend()


def _efficiency(axes: Axes, curve: WheelCurve) -> None:
    for style, part, load in _by_load(curve):
        pulling = part.slip >= 0.0
        efficiency = 100 * part.tractive_efficiency[pulling]
        axes.plot(
            100 * part.slip[pulling], efficiency, style, color=colours("abc")["c"], label=load
        )
    axes.set(title="tractive efficiency [%]", xlabel="slip [%]", ylim=(0.0, 100.0))
    axes.legend()


def _resistance(axes: Axes, curve: WheelCurve, towed: Free) -> None:
    colour = colours("abcd")["d"]
    for style, part, load in _by_load(curve):
        axes.plot(100 * part.slip, part.motion_resistance_ratio, style, color=colour, label=load)
    axes.plot(
        100 * towed.slip, towed.towed_ratio, "o", color=TRUTH_COLOUR, ms=4, label="towed free"
    )
    axes.set(title="motion resistance ratio [-]", xlabel="slip [%]", ylim=(0.0, None))
    axes.legend()


def _side(axes: Axes, curve: WheelCurve) -> None:
    """Side force by slip angle; where the wheel only ran straight, its sinkage."""
    angles = [a for a in np.unique(np.round(curve.slip_angle_rad, 6)) if a != 0.0]
    axes.set(xlabel="slip [%]")
    if not angles:
        for style, part, load in _by_load(curve):
            axes.plot(100 * part.slip, 1e3 * part.sinkage_m, style, color=SEA, label=load)
        axes.set(title="sinkage [mm]", ylim=(0.0, None))
    for angle, colour in zip(angles, colours(map(str, angles)).values(), strict=True):
        for style, part, load in _by_load(_only(curve, slip_angle_rad=angle)):
            label = f"{round(np.degrees(angle), 3):g}°, {load}"
            axes.plot(100 * part.slip, part.lateral_ratio, style, color=colour, label=label)
        axes.set(title="lateral coefficient [-] by slip angle")
    axes.legend(ncols=2)


def drawbar(curve: DrawbarCurve, slips: Array, expected_n: Array, title: str) -> Figure:
    """Pull [kN], axle loads [kN] and drawbar power [kW] against slip of the rear axle [%]."""
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    figure.suptitle(title, x=0.01, ha="left")
    palette = colours(("pull", "power", "rear", "front"))
    slip = 100 * curve.slip
    left.plot(slip, curve.pull_n / 1e3, color=palette["pull"], label="loads held")
    left.plot(
        100 * slips, expected_n / 1e3, "o", color=TRUTH_COLOUR, ms=4,
        label="wheel rig and weight transfer",
    )  # fmt: skip
    left.set(title="pull [kN]", xlabel="slip of the rear axle [%]", ylim=(0.0, None))
    left.legend()
    right.plot(slip, curve.rear_load_n / 1e3, color=palette["rear"], label="rear load [kN]")
    right.plot(slip, curve.front_load_n / 1e3, color=palette["front"], label="front load [kN]")
    power = curve.drawbar_power_w / 1e3
    right.plot(slip, power, color=palette["power"], label="drawbar power [kW]")
    right.set(title="loads and power", xlabel="slip of the rear axle [%]", ylim=(0.0, None))
    right.legend()
    return figure


def gears(found: Gears, title: str) -> Figure:
    """Each gear's operating point of greatest drawbar power, against speed [km/h].

    Left: crank and drawbar power [kW]. Right: pull [kN], slip [%] and fuel [L/h].
    """
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    figure.suptitle(title, x=0.01, ha="left")
    palette = colours(("drawbar power", "crank power", "pull", "slip", "fuel"))
    speed_kmh = 3.6 * found.speed_mps
    for name, values in (
        ("crank power", found.crank_power_w),
        ("drawbar power", found.drawbar_power_w),
    ):
        left.plot(speed_kmh, values / 1e3, "o-", color=palette[name], label=f"{name} [kW]")
    left.set(title="greatest steady power", xlabel="speed [km/h]", ylim=(0.0, None))
    left.legend()
    for name, values, unit in (
        ("pull", found.pull_n / 1e3, "kN"), ("slip", 100 * found.slip, "%"),
        ("fuel", found.fuel_lph, "L/h"),
    ):  # fmt: skip
        right.plot(speed_kmh, values, "o-", color=palette[name], label=f"{name} [{unit}]")
    right.set(title="at that power", xlabel="speed [km/h]", ylim=(0.0, None))
    right.legend()
    return figure


def slope(seen: CrabAngles, expected: CrabAngles, title: str) -> Figure:
    """Crab angle [deg], steering angle [deg] and slip [%] against cross slope [deg]."""
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    figure.suptitle(title, x=0.01, ha="left")
    palette = colours(("crab angle", "steering", "slip"))
    _both(left, seen, expected, "crab_angle_rad", palette["crab angle"], "crab angle")
    _both(left, seen, expected, "steer_rad", palette["steering"], "steering")
    left.set(title="angle uphill of the line [°]", xlabel="cross slope [°]")
    left.legend()
    _both(right, seen, expected, "slip", palette["slip"], "slip of the rear axle")
    right.set(title="slip [%]", xlabel="cross slope [°]")
    right.legend()
    return figure


def _both(
    axes: Axes, seen: CrabAngles, expected: CrabAngles, name: str, colour: str, label: str
) -> None:
    scale = 180.0 / np.pi if name.endswith("_rad") else 100.0
    values, wanted = scale * getattr(seen, name), scale * getattr(expected, name)
    axes.plot(seen.cross_slope_deg, values, color=colour, label=label)
    axes.plot(
        expected.cross_slope_deg, wanted, "o", color=colour, ms=4, label=f"{label}, closed form"
    )


def park(creep: Creep, title: str) -> Figure:
    """How far the parked tractor went, slope by slope."""
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    axes = figure.subplots()
    figure.suptitle(title, x=0.01, ha="left")
    names = [
        f"{c:g}° across" if not g else f"{g:g}° along" if not c else f"{c:g}° / {g:g}°"
        for c, g in zip(creep.cross_slope_deg, creep.grade_deg, strict=True)
    ]
    axes.bar(names, np.maximum(1e3 * creep.creep_m, 1e-6), color=colours("ab")["b"])
    axes.axhline(1.0, color=TRUTH_COLOUR, lw=0.8, ls="--", label="1 mm")
    axes.set(title="creep [mm]", yscale="log")
    axes.tick_params(axis="x", rotation=30)
    axes.legend()
    return figure


def _smallest_angle(curve: WheelCurve) -> float:
    return float(curve.slip_angle_rad[np.argmin(np.abs(curve.slip_angle_rad))])


def _only(curve: WheelCurve, **wanted: float) -> WheelCurve:
    """The points at one value of a field."""
    keep = np.ones(curve.slip.shape, dtype=bool)
    for name, value in wanted.items():
        keep &= np.isclose(getattr(curve, name), value, atol=2e-6)
    return curve.where(keep)


def _by_load(curve: WheelCurve) -> Iterator[tuple[str, WheelCurve, str]]:
    loads: Sequence[float] = np.unique(curve.load_n).tolist()
    for i, load_n in enumerate(loads):
        part = _only(curve, load_n=load_n)
        yield GRADED[i % len(GRADED)], part, f"{load_n / 1e3:g} kN"
