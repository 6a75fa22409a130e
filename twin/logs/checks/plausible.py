"""Values no tractor has: most often a wrong unit in the column map, or a disturbed row."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import quoted
from twin.logs.quantities import Quantity
from twin.streams import Array

KMH = 3.6
MEDIAN_SPEED_KMH = 50.0
"""A tractor's road speed; no log has it as its median."""
ANY_SPEED_KMH = 100.0
"""Both give way to what a map says."""
RATIO = 2.0
"""Median GNSS speed to wheel speed, either way up, beyond which they are not of one machine."""
MOVING_MPS = 0.5


def implausible(
    quantity: Quantity, si: Array, fastest_kmh: float | None = None
) -> NDArray[np.bool_]:
    """Which values no tractor has, or of speeds no vehicle that drives so fast, shape (n,)."""
    with np.errstate(invalid="ignore"):
        if quantity.dimension == "speed":
            return np.asarray(np.abs(si) * KMH > _most(ANY_SPEED_KMH, fastest_kmh))
        # a turn of a ulp, so that 90 deg is not beyond pi/2
        slack = 1e-9 * (abs(quantity.low) if np.isfinite(quantity.low) else 0.0)
        return np.asarray((si < quantity.low - slack) | (si > quantity.high * (1 + 1e-9)))


def why_implausible(
    quantity: Quantity, unit: str, factor: float, value: float, fastest_kmh: float | None = None
) -> str:
    """What is wrong with a value, in the file's own unit."""
    if quantity.dimension == "speed":
        return (
            f"{value / factor:.6g} {unit} is {abs(value) * KMH:.4g} km/h,"
            f" {_too_fast(abs(value) * KMH, fastest_kmh)}"
        )
    return (
        f"{value / factor:.6g} {unit} is outside"
        f" [{quantity.low / factor:.6g}, {quantity.high / factor:.6g}]; is the unit right?"
    )


def _most(usual_kmh: float, fastest_kmh: float | None) -> float:
    return usual_kmh if fastest_kmh is None else fastest_kmh


def _too_fast(kmh: float, fastest_kmh: float | None) -> str:
    """Why a speed is none, and what lets it be one."""
    lets = f"if it is, fastest_kmh = {math.ceil(kmh * 1.01)} in [log] lets it be"
    if fastest_kmh is None:
        return f"no tractor's speed; is the unit right? {lets}"
    return f"and [log] says fastest_kmh = {fastest_kmh:g}; is the unit right? {lets}"


def check_usual_speed(
    column: str, unit: str, factor: float, si: Array, fastest_kmh: float | None = None
) -> None:
    """Raise BadInput if a speed is usually one that no tractor has."""
    kmh = np.abs(si) * KMH
    if not np.isfinite(kmh).any():
        return
    row, median = int(np.nanargmax(kmh)), float(np.nanmedian(kmh))
    if median > _most(MEDIAN_SPEED_KMH, fastest_kmh):
        raise BadInput(
            f"column {quoted(column)}: {median / KMH / factor:.6g} {unit} at the median is"
            f" {median:.4g} km/h (row {row + 1} has the most, {kmh[row]:.4g} km/h),"
            f" {_too_fast(float(kmh[row]), fastest_kmh)}"
        )


def check_same_machine(gnss_mps: Array, wheel_mps: Array) -> None:
    """Raise BadInput if the two speeds differ by more than slip can make them."""
    moving = (gnss_mps > MOVING_MPS) & (wheel_mps > MOVING_MPS)
    if moving.sum() < 10:
        return
    ratio = float(np.median(gnss_mps[moving] / wheel_mps[moving]))
    if not 1.0 / RATIO < ratio < RATIO:
        raise BadInput(
            f"GNSS speed is {ratio:.3g} times wheel speed at the median; is one of the units wrong?"
        )
