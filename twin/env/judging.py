"""What a control step of some tractors was worth, written beside what was true."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law
from twin.env import reward
from twin.env.quantities import PLACE, TRUE, Ids
from twin.machine.fuel import engine_fuel_lph
from twin.simulation.records import Records

Array = NDArray[np.float64]

FIRST = len(TRUE)
SLIP, SPEED, DEPTH, RADPS, ENGINE_NM, EFFICIENCY = (
    PLACE[name]
    for name in (
        "slip", "speed_mps", "depth_m", "engine_radps", "engine_torque_nm", "traction_efficiency",
    )
)  # fmt: skip
SLIP_RL, SLIP_RR, V_Y = (PLACE[name] for name in ("slip_rl", "slip_rr", "v_y_rear_mps"))


@law
def ploughing(
    ids: Ids,
    width_m: float,
    depth_m: float,
    slip_target: float,
    engine: Records,
    actions: Array,
    lift_rad: Array,
    out: Array,
) -> None:
    """Of Plough-v0: work rate and fuel, the reward's terms and their sum, the task.

    Rows as `twin.env.episodes.Episodes.place` names them.
    """
    for i in ids:
        radps, depth = out[RADPS, i], out[DEPTH, i]
        rate = reward.work_rate_m2ps(out[SPEED, i], depth, width_m, depth_m)
        terms = reward.ploughing(
            rate, out[EFFICIENCY, i], out[SLIP, i], depth, slip_target, depth_m
        )
        total = 0.0
        for k in range(len(terms)):
            out[FIRST + 2 + k, i] = terms[k]
            total += terms[k]
        out[FIRST, i] = rate * 0.36
        out[FIRST + 1, i] = engine_fuel_lph(engine[0], out[ENGINE_NM, i] * radps, radps)
        out[FIRST + 6, i] = total
        out[FIRST + 7, i], out[FIRST + 8, i] = actions[i, 0], lift_rad[i]
        out[FIRST + 9, i], out[FIRST + 10, i] = slip_target, depth_m


@law
def pulling(ids: Ids, slip_target: float, actions: Array, out: Array) -> None:
    """Of WheelSlip-v0: the reward's terms and their sum, the task."""
    for i in ids:
        terms = reward.pulling(out[SLIP_RL, i], out[SLIP_RR, i], out[V_Y, i], slip_target)
        total = 0.0
        for k in range(len(terms)):
            out[FIRST + k, i] = terms[k]
            total += terms[k]
        out[FIRST + 3, i] = total
        out[FIRST + 4, i], out[FIRST + 5, i] = actions[i, 0], actions[i, 1]
        out[FIRST + 6, i] = slip_target
