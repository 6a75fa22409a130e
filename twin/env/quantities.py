"""True speeds, slips, loads, forces and powers of each tractor at one instant.

Speeds and slips follow the formulas of `twin.truth.motion`. The callback reports the
slip of each wheel, loads, depth, draft, engine and torques.

Tractor by tractor, so that one's numbers do not depend on how many stand beside it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import inlined_law, law
from twin.physics.block import MachineSlot, WheelSlot
from twin.streams import WHEELS
from twin.truth import motion
from twin.truth.motion import driven_axle_of, ground_velocity_of

Array = NDArray[np.float64]
Ids = NDArray[np.int64]

OWN = ("speed_mps", "v_y_rear_mps", "wheel_speed_mps", "axle_radps", "slip")
REPORTED = {
    **{f"slip_{wheel}": (i, WheelSlot.SLIP) for i, wheel in enumerate(WHEELS)},
    **{f"load_{wheel}_n": (i, WheelSlot.LOAD_N) for i, wheel in enumerate(WHEELS)},
    "depth_m": (len(WHEELS), MachineSlot.DEPTH_M),
    "draft_n": (len(WHEELS), MachineSlot.DRAFT_N),
    "engine_radps": (len(WHEELS), MachineSlot.ENGINE_RADPS),
    "engine_torque_nm": (len(WHEELS), MachineSlot.ENGINE_TORQUE_NM),
    "axle_torque_nm": (len(WHEELS), MachineSlot.AXLE_TORQUE_NM),
}
"""Quantities that the callback reports unchanged: after how many wheels, and in which slot."""
POWERS = ("draw_w", "axle_w", "traction_efficiency")
TRUE = (*OWN, *REPORTED, *POWERS)
"""What `true` and `powers` write, one row for each."""
PLACE = {name: row for row, name in enumerate(TRUE)}

SLOTS = np.array([after * WheelSlot.SIZE + slot for after, slot in REPORTED.values()])
FIRST_SLOT = len(OWN)
SPEED, SPIN = PLACE["speed_mps"], PLACE["axle_radps"]
DRAFT, TORQUE = PLACE["draft_n"], PLACE["axle_torque_nm"]
DRAW_W, AXLE_W, EFFICIENCY = (PLACE[name] for name in POWERS)

slip_ratio = inlined_law(motion.slip_ratio)


class Reported(NamedTuple):
    """What the machines' sensors and the callback report; views into the Batch."""

    velocity_w: Array
    """Velocity of the rear-axle centre (nsim, 3) [m/s]."""
    world_from_body: Array
    """Attitude, quaternions wxyz (nsim, 4)."""
    normal_w: Array
    """Normals of the ground planes (nsim, 3)."""
    spin_radps: Array
    """The wheels' (nsim, 4)."""
    rolling_radius_m: Array
    """The wheels' (nsim, 4)."""
    hub_mps: Array
    """Speed of the wheels' centres along their rolling direction (nsim, 4)."""
    slots: Array
    """The callback's report, `userdata` (nsim, nuserdata)."""


@law
def true(
    velocity_w: Array,
    world_from_body: Array,
    normal_w: Array,
    spin_radps: Array,
    rolling_radius_m: Array,
    hub_mps: Array,
    slots: Array,
    driven: Ids,
    ids: Ids,
    out: Array,
) -> None:
    """Speeds, slips, loads and forces of some tractors.

    Args:
        velocity_w, world_from_body, normal_w, spin_radps, rolling_radius_m, hub_mps, slots: see
            `Reported`.
        driven: places of the driven wheels in `twin.streams.WHEELS`.
        ids: which tractors.
        out: written, a row for each of TRUE but the POWERS (rows, nsim).
    """
    for i in ids:
        speed, v_y = ground_velocity_of(world_from_body, normal_w, velocity_w, i)
        rim, hub, spin = driven_axle_of(spin_radps, rolling_radius_m, hub_mps, driven, i)
        out[0, i], out[1, i], out[2, i] = speed, v_y, rim
        out[3, i], out[4, i] = spin, slip_ratio(rim, hub)
        for k in range(len(SLOTS)):
            out[FIRST_SLOT + k, i] = slots[i, SLOTS[k]]


@law
def powers(ids: Ids, least_w: float, out: Array) -> None:
    """Drawbar power, power at the driven axle, and the traction efficiency between them.

        P_draw = draft v      P_axle = T w      efficiency = P_draw / P_axle in [0, 1]

    0 below the least power at the axle. Source: ASABE S296, tractive efficiency.

    Args:
        ids: which tractors.
        least_w: the least power.
        out: read and written, a row for each of TRUE (rows, nsim).
    """
    for i in ids:
        draw_w = out[DRAFT, i] * out[SPEED, i]
        axle_w = out[TORQUE, i] * out[SPIN, i]
        ratio = draw_w / axle_w if axle_w > least_w else 0.0
        out[DRAW_W, i], out[AXLE_W, i] = draw_w, axle_w
        out[EFFICIENCY, i] = min(1.0, ratio) if ratio >= 0.0 else 0.0
