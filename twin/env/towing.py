"""What an electric tractor's motors give, and the cultivator that it tows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import inlined_law, law
from twin.compute.quaternion import x_axis
from twin.env.quantities import DRAFT, TORQUE, Ids
from twin.physics import rigid

Array = NDArray[np.float64]

STALL_NM, DRAG_NMSPM = 80.0, 2.0
"""A motor's torque at rest [N m] and what it loses per speed [N m s/rad]: 40 rad/s unloaded."""
DRAFT_N, DRAFT_NS2PM2 = 80.0, 130.0
"""Draft of the cultivator at rest [N] and its growth with speed squared; a soil of F = 1."""
STANDING_MPS = 0.1
"""Below this the draft fades, so that it holds nothing the other way [m/s]."""


def draft_n(scale: Array, speed_mps: Array) -> Array:
    """Draft of the cultivator against the motion, (nsim,).

        D = F (A + C v^2)          times v / 0.1 m/s below 0.1 m/s

    Source of the form: ASABE D497; A and C are assumed, for a tool a 115 kg tractor can pull.
    """
    fade = np.minimum(1.0, np.maximum(-1.0, speed_mps / STANDING_MPS))
    pulled: Array = scale * (DRAFT_N + DRAFT_NS2PM2 * speed_mps * speed_mps) * fade
    return pulled


_draft_n, _x_axis = inlined_law(draft_n), inlined_law(x_axis)


@law
def pull(
    actions: Array,
    qpos: Array,
    velocity: Array,
    draft_scale: Array,
    arm_m: Array,
    motors: Ids,
    draft: Array,
    pulled: Array,
    ctrl: Array,
) -> None:
    """The cultivator's force for the next control step, and the motors' controls, of all.

    Args:
        actions: torques at rest over the largest (nsim, 2).
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
        draft[i] = _draft_n(draft_scale[i], speed)
        force = rigid.scaled(-draft[i], (ax, ay, az))
        twice = rigid.scaled(2.0, rigid.cross((x, y, z), arm))  # the rotation, as in `rotated`
        turned = rigid.plus(arm, rigid.scaled(w, twice))
        turned = rigid.plus(turned, rigid.cross((x, y, z), twice))
        torque = rigid.cross(turned, force)
        for k in range(3):
            pulled[i, k], pulled[i, 3 + k] = force[k], torque[k]
        for k in range(2):
            ctrl[i, motors[k]] = STALL_NM * actions[i, k]


@law
def towed(ids: Ids, torques: Array, qvel: Array, spins: Ids, draft: Array, out: Array) -> None:
    """The draft and the torque of both motors of some tractors, into rows of TRUE."""
    for i in ids:
        left = STALL_NM * torques[i, 0] - DRAG_NMSPM * qvel[i, spins[0]]
        right = STALL_NM * torques[i, 1] - DRAG_NMSPM * qvel[i, spins[1]]
        out[DRAFT, i], out[TORQUE, i] = draft[i], left + right
