"""Tractors that plough in one Batch, each on a soil and with a draft pattern of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from twin.env.grounds import SPREAD, Ground, Lie
from twin.env.quantities import Ids, ahead_w, dot, powers, true
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.machine.geometry import geometry
from twin.machine.ground_frame import quaternion, world_from_ground
from twin.machine.parameters import furrow_edge_m, soil_part
from twin.physics import block
from twin.physics.block import Field, Soil, Wheel
from twin.scenario import Course
from twin.scenario import Soil as Setting
from twin.scenario.soils import PRESETS
from twin.simulation.braking import Foot, brakes, press, set_radps
from twin.simulation.columns import Recorder
from twin.simulation.driver import LIFT_RATE_RADPS, ackermann, steer, towards
from twin.simulation.guard import Diverged
from twin.simulation.simulate import CONTROLS, DECISION_S
from twin.streams import WHEELS
from twin.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

RAISED_M = -0.10
"""Depth set point at which the plough is carried: the shares this much above the ground [m]."""
DEEPEST_M = 0.35
"""Deepest depth set point [m]."""
OWN = {name: block.SOIL + Soil[name.upper()] for name in SPREAD}
"""Where the block has a ground's own numbers of its soil."""
SHEARED = [block.SOIL + Soil.COHESION_PA, block.SOIL + Soil.TAN_PHI]
"""Where it has what friction scales in Bekker's law."""
SLOWEST_RPM, FASTEST_RPM = 900.0, 2376.0
"""No-load engine speeds between which the throttle sets the governor [rpm]."""


@dataclass(frozen=True)
class Axes:
    """How the ground lies under a tractor."""

    world_from_ground: Array
    """Rotation matrix (3, 3)."""
    quaternion: Array
    """The same, wxyz (4,)."""

    @classmethod
    def of(cls, lie: Lie, course: Course) -> Axes:
        """Those of a field that a course crosses."""
        rotation = world_from_ground(lie.field(), course)
        return cls(rotation, quaternion(rotation))


@dataclass(frozen=True)
class Start:
    """Where an episode begins: rolling steadily, the plough carried just above the ground."""

    state: Array
    """MuJoCo's whole state (nstate,)."""
    axes: Axes
    approach: Trajectory | None
    """What led there, for sensors and filters to settle on; None where nobody looks."""
    along_m: float
    """How far along the course it stands [m]."""
    steer_rad: float
    lift_rad: float
    foot: Foot
    action: tuple[float, float]
    """The action that keeps it rolling so."""


def lift_rad(machine: Machine, depth_set_m: Any) -> Any:
    """Lower-link angle that puts the plough's sole at a depth, in the furrow; elementwise.

    The wheels of one side run at working depth, so the axle's middle is half of it lower.

    angle = asin((sole below hitch - depth - axle height - link pivot height) / link length)
    """
    hitch = machine.hitch
    if hitch is None:
        raise BadInput(f"{machine.scenario.machine} has no hitch; choose a machine that ploughs")
    sole_m = machine.numbers["plough.sole_below_hitch_m"]
    axle_m = float(machine.model.body("tractor").pos[2])
    plough = machine.scenario.plough
    if plough is not None and plough.furrow != "none":
        axle_m -= 0.5 * plough.depth_m
    rise_m = sole_m - depth_set_m - axle_m - hitch.lower_front[1]
    return np.arcsin(np.maximum(-1.0, np.minimum(1.0, rise_m / hitch.lower_length_m)))


def governor(machine: Machine, throttle: Any) -> Any:
    """Control of a throttle action in [-1, 1], linear in the no-load speed it sets; elementwise."""
    idle, top = (machine.numbers[f"engine.{n}_rpm"] for n in ("idle", "no_load"))
    set_rpm = SLOWEST_RPM + 0.5 * (throttle + 1.0) * (FASTEST_RPM - SLOWEST_RPM)
    return (set_rpm - idle) / (top - idle)


def start_throttle(machine: Machine) -> float:
    """The throttle action that sets the scenario's engine speed."""
    set_rpm = machine.scenario.drive.engine_set_rpm
    return 2.0 * (set_rpm - SLOWEST_RPM) / (FASTEST_RPM - SLOWEST_RPM) - 1.0


def depth_set_m(hitch: Any) -> Any:
    """Depth set point of a hitch action in [-1, 1]; elementwise [m]."""
    return RAISED_M + 0.5 * (hitch + 1.0) * (DEEPEST_M - RAISED_M)


def resting(nsim: int) -> Foot:
    """Feet of so many drivers that have pressed nothing yet."""
    return Foot(np.zeros(nsim), np.zeros(nsim), np.zeros(nsim), np.zeros(nsim))


class Fleet:
    """The machines of an environment: the only part of it whose physics changes."""

    def __init__(self, machine: Machine, nsim: int = 1, nthread: int = 1) -> None:
        self.machine = machine
        model = machine.model
        self.ground = model.geom("ground").id
        model.geom_sameframe[self.ground] = 0  # it is turned by the slope of each tractor's field
        self.batch = Batch(model, nsim=nsim, nthread=nthread)
        self.blocks = self.batch.expand("numeric_data")[:, -block.SIZE :]
        self.ground_quat = self.batch.expand("geom_quat")[:, self.ground]
        self.state = self.batch.state
        self.qpos, self.qvel = self.batch.bind("qpos"), self.batch.bind("qvel")
        self.ctrl, self.slots = self.batch.bind("ctrl"), self.batch.bind("userdata")
        self.sensordata = self.batch.bind("sensordata")
        self.period_s = DECISION_S
        self.steps = round(DECISION_S / model.opt.timestep)
        has = {model.actuator(i).name for i in range(model.nu)}
        self.controls = {name: model.actuator(name).id for name in CONTROLS if name in has}
        named = Recorder(machine).sensors
        self.velocity_w = self.sensordata[:, named["velocity_w"]]
        self.world_from_body = self.sensordata[:, named["world_from_body"]]
        self.world_from_ground = np.repeat(machine.world_from_ground[None], nsim, axis=0)
        self.track_m = 2.0 * float(model.body("fl_knuckle").pos[1])
        self.wheelbase_m = float(model.body("front_axle").pos[0])
        self.driven = np.array([WHEELS.index(w) for w in geometry(machine).driven])
        self.everyone = np.arange(nsim)
        self.steer_rad, self.lift_rad = np.zeros(nsim), np.zeros(nsim)
        self.brakes, self.foot = brakes(machine), resting(nsim)
        self.engine = int(model.joint("drive").dofadr[0])
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
            self.lay(i, start.axes, ground.lie.furrow_depth_m)
            numbers = self.blocks[i]
            slots, values = _soil(ground.preset)
            numbers[slots] = values
            for name, value in ground.own.items():
                numbers[OWN[name]] = value
            numbers[SHEARED] *= ground.own["friction"] / PRESETS[ground.preset].friction
            for at in self.front_grip:
                numbers[at] = self.front_ratio * PRESETS[ground.preset].front_grip
            for name, value in _place(ground, start.along_m).items():
                numbers[block.FIELD + name] = value
            self.steer_rad[i], self.lift_rad[i] = start.steer_rad, start.lift_rad
            for name, value in vars(start.foot).items():
                getattr(self.foot, name)[i] = value
        self.batch.forward(np.array(ids, dtype=np.int32), stage=mujoco.mjtStage.mjSTAGE_VEL.value)

    def lay(self, i: int, axes: Axes, furrow_depth_m: float) -> None:
        """Slope the ground under one tractor, and give its last furrow its depth."""
        self.world_from_ground[i], self.ground_quat[i] = axes.world_from_ground, axes.quaternion
        first = block.FIELD + Field.AHEAD  # ahead, left and normal stand one after the other
        self.blocks[i, first : first + 9] = axes.world_from_ground.T.ravel()
        self.blocks[i, block.FIELD + Field.FURROW_DEPTH_M] = furrow_depth_m
        if self.machine.scenario.plough is not None:
            edge_m = furrow_edge_m(self.machine.numbers, furrow_depth_m)
            self.blocks[i, block.FIELD + Field.FURROW_EDGE_M] = edge_m

    def drive(self, actions: Array, *, record: bool) -> dict[Any, NDArray[Any]] | None:
        """One control step: the driver steers, the actions set the levers.

        Args:
            actions: in [-1, 1], (nsim, 2); `levers` says what they mean.
            record: return what was recorded after each physics step.

        Raises:
            Diverged: MuJoCo warned; the tractors have to be put back to the start.
        """
        self._set(actions)
        now, records = mujoco.mjtStage.mjSTAGE_VEL.value, None
        if record:
            records = self.batch.rollout(self.steps, record=("sensordata", "userdata"))
            self.batch.forward(stage=now)
        else:
            self.batch.step(nstep=self.steps, stage=now)
        if self.batch.warning[:, :, 1].any():
            tractor, warning = np.argwhere(self.batch.warning[:, :, 1])[0].tolist()
            raise Diverged(
                f"MuJoCo warned ({mujoco.mjtWarning(warning).name}) of tractor {tractor}"
            )
        return records

    def true(self, ids: Ids | None = None) -> dict[str, Array]:
        """What is true now of each tractor, or of some; see `twin.env.quantities`."""
        now = self.motion(self.everyone if ids is None else ids)
        return now | powers(now)

    def motion(self, ids: Ids) -> dict[str, Array]:
        """The same without powers; see `twin.env.quantities.true`."""
        normal_w = self.world_from_ground[:, :, 2]
        velocity_w, attitude = self.velocity_w, self.world_from_body
        return true(ids, self.slots, velocity_w, attitude, normal_w, self.driven)

    def speed_mps(self) -> Array:
        """Magnitude of the rear axle's velocity, (nsim,)."""
        velocity = self.qvel[:, :3].T
        return np.sqrt(dot(velocity, velocity))

    def rolling(self) -> Array:
        """Actions that keep all rolling steadily before an episode, (nsim, 2)."""
        return np.tile([[start_throttle(self.machine), -1.0]], (len(self.steer_rad), 1))

    def levers(self, actions: Array) -> dict[str, Any]:
        """What throttle and hitch set, by actuator; the hitch follows at its own rate.

        The driver brakes where the ground drives the engine above what the throttle asks for.
        """
        wanted = lift_rad(self.machine, depth_set_m(actions[:, 1]))
        self.lift_rad = towards(self.lift_rad, wanted, LIFT_RATE_RADPS * self.period_s)
        drive, throttle = self.machine.scenario.drive, governor(self.machine, actions[:, 0])
        engine_radps = drive.gear_ratio * self.qvel[:, self.engine]
        asked_radps = set_radps(self.machine, throttle)
        self.foot = press(self.brakes, self.foot, engine_radps, asked_radps, self.period_s)
        return {
            "throttle": throttle,
            "clutch_pedal": 0.0,
            "brake": self.foot.pedal,
            "lift": self.lift_rad,
            "differential_lock": float(drive.differential_lock),
            "front_drive": float(drive.all_wheel_drive),
        }

    def _set(self, actions: Array) -> None:
        """Controls of all tractors for the next control step: the line held, the levers set."""
        x, y = self.world_from_ground[:, :, 0].T, self.world_from_ground[:, :, 1].T
        ahead = ahead_w(self.qpos[:, 3:7])
        left_m, heading = dot(self.qpos[:, :3].T, y), np.arctan2(dot(ahead, y), dot(ahead, x))
        self.steer_rad = steer(self.wheelbase_m, self.steer_rad, left_m, heading, self.period_s)
        left, right = ackermann(self.steer_rad, self.wheelbase_m, self.track_m)
        levers = {"steer_left": left, "steer_right": right} | self.levers(actions)
        for name, value in levers.items():
            self.ctrl[:, self.controls[name]] = value


@cache
def _soil(preset: str) -> tuple[Array, Array]:
    """Which of the block's numbers a preset sets, and to what; a reset then builds no soil."""
    part = soil_part(Setting(preset=preset, cone_index_kpa=1000.0))  # the ground's own comes after
    return block.SOIL + np.array(list(part)), np.array(list(part.values()))


def _place(ground: Ground, start_m: float) -> dict[Any, float]:
    """The block's numbers of what varies over a field: patches, counted from the start."""
    out: dict[Any, float] = {
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
