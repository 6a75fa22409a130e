"""What is to be calibrated, and what both forward models ask of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.lag import Lag
from twin.calibration import gears as found_gears
from twin.calibration.applied import believed, can_fit, machine_with, reads, soil_with
from twin.calibration.fitting import Fit, Prior
from twin.calibration.gears import Gear
from twin.calibration.holdout import Holdout
from twin.calibration.kept import Memory
from twin.calibration.known import known
from twin.calibration.posterior import Posterior
from twin.calibration.result import Calibration
from twin.calibration.verdicts import far_notes, misfit_note, together, told
from twin.errors import BadInput
from twin.logs import Log
from twin.scenario import Soil
from twin.streams import Table
from twin.vehicle import Machine
from twin.vehicle.derive import GRAVITY_MPS2, RPM
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

HELD_SHARE = 0.25
"""Share of the work, its last, that is held back where nobody says what is."""
CARRIED_SHARE = 0.2
"""Load that an implement puts on its tractor, over the tractor's mass, before the log."""
REFERENCE_OVER_PEAK = 1.02
"""Reference torque of a bus over the engine's peak torque (SPN 544), assumed."""
RADII = (0.885, 0.995)
"""A free rolling radius over half of the tyre's diameter."""


@dataclass(frozen=True)
class Task:
    """A log, what is believed before it, and how it is fitted."""

    name: str
    log: Log
    rows: Table
    machine: Machine
    implement: str | None
    soil: Soil
    parameters: Sequence[str] | None
    lag: Lag
    hold_out_s: tuple[float, float] | None
    seed: int
    starts: int
    jobs: int
    memory: Memory
    told: Callable[[str], None]
    own: bool
    """Whether the log is a run folder, whose engine load is torque over a reference."""


def torque_of(task: Task) -> tuple[Array, float, float, bool]:
    """Torque over its reference, the reference, its prior sd, and whether it is the axle's."""
    rows, machine = task.rows, task.machine
    numbers = machine_facts(machine).numbers
    peak_nm = peak_torque_nm(machine)
    if "engine_torque" in rows:
        return rows["engine_torque"], REFERENCE_OVER_PEAK * peak_nm, 0.15, False
    if "engine_load" not in rows:
        raise BadInput("the log has no engine torque; map [machine] engine_torque (SPN 513) or "
                       "engine_load (SPN 92)")  # fmt: skip
    load = rows["engine_load"]
    if task.own:
        return load, peak_nm, 0.3, False
    rpm = rows["engine_radps"] / RPM
    rated, at = numbers["engine.rated_rpm"], numbers["engine.peak_rpm"]
    full = (
        peak_nm - (peak_nm - numbers["engine.rated_torque_nm"]) * ((rpm - at) / (rated - at)) ** 2
    )
    most = numbers["engine.max_power_w"] / np.maximum(rpm * RPM, 1.0)
    return load * np.clip(np.minimum(full, most), 0.0, None) / peak_nm, peak_nm, 0.15, False


def peak_torque_nm(machine: Machine) -> float:
    """The engine's greatest torque."""
    numbers = machine_facts(machine).numbers
    return numbers["engine.rated_torque_nm"] * numbers["engine.torque_rise"]


def gears_of(task: Task) -> tuple[list[Gear], Array, bool]:
    """Gears, engine turns per turn of the rear axle in each second, and whether radii are known."""
    rows, setup = task.rows, task.log.setup
    facts = machine_facts(task.machine)
    turned = setup.wheels is not None and setup.wheels.counts_per_turn is not None
    radius_m = facts.numbers["tyre_rear.free_rolling_radius_m"]
    if turned and setup.wheels is not None:
        radius_m = setup.wheels.radius_m["rl"]
    driven = (rows["wheel_speed_mps"] > 0.5) & (rows["engine_radps"] > 600.0 * RPM)
    ratio = np.where(driven, rows["engine_radps"] * radius_m
                     / np.maximum(rows["wheel_speed_mps"], 0.1), np.nan)  # fmt: skip
    kmh = 3.6 * facts.numbers["engine.rated_rpm"] * RPM * radius_m
    return found_gears.found(ratio, facts.ratios, kmh), ratio, turned


def prior_of(task: Task, names: Sequence[str], own: Mapping[str, tuple[float, float]]) -> Prior:
    """What is believed of the parameters; `own` are values and sd that the log itself gives."""
    mean, sd, grades = [], [], []
    for name in names:
        value, spread, grade = (
            (*own[name], "the log") if name in own
            else believed(task.machine, task.soil, name)
        )  # fmt: skip
        mean.append(math.log(value))
        sd.append(spread)
        grades.append(grade)
    low, high = bounds(task.machine, names)
    mean = [min(max(m, a), b) if n.startswith("log.set_rpm") else m
            for n, m, a, b in zip(names, mean, low, high, strict=True)]  # fmt: skip
    return Prior(tuple(names), np.array(mean), np.array(sd), low, high, tuple(grades))


def bounds(machine: Machine, names: Sequence[str]) -> tuple[Array, Array]:
    """Logarithms of the least and the greatest value of each parameter."""
    low, high = (np.log([getattr(known(n), end) for n in names]) for end in ("low", "high"))
    facts = machine_facts(machine).numbers
    for i, name in enumerate(names):
        if name.startswith("log.set_rpm"):
            low[i] = math.log(max(300.0, 1.13 * facts["engine.idle_rpm"]))
            high[i] = math.log(0.985 * facts["engine.no_load_rpm"])
        if name.endswith("free_rolling_radius_m"):  # a file with another would be refused
            axle = name.partition(".")[0]
            radius_m = 0.5 * facts[f"tyre_{axle}.diameter_m"]
            low[i], high[i] = np.log(np.array(RADII) * radius_m)
        if name == "engine.no_load_rpm":
            low[i] = math.log(max(1.002 * facts["engine.rated_rpm"],
                                  0.99 * facts["engine.no_load_rpm"]))  # fmt: skip
    return low, high


def fitted_names(task: Task, usual: Sequence[str], absent: Iterable[str]) -> tuple[str, ...]:
    """What is fitted: what was asked for and can be, or what the log has."""
    left_out = set(absent)
    names = [
        n for n in usual if n not in left_out and can_fit(task.machine, n) and reads(task.soil, n)
    ]
    if task.parameters is None:
        return tuple(names)
    refused = [n for n in task.parameters if n not in usual or not reads(task.soil, n)]
    if refused:
        raise BadInput(f"{refused[0]} cannot be told from this kind of log under the soil law "
                       f"{task.soil.law}; there are: "
                       f"{', '.join(names)}")  # fmt: skip
    needed = [n for n in names if n.startswith("log.")]
    return tuple(dict.fromkeys([*task.parameters, *needed]))


def held_back(task: Task, time_s: Array) -> NDArray[np.bool_]:
    """Which times of steady work are held back."""
    if task.hold_out_s is not None:
        first, last = task.hold_out_s
        return np.asarray((time_s >= first) & (time_s <= last))
    return np.asarray(time_s >= np.quantile(time_s, 1.0 - HELD_SHARE))


def mass_kg(machine: Machine) -> float:
    """Of the file, or of what the tyres of a hand-made MJCF carry."""
    return machine.mass_kg or 2.0 * sum(
        machine_facts(machine).numbers[f"tyre_{a}.nominal_load_n"] for a in ("front", "rear")
    ) / GRAVITY_MPS2  # fmt: skip


def result_of(
    task: Task, result: Fit, gears: Sequence[Gear], channels: Sequence[str], measured: Array,
    time_s: Array, holdout: Holdout | None, rule: str, notes: Sequence[str] = (),
) -> Calibration:  # fmt: skip
    """The calibration of a fit, with what is to be noted of it."""
    values = result.values
    found = told(result)
    noted = [*notes, *([said] if (said := misfit_note(result)) else [])]
    noted += far_notes(result)
    noted += [f"{p.name} is at its bound, {p.value:.4g} {p.unit}: the log asks for more than is "
              "allowed" for p in found if p.at_bound]  # fmt: skip
    away = np.abs(result.starts - result.u).max(axis=1) / np.sqrt(np.diag(result.cov)).max()
    if len(away) > 1 and away.max() > 1.0:
        noted.append("starts end in different places; the best of them is kept")
    return Calibration(
        name=task.name, machine=machine_with(task.machine, values),
        soil=soil_with(task.soil, values), parameters=tuple(found),
        posterior=Posterior(result.prior.names, result.u, result.cov),
        together=tuple(together(result)), gears=tuple(gears), lag=task.lag, fit=result,
        channels=tuple(channels), time_s=time_s,
        foretold=measured - result.residual, holdout=holdout, rule=rule,
        notes=(*task.log.notes, *noted),
    )  # fmt: skip
