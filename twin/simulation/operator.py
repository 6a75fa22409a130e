"""The driver who shifts, stops and backs up: events and habits on a machine that runs."""

from __future__ import annotations

import math
from typing import NamedTuple

from twin.physics import block
from twin.physics.block import Key, MachineSlot
from twin.physics.engine import full_load_torque_nm, radps_to_rpm
from twin.scenario import Scenario
from twin.simulation.agenda import Agenda, Now
from twin.simulation.cab import Cab, Felt, Gears, operate
from twin.simulation.driver import HitchControl, Observation, full_depth_m
from twin.simulation.gear_change import Driveline
from twin.simulation.simulation import DECISION_S, Simulation
from twin.simulation.tanks import Tanks

LONGEST_SLIP_S = 10.0
"""Time for which a machine whose clutch slips may make no way [s]: longer it is stalled."""
TORQUE = block.MACHINE_SLOTS + int(MachineSlot.ENGINE_TORQUE_NM)


def operated(scenario: Scenario) -> bool:
    """Whether anything changes in a drive but the steering and the hitch."""
    backs = scenario.course.passes > 1 and scenario.course.headland == "backing"
    return backs or bool(scenario.events) or not scenario.driver.plain


class Way(NamedTuple):
    """Where on its way the machine is."""

    time_s: float
    number: int
    """Which pass."""
    backing: bool
    """Whether the way leads backwards."""
    on_road: bool


class Operator:
    """Hands and feet of the driver of one machine."""

    def __init__(self, simulation: Simulation) -> None:
        machine = simulation.machine
        scenario, numbers = machine.scenario, machine.numbers
        box = scenario.gearbox
        known = simulation.drivetrain[0]
        self.simulation, self.scenario = simulation, scenario
        self.gears = Gears(
            kind=box.kind, ratios=box.ratios, idle_rpm=numbers["engine.idle_rpm"],
            no_load_rpm=numbers["engine.no_load_rpm"],
            rim_m=numbers["tyre_rear.free_rolling_radius_m"],
            pedal_per_mps2=float(known["pedal_per_mps2"]), reaction_s=scenario.driver.reaction_s,
            pause_s=scenario.driver.pause_s,
            shifts=scenario.driver.shifts,
        )  # fmt: skip
        self.driveline = Driveline(simulation)
        self.agenda = Agenda(scenario, self.gears, box.start, machine.throttle)
        self.cab = Cab(ratio=box.start, throttle=machine.throttle)
        self.task = simulation.tasks[0]
        self.depth_rad = float(self.task["work_rad"])
        self.depth_m, self.hitch = float(self.task["depth_m"]), int(self.task["hitch"])
        self.approach_m = float(self.task["approach_m"])
        self.way_m, self.on_road, self.slipping_s = 0.0, False, 0.0
        fills = any(e.mass_kg is not None for e in scenario.events)
        self.tanks, self.brought_j = Tanks(simulation) if fills else None, 0.0
        if scenario.driver.starts_standing:
            self._stand()

    def _stand(self) -> None:
        """At a stand, the engine at idle, the clutch open."""
        self.cab = self.cab._replace(throttle=0.0, grip=0.0, brake=1.0, standing=True)
        simulation = self.simulation
        simulation.qvel[0] = 0.0
        idle_radps = self.gears.idle_rpm * math.pi / 30.0
        simulation.qvel[0, simulation.engine] = idle_radps / self.driveline.ratio

    @property
    def stopping(self) -> bool:
        """Whether an event makes the machine stop, or stand."""
        return self.agenda.standing

    @property
    def way(self) -> float:
        """1 ahead, -1 back."""
        return math.copysign(1.0, self.cab.ratio)

    @property
    def pauses(self) -> bool:
        """Whether no progress is to be expected: standing, backing, or about to set off."""
        cab, agenda = self.cab, self.agenda
        if agenda.standing or agenda.back is not None or cab.standing or cab.key != Key.RUN:
            return True
        return 0.0 < self.slipping_s < LONGEST_SLIP_S

    def felt(self) -> Felt:
        """What the driver feels now."""
        simulation = self.simulation
        rpm = float(radps_to_rpm(float(simulation.engine_radps[0])))
        torque_nm = float(simulation.slots[0, TORQUE])
        most_nm = float(full_load_torque_nm(self.driveline.engine, rpm))
        axle = simulation.driven_axle()
        rim_mps, speed_mps = float(axle.wheel_speed_mps[0]), float(axle.hub_mps[0])
        load = torque_nm / max(most_nm, 1e-3 * abs(torque_nm), 1e-9)
        return Felt(rpm, speed_mps, load, rim_mps)

    def decide(self, seen: Observation, way: Way) -> None:
        """Set the tasks of the interval, and the gear that is driven in it."""
        felt, self.on_road = self.felt(), way.on_road
        self.way_m += felt.speed_mps * DECISION_S
        rim, hub = felt.rim_mps, felt.speed_mps
        now = Now(
            time_s=way.time_s, along_m=seen.along_m, count=way.number, turning=seen.turning,
            backing=way.backing, on_road=way.on_road, speed_mps=felt.speed_mps, way_m=self.way_m,
            quantities={
                "engine_rpm": felt.engine_rpm, "load": felt.load,
                "slip": (rim - hub) / max(abs(rim), abs(hub), 0.05), "depth_m": seen.depth_m,
                "speed_kmh": 3.6 * abs(hub), "draft_kn": 1e-3 * seen.draft_n,
            },
        )  # fmt: skip
        orders = self.agenda.orders(now, DECISION_S)
        self.cab = operate(self.gears, orders, self.cab, felt, DECISION_S)
        self.driveline.change(self.cab.ratio)
        slips = self.cab.grip < 1.0 or orders.clutch_pedal > 0.0 or orders.brake_pedal > 0.0
        self.slipping_s = self.slipping_s + DECISION_S if slips else 0.0
        self.driveline.turn_key(self.cab.key)
        self._fill()
        self._set_task(seen, orders.clutch_pedal, orders.brake_pedal)

    def _fill(self) -> None:
        """What flows into tanks and out of them in the interval."""
        self.brought_j = 0.0
        for tank, left_kg in self.agenda.filling_kg.items():
            if left_kg != 0.0 and self.tanks is not None:
                most = self.agenda.rate_kgps[tank] * DECISION_S
                flow = max(-most, min(most, left_kg))
                self.agenda.filling_kg[tank] = left_kg - flow
                self.brought_j += self.tanks.fill(tank, flow)

    def _set_task(self, seen: Observation, clutch_pedal: float, brake_pedal: float) -> None:
        task, cab, agenda = self.task, self.cab, self.agenda
        task["throttle"] = cab.throttle
        task["clutch_pedal"] = max(1.0 - cab.grip, clutch_pedal)
        task["brake_pedal"] = max(cab.brake, brake_pedal)
        if agenda.front_drive is not None:
            task["front_drive"] = agenda.front_drive
        if agenda.lock is not None:
            task["differential_lock"] = agenda.lock
        if self.hitch == HitchControl.RAISED:
            return
        task["lifted"] = agenda.raised or cab.ratio < 0.0 or agenda.back is not None
        if self.on_road:
            task["lifted"] = True
        if agenda.lowered and not seen.turning and seen.along_m < float(task["approach_m"]):
            task["approach_m"] = seen.along_m
            agenda.lowered = False
        if agenda.depth_m is not None and float(task["depth_m"]) != agenda.depth_m:
            self._set_depth(agenda.depth_m)

    def _set_depth(self, depth_m: float) -> None:
        """Another working depth: the lever, the draft that is held, and what counts as full."""
        task, plough = self.task, self.scenario.plough
        assert plough is not None
        hitch = self.simulation.machine.hitch
        assert hitch is not None
        rise = math.sin(self.depth_rad) - (depth_m - self.depth_m) / hitch.lower_length_m
        task["work_rad"] = math.asin(max(-1.0, min(1.0, rise)))
        task["draft_n"] *= depth_m / float(task["depth_m"])
        task["depth_m"] = depth_m
        task["full_depth_m"] = full_depth_m(depth_m, plough.hitch)

    def new_pass(self) -> None:
        """Lowered again at its place."""
        self.task["approach_m"] = self.approach_m
