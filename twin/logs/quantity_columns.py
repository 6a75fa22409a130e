"""Convert one mapped column to SI values; cells with impossible values become NaN."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.logs.cells import cell_text, numbers, quoted
from twin.logs.checks.codes import given_as_missing, stands_for_none
from twin.logs.checks.plausible import check_usual_speed, implausible, why_implausible
from twin.logs.column_map import BEARINGS, ColumnMap, Source
from twin.logs.losses import Loss
from twin.logs.quantities import QUANTITIES, Quantity
from twin.logs.setup_block import table_of
from twin.logs.signals import Signal
from twin.logs.units import UNITS, WHEEL_RATES
from twin.streams import Array

ANGLE_COUNTS = 10_000
"""Counts of a turn where a wheel's angle is turned into counts and the set-up has no number."""
_FRD = {"gyro_y", "gyro_z", "accel_y", "accel_z"}
"""What turns its sign between forward, right, down and forward, left, up."""


@dataclass
class Remarks:
    """Collected while a log is read: notes for the user, and rows that were left out (losses)."""

    notes: list[str] = field(default_factory=list)
    losses: list[Loss] = field(default_factory=list)


def si_values(
    section: str,
    key: str,
    source: Source,
    signal: Signal,
    at: NDArray[np.int64],
    columns_of: ColumnMap,
    remarks: Remarks,
) -> NDArray[np.float64]:
    """SI values of a column; NaN where a cell is empty or its value is impossible.

    Args:
        section, key: of the map.
        source: what the map says there.
        signal: the column, or its rows that have a time.
        at: number in the log of each of its rows.
        columns_of: the map.
        remarks: notes and losses, added to.
    """
    quantity, name = QUANTITIES[section][key], source.column
    fastest_kmh = columns_of.reading.fastest_kmh
    raw, wrong = numbers(name, signal.cells)
    table = "log" if signal.epoch_ns is None else name
    if wrong.any():
        row = int(np.argmax(wrong))
        says = (
            f"column {quoted(name)}, row {at[row]}: {_not_a_number(cell_text(signal.cells, row))}"
        )
        remarks.losses.append(Loss(table, at[wrong], len(raw), says))
    holes = given_as_missing(raw, source.missing)
    factor = _factor(section, key, quantity, source.unit, columns_of.setup)
    in_unit = raw if source.scale == 1.0 and source.offset == 0.0 else (
        raw * source.scale + source.offset
    )  # fmt: skip
    si = in_unit * factor
    compass = key in BEARINGS and source.convention == "compass"
    codes = stands_for_none(key, quantity, raw, si, compass=compass) & ~holes
    if codes.any():
        first = raw[int(np.argmax(codes))]
        remarks.notes.append(
            f"{section}.{key}: {codes.sum()} values that stand for none, as {first:.7g}, are holes"
        )
    si = np.where(holes | codes, np.nan, si) if holes.any() or codes.any() else si
    if quantity.dimension == "speed":
        check_usual_speed(name, source.unit, factor, si, fastest_kmh)
    odd = implausible(quantity, si, fastest_kmh)
    if odd.any():
        row = int(np.argmax(odd))
        why = why_implausible(quantity, source.unit, factor, float(si[row]), fastest_kmh)
        remarks.losses.append(
            Loss(table, at[odd], len(si), f"column {quoted(name)}, row {at[row]}: {why}")
        )
        si = np.where(odd, np.nan, si)
    if columns_of.axes.get(section) == "FRD" and key in _FRD:
        si = -si
    return math.pi / 2 - si if compass else si


def _not_a_number(cell: str) -> str:
    hint = " (decimal = ',' in [log] reads a decimal comma)" if cell.count(",") == 1 else ""
    return f"{quoted(cell)} is not a number{hint}"


def _factor(
    section: str, key: str, quantity: Quantity, unit: str, setup: Mapping[str, object]
) -> float:
    """From a unit to SI; a wheel's turning becomes its speed by its radius."""
    if unit in UNITS[quantity.dimension]:
        return UNITS[quantity.dimension][unit]
    if key.startswith("ticks_"):
        wheels = table_of("setup.wheels", setup.get("wheels", {}))
        counts = wheels.get("counts_per_turn", ANGLE_COUNTS)
        turn = UNITS["angle"][unit] / (2.0 * math.pi)
        return turn * float(counts if isinstance(counts, int | float) else ANGLE_COUNTS)
    radii = table_of("setup.wheels.radius_m", table_of(
        "setup.wheels", setup.get("wheels", {})).get("radius_m", {}))  # fmt: skip
    wheel = "rl" if key == "driven_speed" else key[-2:]
    radius = radii.get(wheel)
    if not isinstance(radius, int | float):
        raise BadInput(
            f"{section}.{key} in {unit} needs the wheel's radius:"
            f" [setup.wheels] radius_m = {{{wheel} = 0.8}}"
        )
    return WHEEL_RATES[unit] * radius


def as_counts(source: Source, ticks: Array, at: NDArray[np.int64], remarks: Remarks) -> Array:
    """Ticks without fractions, but for rounding: what is no count is a hole."""
    if source.unit in UNITS["angle"]:
        return np.asarray(np.round(ticks))
    broken = np.isfinite(ticks) & (np.abs(ticks - np.round(ticks)) > 1e-6)
    if not broken.any():
        return np.asarray(np.round(ticks))
    row = int(np.argmax(broken))
    says = f"column {quoted(source.column)}, row {at[row]}: {ticks[row]} is not a count"
    remarks.losses.append(Loss("log", at[broken], len(ticks), says))
    return np.where(broken, np.nan, ticks)
