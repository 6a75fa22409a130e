"""`twin.calibrate`: the machine and the soil that explain a log, and what it cannot tell."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.calibration import drive_fit, gears, verdicts
from twin.calibration.fitting import Fit, Remember
from twin.calibration.held_out import Score
from twin.calibration.seconds import seconds
from twin.calibration.steady_fit import PARAMETERS, fitted_to, misfit_said, parted, prior_of
from twin.calibration.steady_rows import SteadyRows, steady_rows
from twin.errors import BadInput, OutOfRange
from twin.scenario import Soil
from twin.streams import Setup, Table
from twin.vehicle import Machine, files
from twin.vehicle.numerics import machine_facts

if TYPE_CHECKING:
    from twin.logs import Log, Reader

Array = NDArray[np.float64]

FIT_PART, HELD_PART = (0.0, 2.0 / 3.0), (2.0 / 3.0, 1.0)
"""Shares of a log's steady work, by time, that are fitted and that are held out."""
RATIOS = (0.6, 1.25)
"""Ground over wheel speed of a tractor at work; slip of 40 % at most."""
OVER_NO_LOAD = 1.15
"""No engine turns faster, over its no-load speed."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """What a log tells of a machine and a soil."""

    machine: Machine
    """With the values that were found."""
    soil: Soil
    parameters: tuple[verdicts.Found, ...]
    together: tuple[verdicts.Together, ...]
    """What it tells only of two together."""
    gears: tuple[gears.Gear, ...]
    lag_s: float
    """How late the receiver's speed is; NaN where the log does not tell."""
    holdout: Score
    fit: Fit
    notes: tuple[str, ...]


def calibrate(
    log: str | Path | Iterable[str | Path],
    column_map: str | Path | None = None,
    machine: str = "taishan_1404a",
    reader: str | Reader | None = None,
    *,
    parameters: Sequence[str] = (),
    soil: str = "tilled",
    fit_part: tuple[float, float] = FIT_PART,
    held_part: tuple[float, float] = HELD_PART,
    all_wheel_drive: bool | None = None,
    seed: int = 0,
    starts: int = 3,
    nthread: int = 2,
    remember: Remember = lambda key, find: find(),
    told: Callable[[str], None] = lambda what: None,
) -> Calibration:
    """Find the machine and the soil that explain a log.

    A log of counts, axle torque and depth is explained by the machine itself, which is driven in
    the same way (`twin.calibration.rollouts`). Rows of steady work in the log of a tractor's bus
    are explained by the steady state of the laws it runs on (`twin.calibration.steady`). A part of
    the log is never fitted: its slip is foretold, and scored beside a constant and a straight line.

    Args:
        log: a run folder, a table, NMEA, CAN, UBX, a bag, or what `reader` reads; or several files.
        column_map: TOML that says which column is what, and in which unit.
        machine: a name of `twin list`, or a file: what is believed before the log.
        reader: what reads the log, or its name.
        parameters: what is fitted, by default all that such a log may tell of; the rest keeps the
            machine's and the soil's values.
        soil: the preset that is believed before the log.
        fit_part, held_part: shares of the log's steady work, in the order of time, from and to; a
            log along which the machine is driven has its last quarter held out.
        all_wheel_drive: whether the front wheels drove; None for what their counts say, or without
            counts for what the machine has.
        seed: of the random starts, and of the draws of blocks.
        starts: how many searches begin, the first at the prior.
        nthread: threads that drive the machine.
        remember: keeps what was found before the process was killed.
        told: called with what is being done.

    Raises:
        BadInput: the log or the map cannot be used, or the log tells too little; says what is
            missing.
        UnknownName: there is no such machine, soil or parameter.

    Example:
        >>> twin.calibrate("field.csv", "field.toml", "my.toml").holdout.verdict  # doctest: +SKIP
    """
    from twin import logs

    for name, (first, last) in (("fit_part", fit_part), ("held_part", held_part)):
        if not 0.0 <= first < last <= 1.0:
            raise OutOfRange(name, f"{first:g}:{last:g}", "two shares that rise, in [0, 1]")
    if fit_part[0] < held_part[1] and held_part[0] < fit_part[1]:
        raise BadInput(
            f"held_part = {held_part[0]:g}:{held_part[1]:g} overlaps fit_part = "
            f"{fit_part[0]:g}:{fit_part[1]:g}; what is held out is never fitted"
        )
    given, ground = files.machine(machine), Soil(preset=soil)
    by = logs.reader(reader) if isinstance(reader, str) else reader
    paths = [Path(log)] if isinstance(log, str | Path) else [Path(each) for each in log]
    read = logs.read(paths, None if column_map is None else Path(column_map), by)
    told("reading what the log says")
    lag_s = _lag_s(read)  # which steady rows do not feel
    table = seconds(read)
    told("fitting")
    if drive_fit.can(table):
        whole = drive_fit.fitted_to(
            given, ground, parameters or drive_fit.PARAMETERS, read, table, seed=seed,
            all_wheel_drive=all_wheel_drive, starts=starts, nthread=nthread, remember=remember,
        )  # fmt: skip
        found, score = whole.fit, whole.score
    else:
        prior = prior_of(given, ground, parameters or PARAMETERS)
        rows = steady_rows(read, table, _torque(table))
        _check_machine(given, rows)
        driven = given.drive.driven == "all" if all_wheel_drive is None else all_wheel_drive
        found, score = fitted_to(
            given, ground, prior, parted(rows, fit_part, held_part), all_wheel_drive=driven,
            seed=seed, starts=starts, remember=remember,
        )  # fmt: skip
    from twin.calibration.applied import machine_with, soil_with

    said = [misfit_said(found), *(_bound_said(f) for f in verdicts.found(found))]
    return Calibration(
        machine=machine_with(given, found.values), soil=soil_with(ground, found.values),
        parameters=verdicts.found(found), together=tuple(verdicts.together(found)),
        gears=tuple(_gears(given, table, read.setup)), lag_s=lag_s, holdout=score, fit=found,
        notes=tuple(note for note in said if note is not None),
    )  # fmt: skip


def _bound_said(found: verdicts.Found) -> str | None:
    if not found.at_bound:
        return None
    return f"{found.name} has hit its bound at {found.value:.4g}: the log asks for more than it may"


def _lag_s(log: Log) -> float:
    from twin.pipeline.log_check import log_lag

    try:
        return log_lag(log).lag_s
    except BadInput:  # without wheels or GNSS, which `seconds` refuses with what would do
        return math.nan


def _torque(rows: Table) -> Array:
    """Engine torque over its reference, of each second."""
    for name in ("engine_torque", "engine_load"):
        if name in rows and np.isfinite(rows[name]).any():
            return np.asarray(rows[name], np.float64)
    raise BadInput("the log has no engine torque; map [machine] engine_torque, or engine_load")


def _check_machine(machine: Machine, rows: SteadyRows) -> None:
    """Refuse a log that another machine, or a wrong unit, has written."""
    ratio = float(np.nanmedian(rows.ratio)) if np.isfinite(rows.ratio).any() else math.nan
    if math.isnan(ratio):
        raise BadInput("the log has no ground speed in steady work; a receiver that measures there "
                       "would do")  # fmt: skip
    if not RATIOS[0] <= ratio <= RATIOS[1]:
        raise BadInput(
            f"ground speed is {ratio:.2f} of wheel speed in steady work, outside "
            f"[{RATIOS[0]:g}, {RATIOS[1]:g}]: another machine's map, or a wrong unit"
        )
    most_rpm = float(np.nanmax(rows.engine_radps)) * 30.0 / math.pi
    no_load_rpm = machine_facts(machine).numbers["engine.no_load_rpm"]
    if most_rpm > OVER_NO_LOAD * no_load_rpm:
        raise BadInput(
            f"the engine turns at {most_rpm:.0f} rpm, and {machine.name}'s no faster than "
            f"{no_load_rpm:.0f}; "
            "the file of the machine that was driven would do"
        )


def _gears(machine: Machine, rows: Table, setup: Setup) -> list[gears.Gear]:
    """The gears that were driven, by the machine's radius."""
    facts = machine_facts(machine)
    radius_m = facts.numbers["tyre_rear.free_rolling_radius_m"]
    wheel, engine = rows["wheel_speed_mps"], rows["engine_radps"]
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where((wheel > 0.7) & (engine > 50.0), engine * radius_m / wheel, np.nan)
    rated_radps = facts.numbers["engine.rated_rpm"] * math.pi / 30.0
    return gears.found(ratio, facts.ratios, rated_radps * radius_m * 3.6)
