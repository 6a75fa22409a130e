"""The compiled part of a control step of many tractors: actions in, controls out, and a look after.

A tractor alone costs as much as the calls that are made for it, so there are few of them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law
from twin.simulation.decision import decide, observe
from twin.simulation.finite import well
from twin.simulation.records import Records

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Places = NDArray[np.int64]


@law
def bounded(actions: Array) -> bool:
    """Take the bound for what is outside [-1, 1], in place; whether all were finite."""
    finite = True
    for i in range(actions.shape[0]):
        for j in range(actions.shape[1]):
            value = actions[i, j]
            finite &= math.isfinite(value)
            actions[i, j] = min(max(value, -1.0), 1.0)
    return finite


@law
def control(
    work_rad: Array,
    tasks: Records,
    drivetrain: Records,
    seen: Records,
    drivers: Records,
    pedals: Records,
    qpos: Array,
    qvel: Array,
    userdata: Array,
    world_from_ground: Array,
    links: int,
    engine: int,
    controls: Array,
    chosen: Places,
    actuators: Places,
    ctrl: Array,
    dt_s: float,
) -> None:
    """Observe, decide, and set the controls of all; see `twin.simulation.decision`.

    Args:
        work_rad: angle of the lower links that the actions ask for (nsim,).
        qpos, qvel, userdata, world_from_ground, links: as `observe` has them.
        tasks, drivetrain, seen, drivers, pedals, engine, controls, chosen, actuators, ctrl, dt_s:
            as `decide` has them.
    """
    observe(qpos, qvel, userdata, world_from_ground, links, seen)
    for i in range(len(tasks)):
        tasks[i].work_rad = work_rad[i]
    decide(
        tasks, drivetrain, seen, qvel, engine, drivers, pedals, controls, chosen, actuators, ctrl,
        dt_s,
    )  # fmt: skip


@law
def moved(
    state: Array, warned: NDArray[np.int64], velocity: Array, standing_s: Array, dt_s: float,
    slow_mps: float,
) -> bool:  # fmt: skip
    """Whether all went `well`; if so, counts how long each has stood.

    Args:
        state: the machines' states (nsim, nstate).
        warned: how often MuJoCo warned (nsim, kinds).
        velocity: of the rear axle (3, nsim) [m/s].
        standing_s: time that each has stood, read and written (nsim,) [s].
        dt_s: the interval [s].
        slow_mps: below this speed in space a tractor stands [m/s].
    """
    if not well(state, warned):
        return False
    for i in range(state.shape[0]):
        x, y, z = velocity[0, i], velocity[1, i], velocity[2, i]
        slow = math.sqrt(x * x + y * y + z * z) < slow_mps
        standing_s[i] = standing_s[i] + dt_s if slow else 0.0
    return True


@law
def pack(
    values: Array, places: Places, low: Single, high: Single, ids: Places, out: Single
) -> None:
    """Observations of some tractors, clipped to the bounds.

    Args:
        values: what is known, a row each (rows, nsim).
        places: rows of the entries, in order (entries,).
        low, high: bounds of the box (entries,).
        ids: which tractors.
        out: written (len(ids), entries).
    """
    for k in range(len(ids)):
        for j in range(len(places)):
            value = np.float32(values[places[j], ids[k]])
            out[k, j] = min(max(value, low[j]), high[j])
