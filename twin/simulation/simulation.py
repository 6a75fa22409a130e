"""Machines with their drivers in one Batch: one for a run, many for an environment."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from twin.machine.build import Machine
from twin.machine.geometry import geometry
from twin.physics import block
from twin.physics.block import WheelSlot
from twin.simulation.braking import BrakePedal
from twin.simulation.columns import RECORDED, Record
from twin.simulation.course_task import course_task, drivetrain
from twin.simulation.decision import CONTROLS, decide, observe
from twin.simulation.driver import DriverState, DriverTask, Observation
from twin.simulation.finite import all_finite, all_well
from twin.simulation.guard import KEPT_S, StateRing, diverged
from twin.simulation.records import Records, records
from twin.truth.motion import DrivenAxle, Wheels, driven_axle

Array = NDArray[np.float64]

DECISION_S = 0.02
"""Time between two decisions of the driver; a whole number of physics steps."""
VELOCITY = mujoco.mjtStage.mjSTAGE_VEL.value
"""As far as forward computation goes to bring sensors and slots up to date."""

ROLLING = WheelSlot.RATE_RADPS, WheelSlot.ROLLING_RADIUS_M, WheelSlot.SPEED_X_MPS
"""Slots of `Wheels`."""


class Simulation:
    """Machines on their grounds with their drivers: the only object whose physics changes.

    All arrays have one row for each machine, and are views into the Batch where it has them.
    """

    def __init__(
        self,
        machine: Machine,
        nsim: int = 1,
        nthread: int = 1,
        *,
        task: DriverTask | None = None,
        kept_s: float = KEPT_S,
    ) -> None:
        """Stand machines at the start of the course, rolling.

        Args:
            machine: what is driven.
            nsim: how many of it.
            nthread: threads of the physics.
            task: what each driver is to do; None for the scenario's course.
            kept_s: how much of the past is kept for the evidence of a failure.
        """
        self.machine = machine
        model = machine.model
        self.batch = Batch(model, nsim=nsim, nthread=nthread)
        self.state, self.warned = self.batch.state, self.batch.warning[:, :, 1]
        self.qpos, self.qvel = self.batch.bind("qpos"), self.batch.bind("qvel")
        self.ctrl, self.slots = self.batch.bind("ctrl"), self.batch.bind("userdata")
        wheels = self.slots[:, : block.MACHINE_SLOTS].reshape(nsim, len(block.WHEELS), -1)
        self.wheels = Wheels(*(wheels[:, :, slot] for slot in ROLLING))
        self.driven = np.array([block.WHEELS.index(w) for w in geometry(machine).driven])
        self.world_from_ground = np.repeat(machine.world_from_ground[None], nsim, axis=0)
        self.period_s = DECISION_S
        self.steps = round(DECISION_S / model.opt.timestep)
        self.tasks = records(task or course_task(machine), nsim)
        self.seen, self.drivers = records(Observation(), nsim), records(DriverState(), nsim)
        self.drivers["lift_rad"] = self.tasks["raised_rad"]
        self.drivetrain = records(drivetrain(machine), nsim)
        self.pedals = records(BrakePedal(), nsim)
        self.controls = np.zeros((nsim, len(CONTROLS)))
        actuators = {model.actuator(k).name: k for k in range(model.nu)}
        self.chosen = np.array([k for k, n in enumerate(CONTROLS) if n in actuators], np.int64)
        self.into = np.array([actuators[CONTROLS[k]] for k in self.chosen], np.int64)
        self.links = -1 if machine.hitch is None else int(model.joint("lift").qposadr[0])
        self.engine = int(model.joint("drive").dofadr[0])
        self.ring = StateRing(self.state.shape, round(kept_s / DECISION_S) or 1)
        self.start_rolling()

    def start_rolling(self) -> None:
        """Put all at the machine's start, their wheels rolling at its speed along their grounds."""
        machine, numbers = self.machine, self.machine.numbers
        model, speed_mps = machine.model, machine.start_speed_mps
        self.qpos[:], self.batch.bind("act")[:] = machine.start_qpos, machine.start_act
        for qvel, rotation in zip(self.qvel, self.world_from_ground, strict=True):
            qvel[:3] = rotation @ np.array([speed_mps, 0.0, 0.0])
        for wheel in block.WHEELS:
            axle = "front" if wheel[0] == "f" else "rear"
            radius_m = numbers[f"tyre_{axle}.free_rolling_radius_m"]
            self.qvel[:, model.joint(f"{wheel}_spin").dofadr[0]] = speed_mps / radius_m
        rear_m = numbers["tyre_rear.free_rolling_radius_m"]
        self.qvel[:, self.engine] = speed_mps / rear_m

    @property
    def engine_radps(self) -> Array:
        """Engine speeds now. Shape (nsim,)."""
        return np.asarray(self.drivetrain["gear_ratio"] * self.qvel[:, self.engine])

    def driven_axle(self) -> DrivenAxle:
        """Means over the driven wheels, as the callback last reported them. Shapes (nsim,)."""
        return driven_axle(self.wheels, self.driven)

    def observe(self) -> Records:
        """What the drivers see now, an Observation of each. Shape (nsim,)."""
        observe(self.qpos, self.qvel, self.slots, self.world_from_ground, self.links, self.seen)
        return self.seen

    def decide(self) -> None:
        """Set the controls by what was observed."""
        decide(
            self.tasks, self.drivetrain, self.seen, self.qvel, self.engine, self.drivers,
            self.pedals, self.controls, self.chosen, self.into, self.ctrl, self.period_s,
        )  # fmt: skip

    def run(self, recorded: Sequence[str] = RECORDED) -> Record:
        """Run to the next decision; what was recorded after each step.

        Raises:
            Diverged: the state or a slot of it is not finite, or MuJoCo warned.
        """
        self.ring.keep(self.state)
        record: Record = self.batch.rollout(self.steps, record=recorded)
        if not all_well(self.state, self.warned, record["userdata"]):
            self.refuse_failure(record["userdata"])
        return record

    def advance(self) -> Record:
        """Observe, decide, and run to the next decision; see `run`."""
        self.observe()
        self.decide()
        return self.run()

    def refuse_failure(self, *more: Array) -> None:
        """Raise what led to a failure, if there is one.

        Args:
            more: what has to be finite beside the state. Shape (nsim, ...).

        Raises:
            Diverged: the state or one of the rest is not finite, or MuJoCo warned.
        """
        looked_at = (self.state, *more)
        if all(all_finite(values) for values in looked_at) and not self.warned.any():
            return
        failed = [
            bool(self.warned[i].any()) or not all(all_finite(values[i]) for values in looked_at)
            for i in range(len(self.state))
        ]
        i = failed.index(True) if any(failed) else 0
        model, scenario = self.batch.get_model(i), self.machine.scenario
        during = "the run of" if len(failed) == 1 else f"machine {i} of"
        raise diverged(scenario, model, self.ring.states(i), self.steps, during=during)
