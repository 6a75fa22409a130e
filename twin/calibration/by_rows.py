"""A calibration of a slow log: rows of steady work, and the laws' steady state."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.zero_slip import zero_slip_scale
from twin.calibration.fitting import Fit, beside, fit
from twin.calibration.gears import Gear
from twin.calibration.holdout import held_out
from twin.calibration.known import known
from twin.calibration.result import Calibration
from twin.calibration.steady import Steady
from twin.calibration.steady_rows import RULE as ROW_RULE
from twin.calibration.steady_rows import steady_rows
from twin.calibration.task import (
    CARRIED_SHARE,
    Task,
    fitted_names,
    gears_of,
    held_back,
    mass_kg,
    prior_of,
    result_of,
    torque_of,
)
from twin.errors import BadInput

Array = NDArray[np.float64]

STEADY_NAMES = (
    "soil.cone_index_kpa", "soil.k_phi_kn_per_m_n2", "soil.shear_modulus_m", "soil.friction",
    "transmission.efficiency", "engine.parasitic_nm",
    "engine.fuel_l_per_kwh", "log.reference_torque_nm", "log.wheel_scale", "log.carried_kg",
)  # fmt: skip
"""Parameters that such a log may determine."""
SCALES = (0.93, 1.07)
"""A scale of the wheels beyond these says that the map is another machine's."""
LEAST_SCALE_SD, EMPTY_ROWS, EMPTY_MPS = 0.015, 20, 1.0
"""Least prior sd of the wheels' scale; seconds of driving empty that it needs, faster than this."""


def by_rows(task: Task) -> Calibration:
    """A long log: steady rows.

    Raises:
        BadInput: the log cannot be fitted.
    """
    torque, reference_nm, spread, of_axle = torque_of(task)
    gears, _, _ = gears_of(task)
    found = steady_rows(task.log, task.rows, torque)
    held = held_back(task, found.time_s)
    fitted, back = found.chosen(~held & np.isfinite(found.ratio)), found.chosen(held)
    if len(fitted) < 12 or not len(back):
        raise BadInput(
            f"{len(fitted)} rows of steady work are left to fit and {len(back)} to check; at least "
            "12 and 1 would do: hold back less, or drive longer"
        )
    time_s = (task.rows["epoch_ns"] - task.rows["epoch_ns"][0]) * 1e-9
    second_held = held_back(task, time_s) if task.hold_out_s else (
        time_s >= back.time_s.min())  # fmt: skip
    own = {"log.reference_torque_nm": (reference_nm, spread),
           "log.wheel_scale": _wheel_scale(task, ~second_held),
           "log.carried_kg": (CARRIED_SHARE * mass_kg(task.machine),
                              known("log.carried_kg").spread)}  # fmt: skip
    no_fuel = not np.isfinite(fitted.fuel_lph).mean() > 0.9
    names = fitted_names(task, STEADY_NAMES, ["engine.fuel_l_per_kwh"] if no_fuel else [])
    all_wheels = task.machine.mjcf is None and task.machine.drive.driven == "all"
    model = Steady(task.machine, task.soil, names, fitted, all_wheels, of_axle)
    result = fit(model, prior_of(task, names, own), seed=task.seed, starts=task.starts,
                 told=task.told, remember=task.memory)  # fmt: skip
    _refuse_unlikely(result, gears)
    ahead = Steady(task.machine, task.soil, names, back, all_wheels, of_axle)
    ratios = ahead.foretold(np.exp(beside(result.u)))[:, :, 0]
    holdout = held_out(back, fitted, ratios, result.cov, float(result.noise.sd()[0, 0]),
                       result.values.get("log.wheel_scale", 1.0), task.seed)  # fmt: skip
    return result_of(task, result, gears, model.channels, model.measured, model.time_s,
                        holdout, ROW_RULE)  # fmt: skip


def _wheel_scale(task: Task, fitted: NDArray[np.bool_]) -> tuple[float, float]:
    """Zero-slip scale before the fit, from driving empty: ground speed moved by its lag."""
    from twin.calibration.steady_rows import doing

    rows = task.rows
    time_s = (rows["epoch_ns"] - rows["epoch_ns"][0]) * 1e-9
    lag_s = task.lag.lag_s if math.isfinite(task.lag.lag_s) else 0.0
    ground = np.interp(time_s + lag_s, time_s, rows["speed_mps"])
    empty = doing(task.log, rows)[1] & fitted & (rows["wheel_speed_mps"] > EMPTY_MPS)
    steady = np.abs(np.gradient(rows["wheel_speed_mps"])) < 0.15
    scale = zero_slip_scale(ground, rows["wheel_speed_mps"], empty & steady, seed=task.seed)
    if scale.n < EMPTY_ROWS:
        return 1.0, known("log.wheel_scale").spread
    return scale.scale, max(LEAST_SCALE_SD, (scale.high - scale.low) / 3.92)


def _refuse_unlikely(result: Fit, gears: Sequence[Gear]) -> None:
    """Refuse a fit that only another machine's log, or another unit, would give."""
    scale = result.values.get("log.wheel_scale", 1.0)
    if not SCALES[0] <= scale <= SCALES[1]:
        raise BadInput(
            f"the wheels' true speed would be {scale:.2f} times the logged one: another machine's "
            "map, or another unit; a map of this log would do"
        )
    if not gears:
        raise BadInput(
            "no gear is found: engine and wheel speed keep no ratio; are both of this machine, and "
            "in the units of the map?"
        )
