"""What is true of each tractor at an instant, from the callback's slots and the MJCF's sensors.

The laws of `twin.truth`, for arrays of shape (nsim,) at one instant instead of a table in time, and
tractor by tractor, so that one's numbers do not depend on how many stand beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from twin.physics.block import MachineSlot, WheelSlot
from twin.physics.motion import MOTION, motions
from twin.streams import WHEELS
from twin.truth.truth import slip_ratio

Array = NDArray[np.float64]
Ids = NDArray[np.int64]
Vectors = Sequence[Array] | Array

TOLD = {
    **{f"slip_{wheel}": (i, WheelSlot.SLIP) for i, wheel in enumerate(WHEELS)},
    **{f"load_{wheel}_n": (i, WheelSlot.LOAD_N) for i, wheel in enumerate(WHEELS)},
    "depth_m": (len(WHEELS), MachineSlot.DEPTH_M),
    "draft_n": (len(WHEELS), MachineSlot.DRAFT_N),
    "engine_radps": (len(WHEELS), MachineSlot.ENGINE_RADPS),
    "engine_torque_nm": (len(WHEELS), MachineSlot.ENGINE_TORQUE_NM),
    "axle_torque_nm": (len(WHEELS), MachineSlot.AXLE_TORQUE_NM),
}
"""What the callback reports as it is: after how many wheels, and which slot of theirs."""
SLOTS = np.array([after * WheelSlot.SIZE + slot for after, slot in TOLD.values()])


def dot(a: Vectors, b: Vectors) -> Array:
    """Scalar products, elementwise: components first, (3, nsim), (3, nsim) -> (nsim,)."""
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def ahead_w(world_from_body: Array) -> tuple[Array, Array, Array]:
    """The body's x axis in the world. Quaternions wxyz (nsim, 4) -> (3, nsim)."""
    w, x, y, z = world_from_body.T
    return 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)


def true(
    ids: Ids, slots: Array, velocity_w: Array, world_from_body: Array, normal_w: Array, driven: Ids
) -> dict[str, Array]:
    """Speeds, slips, loads and forces of some tractors, each of shape (len(ids),).

    Args:
        ids: which.
        slots: the callback's report, `userdata` (nsim, nuserdata).
        velocity_w: velocity of the rear-axle centre (nsim, 3) [m/s].
        world_from_body: attitude, quaternions wxyz (nsim, 4).
        normal_w: normals of the tractors' ground planes (nsim, 3).
        driven: places of the driven wheels in `twin.streams.WHEELS`.
    """
    rows = np.empty((len(MOTION) + len(SLOTS), len(ids)))
    motions(ids, slots, velocity_w, world_from_body, normal_w, driven, SLOTS, rows)
    out: dict[str, Array] = dict(zip((*MOTION, *TOLD), rows, strict=True))
    return out | {"slip": slip_ratio(out["wheel_speed_mps"], out.pop("hub_mps"))}


def powers(true: Mapping[str, Array], least_w: float = 1e3) -> dict[str, Array]:
    """Drawbar power, power at the driven axle, and the traction efficiency between them.

        P_draw = draft v      P_axle = T w      efficiency = P_draw / P_axle in [0, 1]

    0 below the least power at the axle. Source: ASABE S296, tractive efficiency.
    """
    draw_w = true["draft_n"] * true["speed_mps"]
    axle_w = true["axle_torque_nm"] * true["axle_radps"]
    ratio = np.where(axle_w > least_w, draw_w / np.maximum(axle_w, least_w), 0.0)
    return {
        "draw_w": draw_w,
        "axle_w": axle_w,
        "traction_efficiency": np.minimum(1.0, np.maximum(0.0, ratio)),
    }
