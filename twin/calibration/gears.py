"""The gears of a log, found from engine and wheel speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WIDTH = 0.02
"""Gears nearer than this share of their ratio are one: steps of a transmission are 10 to 25 %."""
LEAST_SHARE = 0.02
"""A gear has at least this share of the driven time."""
LEAST_ROWS = 5
SAME = 0.06
"""A gear of the machine's file has the name where it is within this share: radii are in it."""


@dataclass(frozen=True)
class Gear:
    """One gear that was driven."""

    name: str
    """That of the machine's file by its number, or by its speed at rated engine speed."""
    ratio: float
    """Engine turns per turn of the rear axle, by the nominal radius."""
    share: float
    """Of the driven rows."""


def found(ratio: Array, known: tuple[float, ...] = (), kmh_times_ratio: float = 0.0) -> list[Gear]:
    """The gears among ratios of engine to axle speed, by falling ratio.

    A gear is a peak of the ratios' density: more rows within +-2 % than beside it.

    Args:
        ratio: of rows in which engine and wheels turn, NaN where not known.
        known: ratios of the machine's file.
        kmh_times_ratio: speed of a ratio of 1 at rated engine speed, to name the others.
    """
    logs = np.sort(np.log(ratio[np.isfinite(ratio) & (ratio > 0.0)]))
    gears: list[Gear] = []
    left, least = logs, max(LEAST_ROWS, math.ceil(LEAST_SHARE * len(logs)))
    while len(left) >= least:
        count = np.searchsorted(left, left + WIDTH, "right") - np.arange(len(left))
        first = int(np.argmax(count))
        if count[first] < least:
            break
        inside = left[first : first + count[first]]
        middle = float(np.median(inside))
        if all(abs(middle - math.log(g.ratio)) > 2.0 * WIDTH for g in gears):
            share = len(inside) / len(logs)
            gears.append(Gear(_name(math.exp(middle), known, kmh_times_ratio), math.exp(middle),
                              share))  # fmt: skip
        left = np.concatenate([left[:first], left[first + count[first] :]])
    return sorted(gears, key=lambda gear: -gear.ratio)


def _name(ratio: float, known: tuple[float, ...], kmh_times_ratio: float) -> str:
    if known:
        nearest = min(range(len(known)), key=lambda i: abs(math.log(known[i] / ratio)))
        if abs(math.log(known[nearest] / ratio)) < SAME:
            return f"gear {nearest + 1}"
    return f"{kmh_times_ratio / ratio:.1f} km/h" if kmh_times_ratio else f"1:{ratio:.1f}"


def gear_of(ratio: float, gears: list[Gear]) -> Gear | None:
    """The gear a ratio is of, within twice a gear's width."""
    near = min(gears, key=lambda g: abs(math.log(g.ratio / ratio)), default=None)
    if near is None or abs(math.log(near.ratio / ratio)) > 2.0 * WIDTH:
        return None
    return near
