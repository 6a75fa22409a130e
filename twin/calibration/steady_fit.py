"""A calibration of a log of a bus: rows of steady work, and the laws' steady state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.calibration.applied import believed
from twin.calibration.fitting import Fit, Prior, Remember, fit
from twin.calibration.held_out import Score, scored
from twin.calibration.known import KNOWN
from twin.calibration.steady import Steady
from twin.calibration.steady_rows import SteadyRows
from twin.errors import BadInput, UnknownName
from twin.scenario import Soil
from twin.vehicle import Machine
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

PARAMETERS = (
    "soil.cone_index_kpa", "soil.friction", "transmission.efficiency", "engine.parasitic_nm",
    "engine.fuel_l_per_kwh", "log.reference_torque_nm", "log.wheel_scale", "log.carried_kg",
)  # fmt: skip
"""What such a log may tell of."""
REFERENCE = 1.02
"""Reference torque of a bus over the engine's greatest; SPN 544 is a little above it, assumed."""
REFERENCE_SPREAD = 0.15
CARRIED = 0.2
"""What a mounted implement puts on the tractor over the tractor's mass; assumed."""
FEWEST = 12
"""Rows of work with a ground speed, fitted and held out."""


@dataclass(frozen=True)
class Part:
    """Rows of a part of the log."""

    fitted: SteadyRows
    held: SteadyRows


def parted(rows: SteadyRows, fit_part: tuple[float, float], held_part: tuple[float, float]) -> Part:
    """The rows of steady work that are fitted, and those that are held out.

    Driving empty is left out: it is on roads and headlands, whose soil is another.

    Args:
        rows: of steady driving.
        fit_part, held_part: from which share of the steady work to which, in the order of time.

    Raises:
        BadInput: too few rows in one of them.
    """
    known = np.isfinite(rows.ratio) & rows.working
    worked_s = rows.time_s[rows.working]
    share = np.searchsorted(worked_s, rows.time_s) / len(worked_s)
    fitted = known & (share >= fit_part[0]) & (share < fit_part[1])
    held = known & (share >= held_part[0]) & (share < held_part[1])
    for name, mask in (("fitted", fitted), ("held out", held)):
        if mask.sum() < FEWEST:
            raise BadInput(
                f"{int(mask.sum())} rows of steady work with a ground speed are to be {name}; "
                f"{FEWEST} would do: a longer log, or other parts"
            )
    return Part(rows.chosen(fitted), rows.chosen(held))


def prior_of(machine: Machine, soil: Soil, names: Sequence[str]) -> Prior:
    """What is believed of parameters before the log.

    Raises:
        UnknownName: a parameter such a log tells nothing of.
    """
    for name in names:
        if name not in PARAMETERS:
            raise UnknownName("parameter of a log without controls", name, PARAMETERS)
    beliefs = [_belief(machine, soil, name) for name in names]
    value, spread, grades = zip(*beliefs, strict=True)
    return Prior(
        names=tuple(names), mean=np.log(value), sd=np.array(spread),
        low=np.log([KNOWN[n].low for n in names]), high=np.log([KNOWN[n].high for n in names]),
        grades=grades,
    )  # fmt: skip


def _belief(machine: Machine, soil: Soil, name: str) -> tuple[float, float, str]:
    numbers = machine_facts(machine).numbers
    if name == "log.reference_torque_nm":
        most_nm = numbers["engine.rated_torque_nm"] * numbers["engine.torque_rise"]
        return REFERENCE * most_nm, REFERENCE_SPREAD, "assumed"
    if name == "log.wheel_scale":
        return 1.0, KNOWN[name].spread, "assumed"
    if name == "log.carried_kg":
        front_n, rear_n = (numbers[f"tyre_{a}.nominal_load_n"] for a in ("front", "rear"))
        return CARRIED * 2.0 * (front_n + rear_n) / 9.81, KNOWN[name].spread, "assumed"
    return believed(machine, soil, name)


def fitted_to(
    machine: Machine, soil: Soil, prior: Prior, part: Part, *, all_wheel_drive: bool, seed: int,
    starts: int, remember: Remember,
) -> tuple[Fit, Score]:  # fmt: skip
    """The fit, and how it foretells the held-out rows."""
    model = Steady(machine, soil, prior.names, part.fitted, all_wheel_drive)
    if "log.reference_torque_nm" not in prior.names:
        raise BadInput("log.reference_torque_nm has to be among the parameters; add it")
    found = fit(model, prior, seed=seed, starts=starts, remember=remember)
    return found, scored(model, found, part.fitted, part.held, seed)


def misfit_said(found: Fit) -> str | None:
    """That the model leaves more than noise, if it does."""
    if found.misfit < 1.3 or math.isnan(found.misfit):
        return None
    return (
        f"the model leaves {found.misfit:.1f} times the noise that the log's rows have among "
        "themselves: intervals are widened by it"
    )
