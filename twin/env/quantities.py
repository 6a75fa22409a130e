"""What is true of each tractor at an instant, by the laws of `twin.truth.motion`.

Tractor by tractor, so that one's numbers do not depend on how many stand beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twin.physics.block import MachineSlot, WheelSlot
from twin.streams import WHEELS
from twin.truth.motion import Wheels, driven_axle, ground_velocity, slip_ratio

Array = NDArray[np.float64]
Ids = NDArray[np.int64]

REPORTED = {
    **{f"slip_{wheel}": (i, WheelSlot.SLIP) for i, wheel in enumerate(WHEELS)},
    **{f"load_{wheel}_n": (i, WheelSlot.LOAD_N) for i, wheel in enumerate(WHEELS)},
    "depth_m": (len(WHEELS), MachineSlot.DEPTH_M),
    "draft_n": (len(WHEELS), MachineSlot.DRAFT_N),
    "engine_radps": (len(WHEELS), MachineSlot.ENGINE_RADPS),
    "engine_torque_nm": (len(WHEELS), MachineSlot.ENGINE_TORQUE_NM),
    "axle_torque_nm": (len(WHEELS), MachineSlot.AXLE_TORQUE_NM),
}
"""What the callback reports as it is: after how many wheels, and which slot of theirs."""
SLOTS = np.array([after * WheelSlot.SIZE + slot for after, slot in REPORTED.values()])


class Reported(NamedTuple):
    """What the machines' sensors and the callback report; views into the Batch."""

    velocity_w: Array
    """Velocity of the rear-axle centre (nsim, 3) [m/s]."""
    world_from_body: Array
    """Attitude, quaternions wxyz (nsim, 4)."""
    normal_w: Array
    """Normals of the ground planes (nsim, 3)."""
    wheels: Wheels
    slots: Array
    """The callback's report, `userdata` (nsim, nuserdata)."""

    def of(self, ids: Ids) -> Reported:
        """The same of some."""
        wheels = Wheels(*(values[ids] for values in self.wheels))
        velocity, attitude, normal = (values[ids] for values in self[:3])
        return Reported(velocity, attitude, normal, wheels, self.slots[ids])


def true(reported: Reported, driven: Ids, ids: Ids | None = None) -> dict[str, Array]:
    """Speeds, slips, loads and forces of the tractors, or of some. Shapes (nsim,) or (len(ids),).

    Args:
        reported: what is known of all.
        driven: places of the driven wheels in `twin.streams.WHEELS`.
        ids: which tractors; None for all.
    """
    now = reported if ids is None else reported.of(ids)
    speed, v_y = ground_velocity(now.world_from_body, now.normal_w, now.velocity_w)
    axle = driven_axle(now.wheels, driven)
    out = {
        "speed_mps": speed,
        "v_y_rear_mps": v_y,
        "wheel_speed_mps": axle.wheel_speed_mps,
        "axle_radps": axle.axle_radps,
        "slip": slip_ratio(axle.wheel_speed_mps, axle.hub_mps),
    }
    return out | dict(zip(REPORTED, now.slots.T[SLOTS], strict=True))


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
