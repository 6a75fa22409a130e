"""Electric tractors in one Batch, a motor on each rear wheel, towing a light cultivator."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute.quaternion import x_axis
from twin.env.fleet import Fleet, Start
from twin.env.grounds import Ground
from twin.env.quantities import Ids, powers, true
from twin.env.towing import DRAG_NMSPM, draft_n, pull, towed
from twin.machine.build import Machine
from twin.simulation.driver import HitchControl

Array = NDArray[np.float64]

DRAWBAR_M = (-0.12, 0.0, 0.05)
"""Where it pulls, body axes from the rear-axle centre [m]."""
START_MPS = 1.0
"""Speed an episode begins with [m/s]."""
SPEED_GAIN_PS = 2.0
"""Action per speed error, before an episode [s/m]."""
LEAST_W = 10.0
"""Power of both motors below which the efficiency counts as 0 [W]."""


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
