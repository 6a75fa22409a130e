"""Electric tractors in one Batch, a motor on each rear wheel, towing a light cultivator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.compute.quaternion import cross, rotated, x_axis
from twin.env.fleet import Fleet, Start
from twin.env.grounds import Ground
from twin.env.quantities import DRAFT, TORQUE, Ids, powers, true
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
STANDING_MPS = 0.1
"""Below this the draft fades, so that it holds nothing the other way [m/s]."""


@dataclass(frozen=True)
class Pulled:
    """An implement that is pulled at the drawbar, at its least depth."""

    at_rest_n: float
    """Draft at rest in a soil of F = 1."""
    per_mps: float
    per_mps2: float
    """Its growth with speed, and with speed squared."""

    @classmethod
    def of(cls, part: Implement) -> Pulled:
        """By ASABE D497: F (A + B S + C S**2) W T, with S in km/h."""
        n = derive_implement(part)
        size = n["bodies"] * n["draft.width"] * 100.0 * n["depth_m.least"]
        return cls(size * n["draft.a"], size * 3.6 * n["draft.b"], size * 3.6 * 3.6 * n["draft.c"])


def draft_n(scale: Array, speed_mps: Array, pulled: Pulled) -> Array:
    """Draft of the implement against the motion, (nsim,).

    D = F (A + B v + C v^2)          times v / 0.1 m/s below 0.1 m/s
    """
    fade = np.minimum(1.0, np.maximum(-1.0, speed_mps / STANDING_MPS))
    still = pulled.at_rest_n + pulled.per_mps2 * speed_mps * speed_mps
    drawn: Array = scale * (still + pulled.per_mps * speed_mps) * fade
    return drawn


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
        self.implement = Pulled.of(implement or files.implement(USUAL_IMPLEMENT))
        self.tasks["hitch"], self.tasks["throttle"] = HitchControl.RAISED, 0.0
        self.tasks["clutch_pedal"], self.tasks["brakes"] = 1.0, False
        self.tasks["differential_lock"] = self.tasks["front_drive"] = False
        self.motors = [model.actuator(name).id for name in MOTORS]
        self.stall_nm = float(model.actuator_ctrlrange[self.motors[0], 1])
        self.spins = [model.joint(f"{wheel}_spin").dofadr[0] for wheel in ("rl", "rr")]
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
        self._pull()
        self.torques = actions.copy()
        self.control()
        self.ctrl[:, self.motors] = self.stall_nm * actions

    def look(self, ids: Ids, out: Array) -> None:
        """As a fleet's, with the cultivator's draft and the motors' torque."""
        true(*self.reported, self.driven, ids, out)
        drag = self.stall_nm / UNLOADED_RADPS
        torque = self.stall_nm * self.torques[ids] - drag * self.qvel[ids][:, self.spins]
        out[DRAFT, ids], out[TORQUE, ids] = self.draft[ids], torque[:, 0] + torque[:, 1]
        powers(ids, LEAST_W, out)

    def _draft(self) -> Array:
        """The cultivator's draft at the speed of now. Shape (nsim,)."""
        (ax, ay, az), (vx, vy, vz) = x_axis(*self.qpos[:, 3:7].T), self.velocity
        return draft_n(self.draft_scale, ax * vx + ay * vy + az * vz, self.implement)

    def _pull(self) -> None:
        """The cultivator's force for the next control step, moved to the body's centre of mass."""
        attitude = self.qpos[:, 3:7]
        ahead, self.draft = np.stack(x_axis(*attitude.T), axis=-1), self._draft()
        force = -self.draft[:, None] * ahead
        self.pulled[:, :3] = force
        self.pulled[:, 3:] = cross(rotated(attitude, self.arm_m), force)
