"""Time series: truth, each estimate with its band, and what the sensors gave."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle

import numpy as np
import rerun as rr

from twin.report.palette import SEA, colours
from twin.scores.scores import moving
from twin.streams import WHEELS as WHEEL_NAMES
from twin.streams import Setup, Streams, Table
from twin.viz.paths import (
    ACCELERATION,
    ACTIONS,
    DEPTH,
    DRAFT,
    FIX,
    GYRO,
    LOADS,
    POWER,
    REWARD,
    SENSED_DEPTH,
    SENSED_SPEED,
    SIDESLIP,
    SLIP,
    SPEED,
    TRUTH_COLOUR,
    WHEELS,
)
from twin.viz.tools import Array, every, rgba, times

PLOT_RATE_HZ = 20.0
FOUR = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7")
"""Four wheels, or axes."""
MORE = (*FOUR, "#F0E442", "#D55E00", "#0072B2", "#999999")
"""Any number of curves, in turn."""
POWERS = {"engine": "engine", "slip_long": "slip", "rolling": "rolling", "drawbar": "drawbar"}


def plot_estimates(recording: rr.RecordingStream, estimates: Mapping[str, Table]) -> None:
    """Slip, speed and sideslip of each, the first and the last with their bands."""
    for name, colour in colours(estimates).items():
        rows = moving(every(estimates[name], PLOT_RATE_HZ))
        for entity, column, sd in (
            (SLIP, "slip", "slip_sd"),
            (SIDESLIP, "sideslip_m", "sideslip_sd_m"),
        ):
            _band(recording, f"{entity}/{name}", rows, (column, sd), name, colour)
            _plot(recording, f"{entity}/{name}", rows, column, name, colour)
        _plot(recording, f"{SPEED}/{name}", rows, "speed_mps", name, colour)


def plot_truth(recording: rr.RecordingStream, truth: Mapping[str, Array]) -> None:
    """What was; nothing where the table has no such column."""
    if not len(truth.get("epoch_ns", ())):
        return
    rows = every(dict(truth), PLOT_RATE_HZ)
    for entity, column in ((SLIP, "slip"), (SPEED, "speed_mps"), (SIDESLIP, "sideslip_m")):
        _plot(recording, f"{entity}/truth", rows, column, "truth", TRUTH_COLOUR, 2.5)
    _plot(recording, f"{SPEED}/wheels", rows, "wheel_speed_mps", "wheels (w R)", SEA)
    _plot(recording, f"{DRAFT}/truth", rows, "draft_n", "draft [kN]", TRUTH_COLOUR, scale=1e-3)
    _plot(recording, f"{DEPTH}/truth", rows, "depth_m", "depth [m]", TRUTH_COLOUR)
    for wheel, colour in zip(WHEEL_NAMES, FOUR, strict=True):
        _plot(recording, f"{WHEELS}/{wheel}", rows, f"slip_{wheel}", wheel, colour)
        _plot(recording, f"{LOADS}/{wheel}", rows, f"load_{wheel}_n", wheel, colour, scale=1e-3)
    for (key, name), colour in zip(POWERS.items(), FOUR, strict=True):
        _plot(recording, f"{POWER}/{name}", rows, f"power_{key}_w", name, colour, scale=1e-3)


def plot_control(recording: rr.RecordingStream, control: Mapping[str, Array]) -> None:
    """Actions in [-1, 1], and the terms of the reward, which are columns `reward_<term>`."""
    names = [name for name in control if name != "epoch_ns"]
    terms = [name for name in names if name.startswith("reward_")]
    for entity, chosen in ((ACTIONS, [n for n in names if n not in terms]), (REWARD, terms)):
        for column, colour in zip(chosen, cycle(MORE), strict=False):
            name = column.removeprefix("reward_")
            _plot(recording, f"{entity}/{name}", control, column, name, colour)


def plot_sensors(recording: rr.RecordingStream, streams: Streams, setup: Setup) -> None:
    """The streams as they came: speeds, fix, rates, accelerations, depth."""
    tables = {name: every(table, PLOT_RATE_HZ) for name, table in streams.tables.items()}
    gnss, imu, camera, depth = (tables.get(n, {}) for n in ("gnss", "imu", "camera", "depth"))
    if {"v_east_mps", "v_north_mps"} <= gnss.keys():
        gnss["speed"] = np.hypot(gnss["v_east_mps"], gnss["v_north_mps"])
    _plot(recording, f"{SENSED_SPEED}/gnss", gnss, "speed", "GNSS", FOUR[0])
    _plot(recording, f"{SENSED_SPEED}/camera", camera, "v_x_mps", "camera", FOUR[3])
    if "wheels" in tables:
        driven = _wheel_speed(tables["wheels"], setup)
        _plot(recording, f"{SENSED_SPEED}/wheels", driven, "speed", "driven wheels", FOUR[1])
    for column, name, colour in (
        ("quality", "quality: 4 fixed, 5 float, 1 single", FOUR[0]),
        ("satellites_main", "satellites", FOUR[1]),
    ):
        _plot(recording, f"{FIX}/{column}", gnss, column, name, colour)
    for axis, colour in zip("xyz", FOUR, strict=False):
        _plot(recording, f"{GYRO}/{axis}", imu, f"gyro_{axis}_radps", axis, colour)
        _plot(recording, f"{ACCELERATION}/{axis}", imu, f"accel_{axis}_mps2", axis, colour)
    if setup.depth is not None and {"laser_m", "inclination_rad"} <= depth.keys():
        depth["depth_m"] = setup.depth.zero_m - depth["laser_m"] * np.cos(depth["inclination_rad"])
    _plot(recording, f"{SENSED_DEPTH}/laser", depth, "depth_m", "depth [m]", FOUR[0])


def _wheel_speed(wheels: Table, setup: Setup) -> Table:
    """Mean speed of the driven wheels, given or from ticks and nominal radius."""
    speeds = []
    for wheel in setup.driven:
        if f"speed_{wheel}_mps" in wheels:
            speeds.append(wheels[f"speed_{wheel}_mps"])
        elif setup.wheels and setup.wheels.counts_per_turn and f"ticks_{wheel}" in wheels:
            metres = 2.0 * np.pi * setup.wheels.radius_m[wheel] / setup.wheels.counts_per_turn
            time = wheels["epoch_ns"] * 1e-9
            ticks = wheels[f"ticks_{wheel}"].astype(float)
            speeds.append(metres * np.gradient(ticks, time) if len(ticks) > 1 else 0.0 * ticks)
    if not speeds:
        return {}
    return {"epoch_ns": wheels["epoch_ns"], "speed": np.mean(speeds, axis=0)}


def _plot(
    recording: rr.RecordingStream,
    entity: str,
    table: Mapping[str, Array],
    column: str,
    name: str,
    colour: str,
    width: float = 1.5,
    scale: float = 1.0,
) -> None:
    """One column as a line; nothing where the table has no such column, or nothing in it."""
    if column not in table:
        return
    values = scale * table[column]
    known = np.isfinite(values)
    if not np.any(known):
        return
    style = rr.SeriesLines(colors=[rgba(colour)], names=[name], widths=[width])
    recording.log(entity, style, static=True)
    stamps = times({"epoch_ns": table["epoch_ns"][known]})
    recording.send_columns(entity, stamps, rr.Scalars.columns(scalars=values[known]))


def _band(
    recording: rr.RecordingStream,
    entity: str,
    table: Table,
    columns: tuple[str, str],
    name: str,
    colour: str,
) -> None:
    column, sd = columns
    if column not in table or sd not in table:
        return
    for sign, edge in ((2.0, "upper"), (-2.0, "lower")):
        values = table[column] + sign * table[sd]
        rows = {"epoch_ns": table["epoch_ns"], "edge": values}
        _plot(recording, f"{entity}/{edge}", rows, "edge", f"{name} ±2 sd", colour + "66", 0.75)
