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
from twin.env.towing import Pulled, draft_n, pull, towed
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.simulation.driver import HitchControl
from twin.vehicle import Implement, files
from twin.vehicle.implement_derive import derive_implement

Array = NDArray[np.float64]

MOTORS = ("torque_left", "torque_right")
USUAL_IMPLEMENT = "cultivator_light"
UNLOADED_RADPS = 40.0
"""Speed at which a motor gives no torque any more; that at rest is the machine's limit."""
DRAWBAR = (-0.6, 0.0, 0.25)
"""Where the implement pulls, from the rear-axle centre, over the rear tyre's radius."""
START_MPS = 1.0
"""Speed an episode begins with [m/s]."""
SPEED_GAIN_PS = 2.0
"""Action per speed error, before an episode [s/m]."""
LEAST_W = 10.0
"""Power of both motors below which the efficiency counts as 0 [W]."""


def pulled_law(part: Implement) -> Pulled:
    """Coefficients of an implement's draft at its least depth, for v in m/s and F = 1.

        at_rest = A W T        per_mps = 3.6 B W T        per_mps2 = 3.6^2 C W T

    Source: ASABE D497, D = F (A + B S + C S^2) W T with S in km/h, T in cm.
    """
    n = derive_implement(part)
    size = n["bodies"] * n["draft.width"] * 100.0 * n["depth_m.least"]
    a, b, c = (n[f"draft.{name}"] for name in "abc")
    return Pulled(size * a, size * 3.6 * b, size * 3.6 * 3.6 * c)


def motors(machine: Machine) -> Machine:
    """The machine with motors on its rear wheels whose torque falls with their speed.

        torque = T action - T w / (40 rad/s)        with the motor's limit T

    Raises:
        BadInput: the machine has no motors on its rear wheels.
    """
    model = machine.model
    for name in MOTORS:
        actuator = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if actuator < 0:
            raise BadInput(
                f"machine = {machine.scenario.machine} has no motor on each rear wheel; one with "
                "engine.wheel_torque_nm, such as electric_tractor, would do"
            )
        drag = model.actuator_ctrlrange[actuator, 1] / UNLOADED_RADPS
        model.actuator_biastype[actuator] = mujoco.mjtBias.mjBIAS_AFFINE
        model.actuator_biasprm[actuator, :3] = 0.0, 0.0, -drag
    return machine


class TorqueFleet(Fleet):
    """The electric machines of WheelSlip-v0: torques instead of throttle and hitch."""

    def __init__(
        self,
        machine: Machine,
        nsim: int = 1,
        nthread: int = 1,
        *,
        sensed: bool = True,
        implement: Implement | None = None,
    ) -> None:
        """As a fleet's; `implement` is what each pulls, None for the usual one."""
        super().__init__(machine, nsim, nthread, sensed=sensed)
        model = machine.model
        self.implement = pulled_law(implement or files.implement(USUAL_IMPLEMENT))
        self.tasks["hitch"], self.tasks["throttle"] = HitchControl.RAISED, 0.0
        self.tasks["clutch_pedal"], self.tasks["brakes"] = 1.0, False
        self.tasks["differential_lock"] = self.tasks["front_drive"] = False
        self.motors = np.array([model.actuator(name).id for name in MOTORS])
        self.stall_nm = float(model.actuator_ctrlrange[self.motors[0], 1])
        self.spins = np.array([model.joint(f"{w}_spin").dofadr[0] for w in ("rl", "rr")], np.int64)
        body = model.body("tractor").id
        self.pulled = self.batch.bind("xfrc_applied")[:, body]
        radius_m = 0.5 * machine.numbers["tyre_rear.diameter_m"]
        self.arm_m = radius_m * np.array(DRAWBAR) - model.body_ipos[body]
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
            actions, self.stall_nm, self.implement, self.qpos, self.velocity, self.draft_scale,
            self.arm_m, self.motors, self.draft, self.pulled, self.ctrl,
        )  # fmt: skip
        self.torques = actions.copy()
        self.control()

    def look(self, ids: Ids, out: Array) -> None:
        """As a fleet's, with the cultivator's draft and the motors' torque."""
        true(*self.reported, self.driven, ids, out)
        drag_nmspm = self.stall_nm / UNLOADED_RADPS
        towed(ids, self.torques, self.stall_nm, drag_nmspm, self.qvel, self.spins, self.draft, out)
        powers(ids, LEAST_W, out)

    def _draft(self) -> Array:
        """The cultivator's draft at the speed of now. Shape (nsim,)."""
        (ax, ay, az), (vx, vy, vz) = x_axis(*self.qpos[:, 3:7].T), self.velocity
        return draft_n(self.draft_scale, ax * vx + ay * vy + az * vz, self.implement)
