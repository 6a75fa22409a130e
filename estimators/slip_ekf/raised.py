"""When is the plough out of the ground? There the filter assumes almost no slip."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.streams import COLUMNS, Setup, Streams

CLEAR_M = -0.05
"""Out of the ground: the shares are this much above it."""
DOWN_M = 0.03
"""In the ground. Between the two, and before any sample, nothing is known."""
USED = ("gnss", "imu", "wheels", "camera")
"""The sensors the filter takes."""


@dataclass(frozen=True)
class Lift:
    """What is known of the plough's height."""

    zero_m: float
    """Laser range at depth zero, NaN without a depth sensor."""
    raised: float = np.nan
    """1 out of the ground, 0 in it, NaN unknown or between."""


def start(setup: Setup) -> Lift:
    """Nothing known yet."""
    return Lift(setup.depth.zero_m if setup.depth else np.nan)


def lifted(lift: Lift, chunk: Streams) -> tuple[Lift, NDArray[np.float64]]:
    """For each sample: was the plough out of the ground, by the depth samples that had arrived?

    depth = zero_m - laser cos(inclination)

    Out of the ground: depth < CLEAR_M. In it: depth > DOWN_M.

    Returns:
        What is known after the chunk, and one value per sample of USED in order of
        arrival: 1 out of the ground, 0 in it, NaN between the two or if no depth is known yet.
    """
    used = chunk.only((*USED, "depth"))
    if "depth" not in used or not len(used["depth"]["epoch_ns"]):
        count = sum(len(chunk[s]["epoch_ns"]) for s in USED if s in chunk)
        return lift, np.full(count, lift.raised)
    cosine = np.cos(np.nan_to_num(used.column("depth", "inclination_rad")))
    depth_m = (lift.zero_m - used.column("depth", "laser_m") * cosine).tolist()
    raised, kept, of_depth = lift.raised, [], tuple(COLUMNS).index("depth")
    for sensor, row in zip(*(order.tolist() for order in used.merge_order()), strict=True):
        if sensor != of_depth:
            kept.append(raised)
        elif math.isfinite(depth_m[row]):
            raised = 1.0 if depth_m[row] < CLEAR_M else 0.0 if depth_m[row] > DOWN_M else math.nan
    return Lift(lift.zero_m, raised), np.array(kept)
