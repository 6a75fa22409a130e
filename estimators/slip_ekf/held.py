"""What slower sensors last said, at each sample of the faster ones: plough raised, and the load."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimators.layout import STALE_S
from estimators.signals import epochs
from twin.streams import COLUMNS, Setup, Streams

CLEAR_M, DOWN_M = -0.05, 0.03
"""Depths above which the shares are out of the ground, and below which in it. Between the two, and
before any sample, nothing is known."""
USED = ("gnss", "imu", "wheels", "camera")
"""The sensors the filter takes."""
LOADS = {
    "draft_pin_n": 10e3, "axle_torque_nm": 10e3, "engine_load": 0.3, "fuel_lph": 5.0,
    "hitch_m": 0.1,
}  # fmt: skip
"""What tells of the load, and by how much it varies at work."""
PLOUGH, FIRST_LOAD, HELD = 0, 1, 1 + len(LOADS)
TORQUE = FIRST_LOAD + tuple(LOADS).index("axle_torque_nm")
"""Where they stand, and how many they are."""


@dataclass(frozen=True)
class Held:
    """What is known; a plain value."""

    zero_m: float
    """Laser range at depth zero, NaN without a depth sensor."""
    values: NDArray[np.float64]
    """1 with the plough out of the ground, 0 in it, NaN unknown; then the loads over what they vary
    by, NaN unknown. Shape (HELD,)."""
    told_ns: NDArray[np.int64]
    """Epochs of the samples that told them [ns], (HELD,)."""


def start(setup: Setup) -> Held:
    """Nothing known yet."""
    zero_m = setup.depth.zero_m if setup.depth else np.nan
    return Held(zero_m, np.full(HELD, np.nan), np.full(HELD, -1, np.int64))


def held(state: Held, chunk: Streams) -> tuple[Held, NDArray[np.float64]]:
    """What was known when each sample arrived; nothing that is older than it by over `STALE_S`.

    depth = zero - laser cos(inclination)

    Returns:
        What is known after the chunk, and a row per sample of USED in order of arrival, (n, HELD).
    """
    used = Streams({s: chunk[s] for s in (*USED, "depth", "machine") if s in chunk})
    sensor, row = used.merge_order()
    told = np.full((len(sensor) + 1, HELD), np.nan)
    told[0] = state.values
    fresh = np.zeros_like(told, bool)
    fresh[0] = True
    for name, of in (("depth", _raised(used, state.zero_m)), ("machine", _loads(used))):
        mine = np.flatnonzero(sensor == tuple(COLUMNS).index(name))
        for column, values in of.items():
            told[1 + mine, column] = values[row[mine]]
            fresh[1 + mine, column] = True
    # a load that is not measured stays as it was; a depth between the two is not known
    fresh[1:, FIRST_LOAD:] &= np.isfinite(told[1:, FIRST_LOAD:])
    newest = np.maximum.accumulate(np.where(fresh, np.arange(len(told))[:, None], 0), axis=0)
    known = np.take_along_axis(told, newest, axis=0)
    epoch_ns = np.append(np.int64(-1), epochs(used, sensor, row))
    told_ns = np.where(newest == 0, state.told_ns, epoch_ns[newest])
    after = replace(state, values=known[-1].copy(), told_ns=told_ns[-1].copy())
    known[epoch_ns[:, None] - told_ns > STALE_S * 1e9] = np.nan
    faster = np.isin(sensor, [tuple(COLUMNS).index(s) for s in USED])
    return after, np.ascontiguousarray(known[1:][faster])


def _raised(used: Streams, zero_m: float) -> dict[int, NDArray[np.float64]]:
    """Whether the plough is out of the ground, of each depth sample."""
    if "depth" not in used:
        return {}
    cosine = np.cos(np.nan_to_num(used.column("depth", "inclination_rad")))
    depth_m = zero_m - used.column("depth", "laser_m") * cosine
    return {PLOUGH: np.where(depth_m < CLEAR_M, 1.0, np.where(depth_m > DOWN_M, 0.0, np.nan))}


def _loads(used: Streams) -> dict[int, NDArray[np.float64]]:
    """Each load of each message of the machine's bus."""
    if "machine" not in used:
        return {}
    return {
        FIRST_LOAD + i: used.column("machine", name).astype(np.float64) / scale
        for i, (name, scale) in enumerate(LOADS.items())
    }
