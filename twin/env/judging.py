"""What a control step of some tractors was worth, written beside what was true."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law
from twin.env import reward
from twin.env.quantities import PLACE, TRUE, Ids
from twin.machine.fuel import engine_fuel_lph
from twin.physics.block import Engine
from twin.physics.engine import full_load_torque_nm, radps_to_rpm
from twin.simulation.records import Records

Array = NDArray[np.float64]

FIRST = len(TRUE)
HAPH_PER_M2PS = 0.36
SLIP, SPEED, DEPTH, RADPS, ENGINE_NM, EFFICIENCY = (
    PLACE[name]
    for name in (
        "slip", "speed_mps", "depth_m", "engine_radps", "engine_torque_nm", "traction_efficiency",
    )
)  # fmt: skip
AXLE_W = PLACE["axle_w"]
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
def working(
    ids: Ids,
    width_m: float,
    depth_m: float,
    engine: Records,
    numbers: Array,
    out: Array,
) -> None:
    """Of Plough-v1: work rate, fuel and costs, the reward's terms and their sum.

    Args:
        ids: which tractors.
        width_m: working width.
        depth_m: depth to plough at.
        engine: what the law of its fuel needs (1,).
        numbers: the engine's part of the block.
        out: read and written, rows as `twin.env.episodes.Episodes.place` names them.
    """
    reference_m2ps = width_m * reward.REFERENCE_MPS
    for i in ids:
        radps, depth, torque = out[RADPS, i], out[DEPTH, i], out[ENGINE_NM, i]
        counted = min(out[SPEED, i], reward.MOST_MPS)
        rate = reward.work_rate_m2ps(out[SPEED, i], depth, width_m, depth_m)
        fuel = engine_fuel_lph(engine[0], torque * radps, radps)
        rpm = radps_to_rpm(radps)
        load = torque / max(full_load_torque_nm(numbers, rpm), 1.0)
        costs = reward.working_costs(
            depth - depth_m, out[SLIP, i], rpm, numbers[Engine.PEAK_RPM], load
        )
        out[FIRST, i], out[FIRST + 1, i] = rate * HAPH_PER_M2PS, fuel
        worth = reward.work_rate_m2ps(counted, depth, width_m, depth_m)
        out[FIRST + 5, i] = worth / reference_m2ps
        out[FIRST + 6, i] = -reward.FUEL_HA_PER_L * fuel / (reference_m2ps * HAPH_PER_M2PS)
        total = out[FIRST + 5, i] + out[FIRST + 6, i]
        for k in range(3):
            out[FIRST + 2 + k, i] = costs[k]
            out[FIRST + 7 + k, i] = reward.kept(costs[k])
            total += out[FIRST + 7 + k, i]
        out[FIRST + 10, i] = total


@law
def traction(ids: Ids, seen: Records, out: Array) -> None:
    """Of WheelSlip-v1: place on the line, costs, the reward's terms and their sum.

    Args:
        ids: which tractors.
        seen: Observations of the drivers (nsim,).
        out: read and written, rows as `twin.env.episodes.Episodes.place` names them.
    """
    for i in ids:
        left = seen[i].left_m
        costs = reward.traction_costs(left, out[SLIP_RL, i], out[SLIP_RR, i])
        out[FIRST, i] = left
        out[FIRST + 3, i] = max(0.0, out[SPEED, i]) / reward.TRACTION_MPS
        out[FIRST + 4, i] = -reward.ENERGY_PER_W * max(0.0, out[AXLE_W, i])
        total = out[FIRST + 3, i] + out[FIRST + 4, i]
        for k in range(2):
            out[FIRST + 1 + k, i] = costs[k]
            out[FIRST + 5 + k, i] = reward.kept(costs[k])
            total += out[FIRST + 5 + k, i]
        out[FIRST + 7, i] = total


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
