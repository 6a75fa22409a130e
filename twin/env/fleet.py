"""Tractors that plough in one Batch, each on a soil and with a draft pattern of its own.

The module is longer than 300 lines because `Fleet` sets soil, draft, course and start of a tractor
in the same Batch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.compute import quaternion
from twin.env.control_step import control, moved
from twin.env.grounds import SPREAD, Ground, GroundShape
from twin.env.levers import FASTEST, SLOWEST, Levers, lift_sine, set_levers
from twin.env.quantities import TRUE, Ids, Reported, powers, true
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.machine.ground_frame import world_from_ground
from twin.machine.parameters import furrow_edge_m, soil_part
from twin.physics import block
from twin.physics.block import Field, Part, Soil, Wheel
from twin.scenario import Course
from twin.scenario import Soil as Setting
from twin.scenario.soils import PRESETS
from twin.simulation.columns import Record, Recorder
from twin.simulation.course_task import course_task
from twin.simulation.driver import LIFT_RATE_RADPS, DriverTask, HitchControl
from twin.simulation.records import records
from twin.simulation.simulation import DECISION_S, VELOCITY, Simulation
from twin.streams import WHEELS
from twin.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
STALL_MPS = 0.05
"""Slower than this is standing."""
LEAST_W = 1e3
"""Power at the axle below which the traction efficiency counts as 0 [W]."""
OWN = {name: int(Soil[name.upper()]) for name in SPREAD}
"""Where a soil's part of the block has a ground's own numbers of it."""
SHEARED = [int(Soil.COHESION_PA), int(Soil.TAN_PHI)]
"""Where it has what friction scales in Bekker's law."""
RECORDED = ("sensordata", "userdata")
"""What the sensors of an episode need of every step."""


@dataclass(frozen=True)
class GroundFrame:
    """How the ground lies under a tractor: its frame in the world."""

    world_from_ground: Array
    """Rotation matrix (3, 3)."""
    quaternion: Array
    """The same, wxyz (4,)."""

    @classmethod
    def of(cls, shape: GroundShape, course: Course) -> GroundFrame:
        """That of a field which a course crosses."""
        rotation = world_from_ground(shape.field(), course)
        return cls(rotation, quaternion.from_matrix(rotation))


@dataclass(frozen=True)
class Start:
    """Where an episode begins: rolling steadily, the plough carried just above the ground."""

    state: Array
    """MuJoCo's whole state (nstate,)."""
    frame: GroundFrame
    approach: Trajectory | None
    """What led there, for sensors and filters to settle on; None where nobody looks."""
    along_m: float
    """How far along the course it stands [m]."""
    driver: np.void
    """What the driver remembers, a row of DriverState."""
    pedal: np.void
    """The brake pedal, a row of BrakePedal."""
    action: tuple[float, ...]
    """The action that keeps it rolling so."""


def levers(machine: Machine) -> Levers:
    """Those of a machine with a hitch. Raises BadInput if it has none."""
    hitch, numbers = machine.hitch, machine.numbers
    if hitch is None:
        raise BadInput(f"{machine.scenario.machine} has no hitch; choose a machine that ploughs")
    axle_m = float(machine.model.body("tractor").pos[2])
    plough = machine.scenario.plough
    if plough is not None and plough.furrow != "none":
        axle_m -= 0.5 * plough.depth_m
    return Levers(
        idle_rpm=numbers["engine.idle_rpm"],
        no_load_rpm=numbers["engine.no_load_rpm"],
        slowest_rpm=SLOWEST * numbers["engine.idle_rpm"],
        fastest_rpm=FASTEST * numbers["engine.no_load_rpm"],
        deepest_m=machine.scenario.deepest_m,
        sole_m=numbers["plough.sole_below_hitch_m"],
        axle_m=axle_m,
        pivot_m=hitch.lower_front[1],
        length_m=hitch.lower_length_m,
    )


def lift_rad(machine: Machine, depth_set_m: ArrayLike) -> Array:
    """Lower-link angle that puts the plough's sole at a depth, in the furrow; elementwise."""
    return np.asarray(np.arcsin(lift_sine(np.asarray(depth_set_m), levers(machine))))


def start_throttle(machine: Machine) -> float:
    """The throttle action that sets the scenario's engine speed."""
    set_rpm = machine.scenario.gear.set_rpm
    idle, top = (machine.numbers[f"engine.{n}_rpm"] for n in ("idle", "no_load"))
    slowest, fastest = SLOWEST * idle, FASTEST * top
    return 2.0 * (set_rpm - slowest) / (fastest - slowest) - 1.0


def set_task(machine: Machine) -> DriverTask:
    """Hold the line without learning, the hitch where the actions set it."""
    return course_task(machine)._replace(
        hitch=int(HitchControl.SET), steer_gain_rad_per_ms=0.0, drop_rate_radps=LIFT_RATE_RADPS
    )


class Fleet(Simulation):
    """The machines of an environment, each on a ground of its own."""

    def __init__(
        self, machine: Machine, nsim: int = 1, nthread: int = 1, *, sensed: bool = True
    ) -> None:
        """Stand machines at the start of the course.

        Args:
            machine: what is driven.
            nsim: how many of it.
            nthread: threads of the physics.
            sensed: compute MuJoCo's sensors at every physics step, those of force and acceleration
                too, and not only position and velocity after a control step.
        """
        model = machine.model
        self.ground = model.geom("ground").id
        model.geom_sameframe[self.ground] = 0  # it is turned by the slope of each tractor's field
        super().__init__(machine, nsim, nthread, task=set_task(machine), kept_s=DECISION_S)
        self.blocks = self.batch.expand("numeric_data")[:, -block.SIZE :]
        self.ground_quat = self.batch.expand("geom_quat")[:, self.ground]
        self.sensordata = self.batch.bind("sensordata")
        named = Recorder(machine).sensors
        self.reported = Reported(
            self.sensordata[:, named["velocity_w"]],
            self.sensordata[:, named["world_from_body"]],
            self.world_from_ground[:, :, 2],
            *self.wheels,
            self.slots,
        )
        self.sensed = sensed
        self.disabled = self.batch.expand("opt.disableflags")
        self.flags = int(model.opt.disableflags)
        self.every, self.lift_rad = np.arange(nsim), self.drivers["lift_rad"]
        self.standing_s, self.work_rad = np.zeros(nsim), self.tasks["work_rad"].copy()
        if machine.hitch is not None:
            self.levers = records(levers(machine), 1)
        self.velocity = self.qvel[:, :3].T
        first = block.WHEEL + Wheel.LATERAL_RATIO
        self.front_grip = [first + i * Wheel.SIZE for i, w in enumerate(WHEELS) if w[0] == "f"]
        self.front_ratio = machine.numbers["tyre_front.lateral_ratio"]

    def restore(
        self, ids: Sequence[int], starts: Sequence[Start], grounds: Sequence[Ground]
    ) -> None:
        """Put some tractors back to a start, each on a ground of its own; nothing is compiled."""
        for i, start, ground in zip(ids, starts, grounds, strict=True):
            self.batch.warning[i] = 0
            self.state[i] = start.state
            self.lay(i, start.frame, ground.shape.furrow_depth_m)
            numbers = self.blocks[i]
            lay_soil(numbers[block.SOIL :], ground.preset, ground.own, ground.law)
            for at in self.front_grip:
                numbers[at] = self.front_ratio * PRESETS[ground.preset].front_grip
            for name, value in _place(ground, start.along_m).items():
                numbers[block.FIELD + name] = value
            self.drivers[i], self.pedals[i] = start.driver, start.pedal
            self.standing_s[i] = 0.0
        self.batch.forward(np.array(ids, dtype=np.int32), stage=VELOCITY)

    def lay(self, i: int, frame: GroundFrame, furrow_depth_m: float) -> None:
        """Slope the ground under one tractor, and give its last furrow its depth."""
        self.world_from_ground[i], self.ground_quat[i] = frame.world_from_ground, frame.quaternion
        first = block.FIELD + Field.AHEAD  # ahead, left and normal stand one after the other
        self.blocks[i, first : first + 9] = frame.world_from_ground.T.ravel()
        self.blocks[i, block.FIELD + Field.FURROW_DEPTH_M] = furrow_depth_m
        if self.machine.scenario.plough is not None:
            edge_m = furrow_edge_m(self.machine.numbers, furrow_depth_m)
            self.blocks[i, block.FIELD + Field.FURROW_EDGE_M] = edge_m

    def drive(self, actions: Array, *, record: bool) -> Record | None:
        """One control step: the driver steers, the actions set throttle and hitch.

        Args:
            actions: in [-1, 1], (nsim, 2); `act` says what they mean.
            record: return what was recorded after each physics step.

        Raises:
            Diverged: a state is not finite, or MuJoCo warned; put the tractors back to a start.
        """
        self.act(actions)
        records = None
        if record:
            records = self.run(RECORDED)
            self.batch.forward(stage=VELOCITY)
        else:
            self.ring.keep(self.state)
            self._step()
        if not moved(
            self.state, self.warned, self.velocity, self.standing_s, self.period_s, STALL_MPS
        ):
            self.refuse_failure()
        return records

    def _step(self) -> None:
        """Step, and bring sensors and slots up to date."""
        if self.sensed:
            self.batch.step(nstep=self.steps, stage=VELOCITY)
            return
        self.disabled[:] = self.flags | NO_SENSORS  # a tenth of a step
        self.batch.step(None, self.steps)
        self.disabled[:] = self.flags
        self.batch.forward(None, VELOCITY)

    def act(self, actions: Array) -> None:
        """Set the controls: throttle and hitch by the actions, the rest by the driver.

        The driver brakes where the ground drives the engine above what the throttle asks for.
        """
        set_levers(actions, self.levers, self.tasks, self.work_rad)
        np.arcsin(self.work_rad, out=self.work_rad)
        self.control()

    def control(self) -> None:
        """Observe, decide, and set the controls."""
        control(
            self.work_rad, self.tasks, self.drivetrain, self.seen, self.drivers, self.pedals,
            self.qpos, self.qvel, self.slots, self.world_from_ground, self.links, self.engine,
            self.controls, self.chosen, self.into, self.ctrl, self.period_s,
        )  # fmt: skip

    def look(self, ids: Ids, out: Array) -> None:
        """What is true now of some tractors, a row for each of `twin.env.quantities.TRUE`."""
        true(*self.reported, self.driven, ids, out)
        powers(ids, LEAST_W, out)

    def true(self) -> dict[str, Array]:
        """What is true now of each tractor, by name."""
        out = np.empty((len(TRUE), len(self.state)))
        self.look(self.every, out)
        return dict(zip(TRUE, out, strict=True))

    def speed_mps(self) -> Array:
        """Magnitude of the rear axle's velocity. Shape (nsim,)."""
        x, y, z = self.velocity
        return np.asarray(np.sqrt(x * x + y * y + z * z))

    def steady(self) -> Array:
        """Actions that keep all rolling steadily before an episode. Shape (nsim, 2)."""
        return np.tile([[start_throttle(self.machine), -1.0]], (len(self.state), 1))


def lay_soil(numbers: Array, preset: str, own: Mapping[str, float], law: str) -> None:
    """A preset with a ground's own numbers, under a soil law.

    Args:
        numbers: written, a soil's part of the block.
        preset: the soil's.
        own: its own numbers, those of `SPREAD`.
        law: by which it carries and pulls.
    """
    slots, values = _soil(preset, law)
    numbers[slots] = values
    for name, value in own.items():
        numbers[OWN[name]] = value
    numbers[SHEARED] *= own["friction"] / PRESETS[preset].friction
    if law == "bekker":
        numbers[Soil.FRICTION] = numbers[Soil.TAN_PHI]


@cache
def _soil(preset: str, law: str) -> tuple[Array, Array]:
    """Which of a soil's numbers a preset sets, and to what; a reset then builds no soil."""
    part = soil_part(Setting(preset=preset, cone_index_kpa=1000.0, law=law))  # its own comes after
    return np.array(list(part)), np.array(list(part.values()))


def _place(ground: Ground, start_m: float) -> Part:
    """The block's numbers of what varies over a field: patches, counted from the start."""
    out: Part = {
        Field.SEED: ground.pattern_seed,
        Field.ORIGIN_S_M: ground.origin_m[0],
        Field.ORIGIN_T_M: ground.origin_m[1],
        Field.PATCH_COUNT: len(ground.patches),
    }
    for i, patch in enumerate(ground.patches):
        begin_m = start_m + patch.start_m
        values = (begin_m, begin_m + patch.length_m, patch.friction_factor, patch.cone_index_factor)
        out |= {Field.PATCHES + 4 * i + k: value for k, value in enumerate(values)}
    return out
