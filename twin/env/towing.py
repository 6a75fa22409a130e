"""What the motors of driven wheels give, and the implement that the machine tows."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import inlined_law, law
from twin.compute.quaternion import x_axis
from twin.env.quantities import DRAFT, TORQUE, Ids
from twin.physics import rigid

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)

STANDING_MPS = 0.1
"""Below this the draft fades, so that it holds nothing the other way [m/s]."""


class Pulled(NamedTuple):
    """Draft law of an implement that is pulled at the drawbar, in a soil of F = 1."""

    at_rest_n: float
    """Draft at rest, A."""
    per_mps: float
    per_mps2: float
    """Its growth with speed, B, and with speed squared, C."""


def draft_n(scale: Number, speed_mps: Number, pulled: Pulled) -> Number:
    """Draft of the implement against the motion [N]; elementwise.

    D = F (A + C v^2 + B v)          times v / 0.1 m/s below 0.1 m/s

    Source of the form: ASABE D497.
    """
    fade = np.minimum(1.0, np.maximum(-1.0, speed_mps / STANDING_MPS))
    still = pulled.at_rest_n + pulled.per_mps2 * speed_mps * speed_mps
    drawn: Number = scale * (still + pulled.per_mps * speed_mps) * fade
    return drawn


_draft_n, _x_axis = inlined_law(draft_n), inlined_law(x_axis)


@law
def pull(
    actions: Array,
    stall_nm: float,
    implement: Pulled,
    qpos: Array,
    velocity: Array,
    draft_scale: Array,
    arm_m: Array,
    motors: Ids,
    draft: Array,
    pulled: Array,
    ctrl: Array,
) -> None:
    """The implement's force for the next control step, and the motors' controls, of all.

    Args:
        actions: torques at rest over the largest (nsim, 2).
        stall_nm: a motor's torque at rest.
        implement: its draft law.
        qpos: positions (nsim, nq), with the attitude q after the place.
        velocity: of the rear axle (3, nsim) [m/s].
        draft_scale: F (nsim,).
        arm_m: drawbar from the body's centre of mass, body axes (3,).
        motors: the motors' actuators.
        draft: written (nsim,) [N].
        pulled: written, force at the centre of mass and torque about it (nsim, 6).
        ctrl: written, the actuators' controls (nsim, nu).
    """
    arm = (arm_m[0], arm_m[1], arm_m[2])
    for i in range(len(actions)):
        w, x, y, z = qpos[i, 3], qpos[i, 4], qpos[i, 5], qpos[i, 6]
        ax, ay, az = _x_axis(w, x, y, z)
        speed = ax * velocity[0, i] + ay * velocity[1, i] + az * velocity[2, i]
        draft[i] = _draft_n(draft_scale[i], speed, implement)
        force = rigid.scaled(-draft[i], (ax, ay, az))
        twice = rigid.scaled(2.0, rigid.cross((x, y, z), arm))  # the rotation, as in `rotated`
        turned = rigid.plus(arm, rigid.scaled(w, twice))
        turned = rigid.plus(turned, rigid.cross((x, y, z), twice))
        torque = rigid.cross(turned, force)
        for k in range(3):
            pulled[i, k], pulled[i, 3 + k] = force[k], torque[k]
        for k in range(2):
            ctrl[i, motors[k]] = stall_nm * actions[i, k]


@law
def towed(
    ids: Ids,
    torques: Array,
    stall_nm: float,
    drag_nmspm: float,
    qvel: Array,
    spins: Ids,
    draft: Array,
    out: Array,
) -> None:
    """The draft and the torque of both motors of some tractors, into rows of TRUE.

    torque = stall_nm action - drag_nmspm w
    """
    for i in ids:
        left = stall_nm * torques[i, 0] - drag_nmspm * qvel[i, spins[0]]
        right = stall_nm * torques[i, 1] - drag_nmspm * qvel[i, spins[1]]
        out[DRAFT, i], out[TORQUE, i] = draft[i], left + right
