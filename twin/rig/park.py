"""The parking rig: brakes on, on slopes; how far the tractor creeps."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.errors import BadInput, check_range
from twin.machine.start import RAISED_RAD
from twin.rig.defaults import PARKED_S
from twin.rig.table import Measured
from twin.rig.tractor import tractor
from twin.scenario import Field, Soil
from twin.simulation.guard import Diverged, warning_text
from twin.vehicle import files

Array = NDArray[np.float64]

SETTLE_S = 5.0
"""Time in which the tyres wind up before creep is counted [s]."""
LOOKS = 60
"""Number of instants at which the place is read."""


@dataclass(frozen=True, kw_only=True)
class Creep(Measured):
    """Creep of the parked tractor, one value per slope. Shape (n,)."""

    cross_slope_deg: Array
    grade_deg: Array
    creep_m: Array
    """Farthest that the rear-axle centre went from where it had settled."""
    creep_rate_mps: Array
    """Mean speed over the last third."""


def park(
    soil: Soil,
    *,
    cross_slope_deg: ArrayLike = 0.0,
    grade_deg: ArrayLike = 0.0,
    parked_s: float = PARKED_S,
    machine: str = files.USUAL,
) -> Creep:
    """Park the tractor, brakes on, clutch disengaged, on each slope; the arguments broadcast.

    Args:
        soil: the soil, the same everywhere.
        cross_slope_deg: slopes across the tractor, rising to the left [deg].
        grade_deg: slopes along it, rising ahead [deg].
        parked_s: time over which the creep is measured [s].
        machine: a name of `twin list`, or a file.

    Raises:
        OutOfRange: a slope beyond what a scenario may have, or a time outside 1 to 3600 s.
        BadInput: no slope is given, or the numbers of slopes differ.
        UnknownName: there is no such machine.
        Diverged: MuJoCo warned.
    """
    check_range("parked_s", parked_s, 1.0, 3600.0)
    try:
        cross, grade = np.broadcast_arrays(
            np.atleast_1d(np.asarray(cross_slope_deg, dtype=np.float64)),
            np.atleast_1d(np.asarray(grade_deg, dtype=np.float64)),
        )
    except ValueError:
        raise BadInput("cross_slope_deg and grade_deg have different lengths") from None
    if not cross.size:
        raise BadInput("the rig has no slopes; give at least one [deg]")
    shapes = [
        Field(cross_slope_deg=float(c), grade_deg=float(g))
        for c, g in zip(cross, grade, strict=True)
    ]
    measured = np.array([_parked(soil, shape, parked_s, machine) for shape in shapes])
    return Creep(
        cross_slope_deg=np.array(cross),
        grade_deg=np.array(grade),
        creep_m=measured[:, 0],
        creep_rate_mps=measured[:, 1],
    )


def _parked(soil: Soil, shape: Field, parked_s: float, name: str) -> tuple[float, float]:
    """Farthest excursion, and mean speed over the last third."""
    machine = tractor("rig-park", soil, shape, machine=name)
    model, state = machine.model, mujoco.MjData(machine.model)
    state.qpos[:], state.act[:] = machine.start_qpos, machine.start_act
    for control, value in (("brake", 1.0), ("clutch_pedal", 1.0), ("lift", RAISED_RAD)):
        if control != "lift" or machine.hitch is not None:
            state.ctrl[model.actuator(control).id] = value
    mujoco.mj_step(model, state, round(SETTLE_S / model.opt.timestep))
    places = [np.array(state.qpos[:3])]
    look_s = parked_s / LOOKS
    for _ in range(LOOKS):
        mujoco.mj_step(model, state, max(1, round(look_s / model.opt.timestep)))
        places.append(np.array(state.qpos[:3]))
    warned = [k for k, warning in enumerate(state.warning) if warning.number]
    if warned:
        raise Diverged(f"{warning_text(warned[0])} after {parked_s:.2f} s of 'rig-park'")
    gone = np.linalg.norm(np.array(places) - places[0], axis=1)
    third = LOOKS // 3
    late = float(np.linalg.norm(places[-1] - places[-1 - third]))
    return float(gone.max()), late / (third * look_s)
