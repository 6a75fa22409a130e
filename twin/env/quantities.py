"""What is true of each tractor at an instant, from the callback's slots and the MJCF's sensors.

The laws of `twin.truth`, for arrays of shape (nsim,) at one instant instead of a table in time, and
elementwise only, so that a tractor's numbers do not depend on how many stand beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.streams import WHEELS
from twin.truth import slip_ratio

Array = NDArray[np.float64]
Vectors = Sequence[Array] | Array

MACHINE = {
    "depth_m": MachineSlot.DEPTH_M,
    "draft_n": MachineSlot.DRAFT_N,
    "engine_radps": MachineSlot.ENGINE_RADPS,
    "engine_torque_nm": MachineSlot.ENGINE_TORQUE_NM,
    "axle_torque_nm": MachineSlot.AXLE_TORQUE_NM,
}
WHEEL = {
    **{f"slip_{wheel}": (i, WheelSlot.SLIP) for i, wheel in enumerate(WHEELS)},
    **{f"load_{wheel}_n": (i, WheelSlot.LOAD_N) for i, wheel in enumerate(WHEELS)},
}


def dot(a: Vectors, b: Vectors) -> Array:
    """Scalar products, elementwise: components first, (3, nsim), (3, nsim) -> (nsim,)."""
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def ahead_w(world_from_body: Array) -> tuple[Array, Array, Array]:
    """The body's x axis in the world. Quaternions wxyz (nsim, 4) -> (3, nsim)."""
    w, x, y, z = world_from_body.T
    return 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)


def ground_axes(world_from_body: Array, normal_w: Vectors) -> tuple[Vectors, Vectors]:
    """The body's x axis projected on the ground plane, and y = n x x, each (3, nsim).

    Args:
        world_from_body: quaternions wxyz (nsim, 4).
        normal_w: normals of the tractors' ground planes (3, nsim).
    """
    n, ahead = normal_w, ahead_w(world_from_body)
    above = dot(ahead, n)
    x, y, z = (part - above * along for part, along in zip(ahead, n, strict=True))
    length = np.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    return (x, y, z), (n[1] * z - n[2] * y, n[2] * x - n[0] * z, n[0] * y - n[1] * x)


def true(
    slots: Array, velocity_w: Array, world_from_body: Array, normal_w: Array, driven: list[int]
) -> dict[str, Array]:
    """Speeds, slips, loads, forces and powers of each tractor, each of shape (nsim,).

    Args:
        slots: the callback's report, `userdata` (nsim, nuserdata).
        velocity_w: velocity of the rear-axle centre (nsim, 3) [m/s].
        world_from_body: attitude, quaternions wxyz (nsim, 4).
        normal_w: normals of the tractors' ground planes (nsim, 3).
        driven: places of the driven wheels in `twin.streams.WHEELS`.
    """
    wheels = slots[:, : block.MACHINE_SLOTS].reshape(len(slots), len(WHEELS), int(WheelSlot.SIZE))
    machine = slots[:, block.MACHINE_SLOTS :]
    ahead, left = ground_axes(world_from_body, tuple(normal_w.T))
    velocity = tuple(velocity_w.T)
    rim, hub, spin = (np.zeros(len(slots)) for _ in range(3))
    for i in driven:
        rate = wheels[:, i, WheelSlot.RATE_RADPS]
        rim = rim + rate * wheels[:, i, WheelSlot.ROLLING_RADIUS_M]
        hub = hub + wheels[:, i, WheelSlot.SPEED_X_MPS]
        spin = spin + rate
    out: dict[str, Array] = {
        "speed_mps": dot(ahead, velocity),
        "v_y_rear_mps": dot(left, velocity),
        "wheel_speed_mps": rim / len(driven),
        "axle_radps": spin / len(driven),
        "slip": slip_ratio(rim / len(driven), hub / len(driven)),
    }
    out |= {name: wheels[:, i, slot] for name, (i, slot) in WHEEL.items()}
    return out | {name: machine[:, slot] for name, slot in MACHINE.items()}


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
