"""Electric tractors in one Batch, a motor on each rear wheel, towing a light cultivator."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import inlined_law, law
from twin.compute.quaternion import x_axis
from twin.env.fleet import Fleet, Start
from twin.env.grounds import Ground
from twin.env.quantities import DRAFT, TORQUE, Ids, powers, true
from twin.machine.build import Machine
from twin.physics import rigid
from twin.simulation.driver import HitchControl

Array = NDArray[np.float64]

STALL_NM, DRAG_NMSPM = 80.0, 2.0
"""A motor's torque at rest [N m] and what it loses per speed [N m s/rad]: 40 rad/s unloaded."""
DRAFT_N, DRAFT_NS2PM2 = 80.0, 130.0
"""Draft of the cultivator at rest [N] and its growth with speed squared; a soil of F = 1."""
DRAWBAR_M = (-0.12, 0.0, 0.05)
"""Where it pulls, body axes from the rear-axle centre [m]."""
START_MPS = 1.0
"""Speed an episode begins with [m/s]."""
SPEED_GAIN_PS = 2.0
"""Action per speed error, before an episode [s/m]."""
LEAST_W = 10.0
"""Power of both motors below which the efficiency counts as 0 [W]."""
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


def motors(machine: Machine) -> Machine:
    """The machine with motors on its rear wheels whose torque falls with their speed.

    torque = 80 N m action - 2 N m s/rad w
    """
    model = machine.model
    for name in ("torque_left", "torque_right"):
        actuator = model.actuator(name).id
        model.actuator_biastype[actuator] = mujoco.mjtBias.mjBIAS_AFFINE
        model.actuator_biasprm[actuator, :3] = 0.0, 0.0, -DRAG_NMSPM
    return machine


class TorqueFleet(Fleet):
    """The electric machines of WheelSlip-v0: torques instead of throttle and hitch."""

    def __init__(
        self, machine: Machine, nsim: int = 1, nthread: int = 1, *, sensed: bool = True
    ) -> None:
        """As a fleet's."""
        super().__init__(machine, nsim, nthread, sensed=sensed)
        model = machine.model
        self.tasks["hitch"], self.tasks["throttle"] = HitchControl.RAISED, 0.0
        self.tasks["clutch_pedal"], self.tasks["brakes"] = 1.0, False
        self.tasks["differential_lock"] = self.tasks["front_drive"] = False
        named = ("torque_left", "torque_right")
        self.motors = np.array([model.actuator(name).id for name in named])
        self.spins = np.array([model.joint(f"{w}_spin").dofadr[0] for w in ("rl", "rr")], np.int64)
        body = model.body("tractor").id
        self.pulled = self.batch.bind("xfrc_applied")[:, body]
        self.arm_m = np.array(DRAWBAR_M) - model.body_ipos[body]
        self.draft_scale, self.draft = np.full(nsim, 0.7), np.zeros(nsim)
        self.torques = np.zeros((nsim, 2))

    def restore(
        self, ids: Sequence[int], starts: Sequence[Start], grounds: Sequence[Ground]
    ) -> None:
        """As a fleet's, and the draft as large as the soil makes it."""
        super().restore(ids, starts, grounds)
        self.draft_scale[ids] = [ground.own["draft_scale"] for ground in grounds]
        self.torques[ids] = [start.action for start in starts]
        self.draft[ids] = self._draft()[ids]

    def steady(self) -> Array:
        """Hold the speed an episode begins with; both wheels alike."""
        error = START_MPS - self.speed_mps()
        wanted = np.minimum(1.0, np.maximum(-1.0, 0.35 + SPEED_GAIN_PS * error))
        return np.stack([wanted, wanted], axis=-1)

    def act(self, actions: Array) -> None:
        """Torques of the rear wheels, the engine's own shaft free; the cultivator pulls."""
        pull(
            actions, self.qpos, self.velocity, self.draft_scale, self.arm_m, self.motors,
            self.draft, self.pulled, self.ctrl,
        )  # fmt: skip
        self.torques = actions.copy()
        self.control()

    def look(self, ids: Ids, out: Array) -> None:
        """As a fleet's, with the cultivator's draft and the motors' torque."""
        true(*self.reported, self.driven, ids, out)
        towed(ids, self.torques, self.qvel, self.spins, self.draft, out)
        powers(ids, LEAST_W, out)

    def _draft(self) -> Array:
        """The cultivator's draft at the speed of now. Shape (nsim,)."""
        (ax, ay, az), (vx, vy, vz) = x_axis(*self.qpos[:, 3:7].T), self.velocity
        return draft_n(self.draft_scale, ax * vx + ay * vy + az * vz)


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
