"""Drive a machine along its course; its trajectory in chunks."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from twin.compute import quaternion
from twin.machine.build import Machine
from twin.physics.engine import radps_to_rpm
from twin.scenario.route import LOWERING_M, Leg
from twin.simulation.columns import Record, Recorder
from twin.simulation.driver import HitchControl, Observation, full_depth_m
from twin.simulation.ends import EndMonitor, Progress
from twin.simulation.levers import SetLevers
from twin.simulation.operator import Operator, Way, operated
from twin.simulation.passes import Passes
from twin.simulation.quiet import quiet
from twin.simulation.simulation import DECISION_S, Simulation
from twin.trajectory.end import End, Outcome
from twin.trajectory.phase import Phase
from twin.trajectory.trajectory import Trajectory

CHUNK_DECISIONS = 200


class CourseRun:
    """One machine on its scenario's course: its passes, and how the drive ends."""

    def __init__(self, machine: Machine, set_levers: SetLevers | None = None) -> None:
        self.machine, self.set_levers = machine, set_levers
        self.simulation = Simulation(machine)
        self.drivers_own: dict[str, float] = {}
        """What the task says where a controller does not set the levers."""
        self.last: Record | None = None
        task = self.simulation.tasks[0]
        self.ploughs = bool(task["hitch"] != HitchControl.RAISED)
        least_m, plough = machine.scenario.shallowest_m, machine.scenario.plough
        self.full_depth_m = float(task["full_depth_m"])
        if plough is not None and least_m is not None and least_m < plough.depth_m:
            self.full_depth_m = full_depth_m(least_m, plough.hitch)
        self.driver = self.simulation.drivers[0]
        self.passes = Passes(machine, self.simulation.batch)
        self.decisions, self.deepest_m = 0, 0.0
        self.monitor, self.leg = EndMonitor(machine, DECISION_S), self.passes.legs[0]
        self.seen_from: Leg | None = None
        self.full_from_m, self.home_m = math.inf, math.inf
        self.on_road = machine.scenario.course.road_m > 0.0
        if self.on_road:
            self.monitor.begin_leg()
        self.operator = Operator(self.simulation) if operated(machine.scenario) else None

    def observe(self) -> Observation:
        """Update the driver's observation, relative to the current leg, and return it.

        A leg is a pass or a part of a headland turn (`twin.scenario.route.Leg`). If the current leg
        has ended, the next one starts.
        """
        place = Observation(*self.simulation.observe()[0].item())
        along, left, turned = self.passes.where(place.along_m, place.left_m, place.heading_rad)
        seen = place._replace(
            along_m=along,
            left_m=left,
            heading_rad=turned,
            turning=self.passes.turning,
            curvature_pm=self.passes.curvature_pm(along),
            backing=self.passes.legs[0].back,
        )
        if self.operator is not None:
            seen = self._towards(seen)
        self.simulation.seen[0], self.seen_from = seen, self.passes.legs[0]
        return seen

    def _towards(self, seen: Observation) -> Observation:
        """The same as it is seen by who looks where the machine drives, in its gear."""
        if self.operator is None or (self.operator.way < 0.0) == seen.backing:
            return seen
        return seen._replace(
            left_m=-seen.left_m, curvature_pm=-seen.curvature_pm, backing=not seen.backing
        )

    def act(self) -> Record:
        """Let the driver decide, then simulate 20 ms; gives what each physics step recorded.

        Begins the next leg where one ends. Raises Diverged.
        """
        if self.seen_from is not self.passes.legs[0]:  # else `end` has just looked
            self.observe()
        self.seen_from = None
        for name, value in self.drivers_own.items():
            self.simulation.tasks[0][name] = value
        if self.operator is not None:
            seen = Observation(*self.simulation.seen[0].item())
            self.operator.decide(seen, self.way())
        self._set_levers()
        self.simulation.decide()
        entry = None if self.operator is None else np.array(self.simulation.qvel[:, None])
        record = self.simulation.run()
        shape = record["userdata"].shape[:2]
        record["power_mass_w"] = np.zeros(shape)
        if self.operator is not None and entry is not None:
            brought_w = self.operator.brought_j / self.machine.scenario.timestep_s
            record["entry"], record["power_mass_w"][0, 0] = entry, 0.0 - brought_w
        record["phase"] = np.full(shape, float(self.phase()))
        record["gear_ratio"] = np.full(shape, float(self.simulation.drivetrain["gear_ratio"][0]))
        self.last = record
        return record

    def _set_levers(self) -> None:
        """Let a controller set throttle and hitch for the next decision, where it does."""
        if self.set_levers is None:
            return
        seen, task = self.simulation.seen[0], self.simulation.tasks[0]
        past = seen["along_m"] >= self.machine.scenario.course.approach_m
        pauses = self.operator is not None and (self.operator.pauses or bool(task["lifted"]))
        works = bool(past and not seen["turning"] and not pauses)
        levers = self.set_levers(self.simulation, self.last, works)
        self.drivers_own = {}
        if levers is not None:
            set_to = {"throttle": levers.throttle, "work_rad": levers.lift_rad,
                      "hitch": HitchControl.SET}  # fmt: skip
            self.drivers_own = {name: task[name] for name in set_to}
            for name, value in set_to.items():
                task[name] = value

    def way(self) -> Way:
        """Where on its way the machine is."""
        passes = self.passes
        return Way(self.decisions * DECISION_S, passes.count, passes.legs[0].back, self.on_road)

    def phase(self) -> Phase:
        """What the driver is doing since the last decision."""
        if self.operator is not None and self.operator.stopping:
            return Phase.STOP
        if self.on_road:
            return Phase.ROAD
        working = self.ploughs and bool(self.driver["working"])
        if self.passes.turning or (self.ploughs and self.passes.count > 1 and not working):
            return Phase.TURN
        return Phase.WORK if working else Phase.ROAD

    def end(self) -> End | None:
        """The end of the drive if it has ended, else None; call it once after each decision."""
        self.decisions += 1
        seen, way = self.observe(), self._way()
        self.deepest_m = max(self.deepest_m, seen.depth_m)
        if self.passes.legs[0] is not self.leg:
            self.leg = self.passes.legs[0]
            self.monitor.begin_leg()
        if self.operator is not None and self.operator.pauses:
            self.monitor.begin_leg()
        self.full_from_m = min(self.full_from_m, float(self.driver["full_depth_at_m"]))
        found = self.monitor.look(self._progress(seen))
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

    def _progress(self, seen: Observation) -> Progress:
        axle, way = self.simulation.driven_axle(), 1.0
        if self.operator is not None:
            way = self.operator.way
        return Progress(
            along_m=seen.along_m,
            left_m=seen.left_m,
            follows=self.machine.scenario.course.hold_line and not seen.turning,
            up_b=quaternion.up_b(*self.simulation.qpos[0, 3:7].tolist()),
            rim_mps=way * float(axle.wheel_speed_mps[0]),
            hub_mps=way * float(axle.hub_mps[0]),
            engine_rpm=radps_to_rpm(float(self.simulation.engine_radps[0])),
        )

    def _finished(self, seen: Observation) -> tuple[Outcome, float] | None:
        """The end of the course; at the end of a pass before the last it goes on."""
        if seen.turning:
            return None
        course = self.machine.scenario.course
        if self.on_road:
            return self._home(seen)
        if course.edge_m is not None and self._past_edge(seen, course.edge_m):
            return Outcome.EDGE, seen.along_m
        start = course.approach_m
        if self.ploughs:
            start = min(self.full_from_m, start + LOWERING_M)
        if seen.along_m < start + course.length_m:
            return None
        self.driver["full_depth_at_m"], self.driver["bias_rad"] = math.inf, 0.0
        self.full_from_m = math.inf
        if self.operator is not None:
            self.operator.new_pass()
        if not self.passes.end(seen.along_m):
            return None
        if course.road_m > 0.0:
            self.passes.end_furrow(seen.along_m)
            self.home_m = self.passes.legs[0].s_m + course.road_m
            self.on_road = True
            return None
        return self._driven(seen)

    def _home(self, seen: Observation) -> tuple[Outcome, float] | None:
        """On the road: to the field, where the first pass begins, or back to where it began."""
        if math.isinf(self.home_m):
            self.on_road = seen.along_m < 0.0
            return None
        return self._driven(seen) if seen.along_m >= self.home_m else None

    def _driven(self, seen: Observation) -> tuple[Outcome, float]:
        if self.ploughs and self.deepest_m < self.full_depth_m:
            return Outcome.SHALLOW, self.deepest_m
        return Outcome.DRIVEN, seen.along_m

    def _past_edge(self, seen: Observation, edge_m: float) -> bool:
        """Whether a corner of the machine is beyond the edge, at either side of the line."""
        numbers, across = self.machine.numbers, math.sin(seen.heading_rad)
        half_m = numbers["hull.half_width_m"] * math.cos(seen.heading_rad)
        ends = (seen.left_m + numbers["hull.front_m"] * across,
                seen.left_m - numbers["hull.rear_m"] * across)  # fmt: skip
        return max(max(ends) + half_m, half_m - min(ends)) >= edge_m


def simulate(
    machine: Machine, chunk_decisions: int = CHUNK_DECISIONS, set_levers: SetLevers | None = None
) -> Iterator[Trajectory]:
    """Drive the scenario's course; trajectories of some seconds each, contiguous.

    The last says how the drive ended: at the end of the course, or early (`twin.simulation.ends`)
    where the tractor has rolled over, left its line, got stuck on spinning wheels, slid away on
    skidding ones, run away with an engine far above its no-load speed, or stalled: gained less
    than 0.25 m along a leg of the course in 5 s, whether it stands, rocks or slides. A controller
    may set throttle and hitch in the driver's place.

    Raises:
        Diverged: a state is not finite, or MuJoCo warned.
    """
    run, recorder, end = CourseRun(machine, set_levers), Recorder(machine), None
    while end is None:
        records: list[Record] = []
        with quiet():
            while end is None and len(records) < chunk_decisions:
                records.append(run.act())
                end = run.end()
        yield recorder.trajectory(records, end)
