"""Time series: truth and each estimate beside each other, with its band."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twin.palette import SEA, colours
from twin.scores import moving
from twin.streams import Table
from twin.viz.paths import DEPTH, DRAFT, SIDESLIP, SLIP, SPEED, TRUTH_COLOUR
from twin.viz.tools import every, rgba, times

Array = NDArray[Any]

PLOT_RATE_HZ = 20.0


def plot_all(
    recording: rr.RecordingStream, estimates: Mapping[str, Table], truth: Mapping[str, Array]
) -> None:
    """Slip, speed, sideslip, draft and depth; nothing where a table has no such column."""
    palette = colours(estimates)
    for name, table in estimates.items():
        rows = moving(every(table, PLOT_RATE_HZ))
        _plot(recording, f"{SLIP}/{name}", rows, "slip", name, palette[name])
        _plot_band(recording, f"{SLIP}/{name}", rows, name, palette[name])
        _plot(recording, f"{SPEED}/{name}", rows, "speed_mps", name, palette[name])
        _plot(recording, f"{SIDESLIP}/{name}", rows, "sideslip_m", name, palette[name])
    if len(truth.get("epoch_ns", ())):
        rows = every(dict(truth), PLOT_RATE_HZ)
        _plot(recording, f"{SLIP}/truth", rows, "slip", "truth", TRUTH_COLOUR, 2.5)
        _plot(recording, f"{SPEED}/truth", rows, "speed_mps", "truth", TRUTH_COLOUR, 2.5)
        _plot(recording, f"{SPEED}/wheels", rows, "wheel_speed_mps", "wheels (w R)", SEA)
        _plot(recording, f"{SIDESLIP}/truth", rows, "sideslip_m", "truth", TRUTH_COLOUR, 2.5)
        _plot(recording, f"{DRAFT}/truth", rows, "draft_n", "draft [kN]", TRUTH_COLOUR, scale=1e-3)
        _plot(recording, f"{DEPTH}/truth", rows, "depth_m", "depth [m]", TRUTH_COLOUR)


def _plot(
    recording: rr.RecordingStream,
    entity: str,
    table: Table,
    column: str,
    name: str,
    colour: str,
    width: float = 1.5,
    scale: float = 1.0,
) -> None:
    """One column as a line; nothing where the table has no such column."""
    if column not in table:
        return
    _plot_values(recording, entity, table, scale * table[column], name, colour, width)


def _plot_band(
    recording: rr.RecordingStream, entity: str, table: Table, name: str, colour: str
) -> None:
    if "slip" not in table or "slip_sd" not in table:
        return
    for sign, edge in ((2.0, "upper"), (-2.0, "lower")):
        values = table["slip"] + sign * table["slip_sd"]
        label = f"{name} {sign:+.0f} sd"
        _plot_values(recording, f"{entity}/{edge}", table, values, label, colour + "66", 0.75)


def _plot_values(
    recording: rr.RecordingStream,
    entity: str,
    table: Table,
    values: Array,
    name: str,
    colour: str,
    width: float,
) -> None:
    known = np.isfinite(values)
    style = rr.SeriesLines(colors=[rgba(colour)], names=[name], widths=[width])
    recording.log(entity, style, static=True)
    stamps = times({"epoch_ns": table["epoch_ns"][known]})
    recording.send_columns(entity, stamps, rr.Scalars.columns(scalars=values[known]))
