"""What is true of each tractor at an instant, from the callback's slots and the MJCF's sensors.

The laws of `twin.truth`, for arrays of shape (nsim,) at one instant instead of a table in time, and
elementwise only, so that a tractor's numbers do not depend on how many stand beside it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.streams import WHEELS
from twin.truth import slip_ratio

Array = NDArray[np.float64]

MACHINE = {
    "depth_m": MachineSlot.DEPTH_M,
    "draft_n": MachineSlot.DRAFT_N,
    "engine_radps": MachineSlot.ENGINE_RADPS,
    "engine_torque_nm": MachineSlot.ENGINE_TORQUE_NM,
    "axle_torque_nm": MachineSlot.AXLE_TORQUE_NM,
}
WHEEL = {"slip": WheelSlot.SLIP, "load_n": WheelSlot.LOAD_N}


def dot(a: Array, b: Array) -> Array:
    """Scalar product over the last axis, of length 3, elementwise: (..., 3), (..., 3) -> (...)."""
    product: Array = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return product


def ahead_w(world_from_body: Array) -> Array:
    """The body's x axis in the world. Quaternions wxyz (nsim, 4) -> (nsim, 3)."""
    w, x, y, z = world_from_body.T
    return np.stack(
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)], axis=-1
    )


def ground_axes(world_from_body: Array, normal_w: Array) -> tuple[Array, Array]:
    """The body's x axis projected on the ground plane, and y = n x x.

    Args:
        world_from_body: quaternions wxyz (nsim, 4).
        normal_w: normal of the ground plane (3,), or of each tractor's (nsim, 3).
    """
    ahead = ahead_w(world_from_body)
    ahead = ahead - dot(ahead, normal_w)[..., None] * normal_w
    ahead = ahead / np.sqrt(dot(ahead, ahead))[..., None]
    n, (x, y, z) = normal_w.T, ahead.T
    left = np.stack([n[1] * z - n[2] * y, n[2] * x - n[0] * z, n[0] * y - n[1] * x], axis=-1)
    return ahead, left


def true(
    slots: Array, velocity_w: Array, world_from_body: Array, normal_w: Array, driven: list[int]
) -> dict[str, Array]:
    """Speeds, slips, loads, forces and powers of each tractor, each of shape (nsim,).

    Args:
        slots: the callback's report, `userdata` (nsim, nuserdata).
        velocity_w: velocity of the rear-axle centre (nsim, 3) [m/s].
        world_from_body: attitude, quaternions wxyz (nsim, 4).
        normal_w: normal of the ground plane (3,), or of each tractor's (nsim, 3).
        driven: places of the driven wheels in `twin.streams.WHEELS`.
    """
    wheels = slots[:, : block.MACHINE_SLOTS].reshape(len(slots), len(WHEELS), int(WheelSlot.SIZE))
    machine = slots[:, block.MACHINE_SLOTS :]
    ahead, left = ground_axes(world_from_body, normal_w)
    rim, hub, spin = (np.zeros(len(slots)) for _ in range(3))
    for i in driven:
        rate = wheels[:, i, WheelSlot.RATE_RADPS]
        rim = rim + rate * wheels[:, i, WheelSlot.ROLLING_RADIUS_M]
        hub = hub + wheels[:, i, WheelSlot.SPEED_X_MPS]
        spin = spin + rate
    out: dict[str, Array] = {
        "speed_mps": dot(ahead, velocity_w),
        "v_y_rear_mps": dot(left, velocity_w),
        "wheel_speed_mps": rim / len(driven),
        "axle_radps": spin / len(driven),
        "slip": slip_ratio(rim / len(driven), hub / len(driven)),
    }
    for what, slot in WHEEL.items():
        name, unit = what.split("_") if "_" in what else (what, "")
        for i, wheel in enumerate(WHEELS):
            out["_".join(filter(None, (name, wheel, unit)))] = wheels[:, i, slot]
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
