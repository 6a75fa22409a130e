"""A log and a machine's file to the machine and the soil that explain the log."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from twin import logs
from twin.calibration.applied import can_fit
from twin.calibration.by_rollouts import by_rollouts
from twin.calibration.by_rows import by_rows
from twin.calibration.kept import Memory
from twin.calibration.known import KNOWN
from twin.calibration.result import Calibration
from twin.calibration.seconds import seconds, with_speeds
from twin.calibration.task import Task
from twin.errors import BadInput, UnknownName
from twin.pipeline.log_check import log_lag
from twin.scenario import Soil
from twin.streams import Table
from twin.vehicle import Machine, files
from twin.vehicle.derive import RPM
from twin.vehicle.numerics import machine_facts

DRIVING_MPS = 0.7
RATIOS = (0.6, 1.25)
"""Ground over wheel speed while driving: slip of 40 % at most, and a radius that is off."""
OVER_NO_LOAD = 1.15
"""No engine turns faster than so many times its no-load speed."""
FAST_S = 0.3
"""Wheels that are sampled more slowly belong to a log that is fitted in steady rows [s]."""


def calibrate(
    log: str | Path | Iterable[str | Path],
    column_map: str | Path | None = None,
    *,
    machine: str | Machine,
    parameters: Sequence[str] | None = None,
    hold_out_s: tuple[float, float] | None = None,
    implement: str | None = None,
    soil: Soil | None = None,
    seed: int = 0,
    starts: int = 3,
    jobs: int = 1,
    resume: Path | None = None,
    told: Callable[[str], None] = lambda what: None,
) -> Calibration:
    """Find the machine and the soil that explain a recorded drive.

    Args:
        log: as `twin.estimate` takes it; or a TOML file with points of a dynamometer at the
            PTO (`twin.calibration.by_points`).
        column_map: TOML that says which column is what.
        machine: a name, a file, or what a file holds; its numbers and grades are the prior.
        parameters: names of what is fitted; None for all that the log can determine.
        hold_out_s: first and last second of the log that are not fitted; None for the last quarter
            of the work.
        implement: the implement; None for the machine's usual one.
        soil: prior of the soil; None for a tilled field.
        seed: of the random starts.
        starts: how many there are.
        jobs: threads.
        resume: file that keeps what is found, so that a killed calibration goes on.
        told: called with the name of each step.

    Raises:
        BadInput: the log cannot be fitted; says what is missing.
        UnknownName: there is no such parameter.

    Example:
        >>> twin.calibrate("field.csv", "field.toml", machine="my.toml")  # doctest: +SKIP
    """
    for name in parameters or ():
        if name not in KNOWN:
            raise UnknownName("parameter", name, KNOWN)
    paths = [Path(log)] if isinstance(log, str | Path) else [Path(each) for each in log]
    known_machine = files.machine(machine) if isinstance(machine, str) else machine
    for name in parameters or ():
        if not can_fit(known_machine, name):
            raise BadInput(f"{name} cannot be fitted to {known_machine.name}, whose MJCF is made "
                           "by hand; another parameter would do")  # fmt: skip
    if len(paths) == 1 and paths[0].suffix == ".toml":
        from twin.calibration.by_points import by_points, read_points

        return by_points(read_points(paths[0]), known_machine, paths[0].name, told)
    told("reading")
    read = logs.read(paths, None if column_map is None else Path(column_map))
    rows = seconds(read)
    lag = log_lag(replace(read, streams=with_speeds(read.streams, read.setup)), seed=seed)
    key = hashlib.sha256(
        repr((paths, [p.stat().st_mtime_ns for p in paths], column_map, known_machine, parameters,
              hold_out_s, implement, soil, seed, starts)).encode()
    ).hexdigest()  # fmt: skip
    task = Task(
        name=" + ".join(p.name for p in paths), log=read, rows=rows, machine=known_machine,
        implement=implement, soil=soil or Soil(preset="tilled"), parameters=parameters, lag=lag,
        hold_out_s=hold_out_s, seed=seed, starts=starts, jobs=jobs, memory=Memory(resume, key),
        told=told, own=paths[0].is_dir(),
    )  # fmt: skip
    _refuse_without_engine(rows)
    _refuse_other_machine(known_machine, rows)
    step_s = float(np.median(np.diff(read.streams["wheels"]["epoch_ns"]))) * 1e-9
    found = by_rollouts(task) if step_s < FAST_S else by_rows(task)
    task.memory.forget()
    return found


def _refuse_without_engine(rows: Table) -> None:
    if "engine_radps" not in rows:
        raise BadInput("the log has no engine speed, by which gears are found; map [machine] "
                       "engine_speed")  # fmt: skip


def _refuse_other_machine(machine: Machine, rows: Table) -> None:
    """Refuse speeds that another machine, or another unit, has written."""
    ground, wheel = rows["speed_mps"], rows["wheel_speed_mps"]
    with np.errstate(invalid="ignore"):
        driving = (wheel > DRIVING_MPS) & np.isfinite(ground)
    ratio = float(np.median(ground[driving] / wheel[driving])) if driving.any() else math.nan
    if not RATIOS[0] <= ratio <= RATIOS[1]:
        raise BadInput(
            f"ground speed is {ratio:.2f} of wheel speed while driving, outside [{RATIOS[0]:g}, "
            f"{RATIOS[1]:g}]: another machine's map, or another unit; a map of this log would do"
        )
    fastest_rpm = float(np.nanquantile(rows["engine_radps"], 0.999)) / RPM
    most_rpm = OVER_NO_LOAD * machine_facts(machine).numbers["engine.no_load_rpm"]
    if fastest_rpm > most_rpm:
        raise BadInput(
            f"the engine turns at {fastest_rpm:.0f} rpm, and that of {machine.name} no faster than "
            f"{most_rpm:.0f}; the file of the machine that was driven would do"
        )
