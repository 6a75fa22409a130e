"""Drive a machine along its course, and hand out its trajectory in chunks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from twin.machine.build import Machine
from twin.machine.geometry import geometry
from twin.machine.start import raised_rad
from twin.physics import block
from twin.physics.block import MachineSlot
from twin.physics.engine import radps_to_rpm
from twin.scenario.route import LOWERING_M
from twin.simulation.braking import Foot, brakes, press, set_radps
from twin.simulation.columns import RECORDED, Recorder
from twin.simulation.driver import Hands, Observed, Task, ackermann, drive, full_depth_m
from twin.simulation.ends import Moment, Watch, driven_speeds
from twin.simulation.guard import Tape, all_finite, diverged
from twin.simulation.passes import Passes
from twin.simulation.quiet import quiet
from twin.trajectory.end import End, Outcome
from twin.trajectory.trajectory import Trajectory

DECISION_S = 0.02
"""Time between two decisions of the driver; a whole number of physics steps."""
CHUNK_DECISIONS = 50
CONTROLS = (
    "throttle", "clutch_pedal", "brake", "steer_left", "steer_right", "lift",
    "differential_lock", "front_drive",
)  # fmt: skip
DEPTH_SLOT = block.MACHINE_SLOTS + int(MachineSlot.DEPTH_M)
DRAFT_SLOT = block.MACHINE_SLOTS + int(MachineSlot.DRAFT_N)


def _has_actuator(model: Any, name: str) -> bool:
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)) >= 0


def task(machine: Machine) -> Task:
    """What the driver of a machine is to do."""
    plough, model = machine.scenario.plough, machine.model
    bare = Task(
        wheelbase_m=float(model.body("front_axle").pos[0]),
        approach_m=machine.scenario.course.approach_m,
        depth_m=None,
        raised_rad=raised_rad(machine.scenario),
        work_rad=machine.work_rad,
        throttle=machine.throttle,
    )
    if plough is None or machine.setting is None:
        return bare
    return replace(
        bare,
        depth_m=plough.depth_m,
        work_rad=machine.setting.lever_rad,
        hitch=plough.hitch,
        mix=plough.mix,
        draft_n=machine.setting.draft_n,
        sensitivity_rad=plough.sensitivity_rad,
        lowest_rad=machine.setting.lowest_rad,
        drop_rate_radps=plough.drop_rate_radps,
    )


class Cab:
    """One simulation with its driver: the only object of a run with a state that changes."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        model = machine.model
        self.batch = Batch(model, nsim=1, nthread=1)
        self.qpos, self.qvel = self.batch.bind("qpos"), self.batch.bind("qvel")
        self.ctrl, self.userdata = self.batch.bind("ctrl"), self.batch.bind("userdata")
        self.state, self.warned = self.batch.state[0], self.batch.warning[0, :, 1]
        self.tape = Tape(len(self.state), DECISION_S)
        self.dt_s = float(model.opt.timestep)
        self.steps = round(DECISION_S / self.dt_s)
        self.controls = {n: model.actuator(n).id for n in CONTROLS if _has_actuator(model, n)}
        self.track_m = 2.0 * float(model.body("fl_knuckle").pos[1])
        self.task = task(machine)
        self.hands = Hands(lift_rad=self.task.raised_rad)
        self.links = None if machine.hitch is None else int(model.joint("lift").qposadr[0])
        self.brakes, self.foot = brakes(machine), Foot()
        self.asked_radps = float(set_radps(machine, machine.throttle))
        self.shaft = model.joint("drive").dofadr[0]
        self.passes = Passes(machine, self.batch)
        self.decisions, self.deepest_m = 0, 0.0
        self.watch, self.leg = Watch(machine, DECISION_S), self.passes.legs[0]
        self.driven = [block.WHEELS.index(wheel) for wheel in geometry(machine).driven]
        self._start_rolling()

    def _start_rolling(self) -> None:
        model, machine = self.machine.model, self.machine
        self.qpos[0], self.batch.bind("act")[0] = machine.start_qpos, machine.start_act
        speed = machine.start_speed_mps
        self.qvel[0, :3] = machine.world_from_ground @ np.array([speed, 0.0, 0.0])
        for wheel in block.WHEELS:
            axle = "front" if wheel[0] == "f" else "rear"
            radius = machine.numbers[f"tyre_{axle}.free_rolling_radius_m"]
            self.qvel[0, model.joint(f"{wheel}_spin").dofadr[0]] = speed / radius
        rear_m = machine.numbers["tyre_rear.free_rolling_radius_m"]
        self.qvel[0, self.shaft] = speed / rear_m

    @property
    def engine_radps(self) -> float:
        """Speed of the engine now."""
        return float(self.machine.scenario.drive.gear_ratio * self.qvel[0, self.shaft])

    def observe(self) -> Observed:
        """What the driver sees now."""
        rotation = self.machine.world_from_ground
        position = rotation.T @ self.qpos[0, :3]
        w, x, y, z = self.qpos[0, 3:7]
        ahead = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
        ahead = rotation.T @ ahead
        heading_rad = math.atan2(ahead[1], ahead[0])
        along, left, turned = self.passes.where(float(position[0]), float(position[1]), heading_rad)
        return Observed(
            along_m=along,
            left_m=left,
            heading_rad=turned,
            depth_m=float(self.userdata[0, DEPTH_SLOT]),
            draft_n=float(self.userdata[0, DRAFT_SLOT]),
            hitch_rad=0.0 if self.links is None else float(self.qpos[0, self.links]),
            turning=self.passes.turning,
            curvature_pm=self.passes.curvature_pm(along),
        )

    def act(self) -> dict[Any, NDArray[Any]]:
        """Decide, then run to the next decision; what was recorded after each step.

        Raises:
            Diverged: the state or a slot of it is not finite, or MuJoCo warned.
        """
        self.hands = drive(self.task, self.hands, self.observe(), DECISION_S)
        if not self.machine.scenario.course.hold_line:
            self.hands = replace(self.hands, steer_rad=0.0)
        self.foot = press(self.brakes, self.foot, self.engine_radps, self.asked_radps, DECISION_S)
        left, right = ackermann(self.hands.steer_rad, self.task.wheelbase_m, self.track_m)
        levers = self.machine.scenario.drive
        values = (
            self.task.throttle, 0.0, self.foot.pedal, left, right, self.hands.lift_rad,
            float(levers.differential_lock and self.hands.working), float(levers.all_wheel_drive),
        )  # fmt: skip
        for name, value in zip(CONTROLS, values, strict=True):
            if name in self.controls:
                self.ctrl[0, self.controls[name]] = value
        self.tape.keep(self.state)
        record = self.batch.rollout(self.steps, record=RECORDED)
        self._refuse_failure(record["userdata"])
        return record

    def _refuse_failure(self, slots: NDArray[Any]) -> None:
        if not (all_finite(self.state) and all_finite(slots)) or np.count_nonzero(self.warned):
            scenario, model = self.machine.scenario, self.batch.get_model(0)
            raise diverged(scenario, model, self.tape, self.steps)

    def end(self) -> End | None:
        """The end of the drive where it has come after a decision; else None, and it goes on."""
        self.decisions += 1
        seen, way = self.observe(), self._way()
        self.deepest_m = max(self.deepest_m, seen.depth_m)
        if self.passes.legs[0] is not self.leg:
            self.leg = self.passes.legs[0]
            self.watch.begin_leg()
        found = self.watch.look(self._moment(seen))
        if found is None or found[0] is not Outcome.ROLLED_OVER:
            found = self._finished(seen) or found
        if found is None:
            return None
        return End(
            outcome=found[0],
            time_s=self.decisions * DECISION_S,
            along_m=seen.along_m,
            left_m=seen.left_m,
            way=way,
            measured=found[1],
        )

    def _way(self) -> str:
        """What is being driven, in words."""
        if self.machine.scenario.course.passes == 1:
            return "the course"
        return f"{'the turn before ' if self.passes.turning else ''}pass {self.passes.count}"

    def _moment(self, seen: Observed) -> Moment:
        w, x, y, z = self.qpos[0, 3:7]
        rim_mps, hub_mps = driven_speeds(self.userdata[0], self.driven)
        return Moment(
            along_m=seen.along_m,
            left_m=seen.left_m,
            follows=self.machine.scenario.course.hold_line and not seen.turning,
            up_b=np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]),
            rim_mps=rim_mps,
            hub_mps=hub_mps,
            engine_rpm=radps_to_rpm(self.engine_radps),
        )

    def _finished(self, seen: Observed) -> tuple[Outcome, float] | None:
        """The end of the course; at the end of a pass before the last it goes on."""
        if seen.turning:
            return None
        course = self.machine.scenario.course
        if course.edge_m is not None and self._past_edge(seen, course.edge_m):
            return Outcome.EDGE, seen.along_m
        start = course.approach_m
        if self.task.depth_m is not None:
            start = min(self.hands.full_depth_at_m, start + LOWERING_M)
        if seen.along_m < start + course.length_m:
            return None
        self.hands = replace(self.hands, full_depth_at_m=math.inf, bias_rad=0.0)
        if not self.passes.end(seen.along_m):
            return None
        if self.task.depth_m is not None and self.deepest_m < full_depth_m(
            self.task.depth_m, self.task.hitch
        ):
            return Outcome.SHALLOW, self.deepest_m
        return Outcome.DRIVEN, seen.along_m

    def _past_edge(self, seen: Observed, edge_m: float) -> bool:
        """Whether a corner of the machine is beyond the edge, at either side of the line."""
        numbers, across = self.machine.numbers, math.sin(seen.heading_rad)
        half_m = numbers["hull.half_width_m"] * math.cos(seen.heading_rad)
        ends = (seen.left_m + numbers["hull.front_m"] * across,
                seen.left_m - numbers["hull.rear_m"] * across)  # fmt: skip
        return max(max(ends) + half_m, half_m - min(ends)) >= edge_m


def simulate(machine: Machine, chunk_decisions: int = CHUNK_DECISIONS) -> Iterator[Trajectory]:
    """Drive the scenario's course; trajectories of about a second each, contiguous.

    The last says how the drive ended: at the end of the course, or early (`twin.simulation.ends`)
    where the tractor has rolled over, left its line, got stuck on spinning wheels, slid away on
    skidding ones, run away with an engine far above its no-load speed, or stalled: gained less
    than 0.25 m along a leg of the course in 5 s, whether it stands, rocks or slides.

    Raises:
        Diverged: a state is not finite, or MuJoCo warned.
    """
    cab, recorder, end = Cab(machine), Recorder(machine), None
    while end is None:
        records: list[dict[Any, NDArray[Any]]] = []
        with quiet():
            while end is None and len(records) < chunk_decisions:
                records.append(cab.act())
                end = cab.end()
        yield recorder.trajectory(records, end)
