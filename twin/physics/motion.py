"""How machines side by side move over their grounds, from what the callback reported of each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law
from twin.physics import rigid
from twin.physics.block import WheelSlot

Array = NDArray[np.float64]

MOTION = ("speed_mps", "v_y_rear_mps", "wheel_speed_mps", "hub_mps", "axle_radps")
"""Rows that `motions` writes first."""

WHEEL_SIZE = int(WheelSlot.SIZE)
RATE, RADIUS, HUB = (
    int(slot) for slot in (WheelSlot.RATE_RADPS, WheelSlot.ROLLING_RADIUS_M, WheelSlot.SPEED_X_MPS)
)


@law
def motions(
    ids: NDArray[np.int64],
    slots: Array,
    velocity_w: Array,
    world_from_body: Array,
    normal_w: Array,
    driven: NDArray[np.int64],
    told: NDArray[np.int64],
    out: Array,
) -> None:
    """Speeds of the rear axle over the ground, means over the driven wheels, and some slots.

        x = unit(a - (a . n) n)    y = n x x    v_x = x . v    v_y = y . v

    Args:
        ids: which machines.
        slots: the callback's report, `userdata` (nsim, nuserdata).
        velocity_w: velocity v of the rear-axle centre (nsim, 3) [m/s].
        world_from_body: attitude, quaternions wxyz (nsim, 4); its x axis is a.
        normal_w: normals n of the machines' ground planes (nsim, 3).
        driven: places of the driven wheels in `twin.streams.WHEELS`.
        told: slots that are wanted besides.
        out: written, `MOTION` and the slots in rows, (5 + len(told), len(ids)).
    """
    for k in range(len(ids)):
        i = ids[k]
        w, x, y = world_from_body[i, 0], world_from_body[i, 1], world_from_body[i, 2]
        z = world_from_body[i, 3]
        body_x = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y))
        n, v = rigid.row3(normal_w, i), rigid.row3(velocity_w, i)
        ahead = rigid.unit(rigid.minus(body_x, rigid.scaled(rigid.dot(body_x, n), n)))
        out[0, k], out[1, k] = rigid.dot(ahead, v), rigid.dot(rigid.cross(n, ahead), v)
        out[2:5, k] = 0.0
        for wheel in driven:
            at = wheel * WHEEL_SIZE
            rate = slots[i, at + RATE]
            out[2, k] += rate * slots[i, at + RADIUS] / len(driven)
            out[3, k] += slots[i, at + HUB] / len(driven)
            out[4, k] += rate / len(driven)
        for j in range(len(told)):
            out[5 + j, k] = slots[i, told[j]]
