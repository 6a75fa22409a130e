"""Forward model of short logs: the machine itself, driven in a Batch, many parameters side by side.

Every segment is predicted for every set of parameters at once: the compiled machine starts rolling
in its furrow, or with the plough up, runs until it is steady, and its means are what a sensor would
have measured. The ground has no roughness and no variation: what those do is noise of the log.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import MODEL_FIELDS
from numpy.typing import NDArray

from twin.calibration.applied import Values, machine_with, soil_with
from twin.calibration.evidence import Evidence
from twin.calibration.known import known
from twin.machine.build import Machine, assemble
from twin.machine.fuel import fuel_lph
from twin.machine.geometry import geometry
from twin.physics import block
from twin.physics.block import MachineSlot, WheelSlot
from twin.scenario import Course, Drive, Field, Plough, Scenario, Soil
from twin.simulation.braking import BrakePedal
from twin.simulation.build import build
from twin.simulation.course_task import asked_mps, drivetrain
from twin.simulation.quiet import quiet
from twin.simulation.simulate import CourseRun
from twin.simulation.simulation import DECISION_S, Simulation
from twin.vehicle import Implement
from twin.vehicle import Machine as Vehicle
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

SETTLING_S, HOLD_S = 4.0, 1.0
"""Time until a machine is steady, and over which its means are taken [s]."""
AT_WORK_S = 12.0
"""How long after full depth the state is kept from which rollouts begin: depth creeps [s]."""
APPROACH_M = 15.0
LEFT_OUT = ("aabb", "bvh", "rbound")
"""Fields of a model that no force depends on."""
DRAFT = "soil.draft_scale"
READ_OFF = ("engine.fuel_l_per_kwh", "log.reference_torque_nm", "log.wheel_scale")
"""Parameters that change what is measured, and nothing of the drive."""


@dataclass(frozen=True)
class Gear:
    """A gear, and the parameter that is its engine speed without load."""

    ratio: float
    set_name: str = "log.set_rpm"


@dataclass(frozen=True)
class Condition:
    """What is driven alike: all segments of work, or all that are empty, in one gear."""

    working: bool
    gear: Gear


@dataclass(frozen=True)
class Drawn:
    """One drive that a log implies: what is the same in all its segments."""

    machine: Vehicle
    implement: Implement | None
    soil: Soil
    depth_m: float
    all_wheel_drive: bool
    depth_by_laser: bool = False
    """Whether `depth_m` is what the plough's laser reads; else it is the depth of the shares."""
    timestep_s: float = 0.002

    def scenario(self, values: Values, gear: Gear) -> Scenario:
        """The drive with some parameters, in a gear."""
        machine = machine_with(self.machine, values)
        still: dict[str, Any] = {"draft_cv": 0.0, "ripple_cv": 0.0, "strength_cv": 0.0}
        soil = replace(soil_with(self.soil, values), **still)
        part = self.implement
        return Scenario(
            name="calibrate", machine=machine.name, machine_numbers=machine,
            implement=None if part is None else part.name, implement_numbers=part,
            plough=None if part is None else Plough(depth_m=self.depth_m), soil=soil, field=Field(),
            drive=Drive(gear_ratio=gear.ratio, engine_set_rpm=values[gear.set_name],
                        all_wheel_drive=self.all_wheel_drive),
            course=Course(approach_m=APPROACH_M, length_m=5000.0), timestep_s=self.timestep_s,
        )  # fmt: skip


@dataclass(frozen=True)
class Snapshot:
    """A machine rolling steadily: where rollouts begin."""

    state: Array
    driver: np.void
    asked_mps: float
    """Speed of its rims without load."""
    laser_depth_m: float = math.nan
    """Working depth as the plough's laser reads it; NaN with the plough up."""


@dataclass
class Rollouts:
    """The model: what every segment measures, for many sets of parameters."""

    drawn: Drawn
    names: tuple[str, ...]
    evidence: Evidence
    conditions: tuple[Condition, ...]
    """Of each segment."""
    radii_m: tuple[float, float]
    """Nominal rolling radii in front and behind, by which the log has speeds."""
    begin: Array
    """Parameters of the machine whose steady rolling is where all rollouts begin. Shape (p,)."""
    nthread: int = 1
    fixed: dict[str, float] = field(default_factory=dict)
    """Parameters that are not fitted."""

    def __post_init__(self) -> None:
        self.measured, self.covariance = self.evidence.measured, self.evidence.covariance
        self.time_s, self.floor = self.evidence.time_s, self.evidence.floor
        self._started: tuple[Machine, dict[bool, Snapshot]] | None = None
        self._simulations: dict[int, tuple[Simulation, set[str]]] = {}

    def foretold(self, values: Array) -> Array:
        """The channels in all segments for parameters (k, p): shape (k, n, c)."""
        return self._driven(self._sets(values), self.conditions)

    def under_load(self, values: Array, gear: Gear, shares: Sequence[float]) -> Array:
        """The channels at work for parameters (k, p) and shares (m,) of the draft: (k, m, c).

        NaN where a machine does not pull so much.
        """
        usual = self.drawn.soil.resolved.draft_scale
        loaded = [v | {DRAFT: min(share * v.get(DRAFT, usual), known(DRAFT).high)}
                  for v in self._sets(values) for share in shares]  # fmt: skip
        found = self._driven(loaded, (Condition(True, gear),))
        return found.reshape(len(values), len(shares), -1)

    def _sets(self, values: Array) -> list[dict[str, float]]:
        return [self.fixed | dict(zip(self.names, row.tolist(), strict=True)) for row in values]

    def _driven(self, sets: list[dict[str, float]], conditions: tuple[Condition, ...]) -> Array:
        """The channels in some conditions: shape (k, n, c)."""
        moved = [tuple(x for n, x in v.items() if n not in READ_OFF) for v in sets]
        of_drive = list(dict.fromkeys(moved))
        drives = [sets[moved.index(each)] for each in of_drive]
        driven = list(dict.fromkeys(conditions))
        machine, snapshots = self._start()
        gears = list(dict.fromkeys(c.gear for c in driven))
        made = {g: [assemble(self.drawn.scenario(v, g)) for v in drives] for g in gears}
        machines = [made[c.gear][i] for i in range(len(drives)) for c in driven]
        count = len(machines)
        if count not in self._simulations:
            self._simulations[count] = Simulation(machine, count, self.nthread), set()
        simulation, own = self._simulations[count]
        working = [c.working for c in driven] * len(drives)
        _prepare(simulation, own, machines, [snapshots[w] for w in working], working)
        with quiet():
            slots = _means(simulation).reshape(len(drives), len(driven), -1)
        found = self._channels(sets, slots[[of_drive.index(each) for each in moved]])
        return found[:, [driven.index(c) for c in conditions]]

    def _start(self) -> tuple[Machine, dict[bool, Snapshot]]:
        if self._started is None:
            (values,) = self._sets(self.begin[None])
            gear = self.conditions[0].gear
            machine = build(self.drawn.scenario(values, gear))
            snapshots = _snapshots(machine)
            if self.drawn.depth_by_laser:  # the tilted frame's laser reads another depth
                deeper_m = self.drawn.depth_m - snapshots[True].laser_depth_m
                self.drawn = replace(self.drawn, depth_m=self.drawn.depth_m + deeper_m)
                machine = build(self.drawn.scenario(values, gear))
                snapshots = _snapshots(machine)
            self._started = machine, snapshots
        return self._started

    def _channels(self, sets: list[dict[str, float]], means: Array) -> Array:
        """From means of slots (k, n, slots) to the channels of the log."""
        wheels = means[..., : block.MACHINE_SLOTS].reshape(*means.shape[:2], 4, -1)
        machine = means[..., block.MACHINE_SLOTS : block.POWER_SLOTS]
        rate = wheels[..., WheelSlot.RATE_RADPS]
        engine_radps = machine[..., MachineSlot.ENGINE_RADPS]
        torque_nm = machine[..., MachineSlot.ENGINE_TORQUE_NM]
        front_m, rear_m = self.radii_m
        reference_nm = np.array([v.get("log.reference_torque_nm", 1.0) for v in sets])[:, None]
        wheel_scale = np.array([v.get("log.wheel_scale", 1.0) for v in sets])[:, None]
        numbers = [machine_facts(machine_with(self.drawn.machine, v)).numbers for v in sets]
        fuel = np.array([fuel_lph(n, p, w) for n, p, w in zip(
            numbers, torque_nm * engine_radps, engine_radps, strict=True)])  # fmt: skip
        found = {
            "wheel_speed_mps": rate[..., 2:].mean(axis=-1) * rear_m / wheel_scale,
            "front_speed_mps": rate[..., :2].mean(axis=-1) * front_m / wheel_scale,
            "speed_mps": wheels[..., 2:, WheelSlot.SPEED_X_MPS].mean(axis=-1),
            "engine_radps": engine_radps,
            "engine_load": torque_nm / reference_nm,
            "axle_torque_nm": machine[..., MachineSlot.AXLE_TORQUE_NM],
            "draft_pin_n": machine[..., MachineSlot.DRAFT_N],
            "fuel_lph": fuel,
        }
        return np.stack([found[c] for c in self.evidence.channels], axis=-1)


def _snapshots(machine: Machine) -> dict[bool, Snapshot]:
    """A machine as it rolls with the plough up, and as it ploughs steadily."""
    run = CourseRun(machine)
    simulation, kept = run.simulation, {}

    def keep(laser_depth_m: float = math.nan) -> Snapshot:
        return Snapshot(simulation.state[0].copy(), simulation.drivers[0].copy(),
                        asked_mps(machine), laser_depth_m)  # fmt: skip

    with quiet():
        for _ in range(round(AT_WORK_S / DECISION_S)):
            run.act()
        kept[False] = keep()
        if machine.scenario.plough is None:
            return {False: kept[False], True: kept[False]}
        while not math.isfinite(run.driver["full_depth_at_m"]):
            run.act()
        heights_m = []
        for _ in range(round(AT_WORK_S / DECISION_S)):
            run.act()
            heights_m.append(_laser_height_m(simulation))
        hold = round(HOLD_S / DECISION_S)
        kept[True] = keep(geometry(machine).depth_zero_m - float(np.mean(heights_m[-hold:])))
    return kept


def _laser_height_m(simulation: Simulation) -> float:
    """Height of the plough's laser above level ground."""
    first = int(simulation.machine.model.sensor("plough.laser_w").adr[0])
    return float(simulation.batch.bind("sensordata")[0, first + 2])


def _prepare(
    simulation: Simulation, own: set[str], machines: list[Machine], starts: list[Snapshot],
    working: list[bool],
) -> None:  # fmt: skip
    """Put every machine of the Batch at its start, as fast as its throttle and gear ask for.

    One that is too fast would brake, and not be steady for long. Nothing is left of the rollout
    before; `own` are the fields of the model that each machine has for itself by now.
    """
    warm = simulation.batch.bind("qacc_warmstart")
    base = simulation.machine.model
    own.update(_differing(base, [m.model for m in machines]))
    for name in own:
        simulation.batch.expand(name)[:] = [getattr(m.model, name) for m in machines]
    for i, (machine, start) in enumerate(zip(machines, starts, strict=True)):
        simulation.batch.warning[i] = 0
        simulation.state[i], warm[i] = start.state, 0.0
        simulation.qvel[i] *= asked_mps(machine) / start.asked_mps
        simulation.drivers[i] = start.driver
        simulation.drivetrain[i] = tuple(drivetrain(machine))
        simulation.pedals[i] = tuple(BrakePedal())
        simulation.tasks[i]["throttle"] = machine.throttle
        simulation.tasks[i]["approach_m"] = APPROACH_M if working[i] else math.inf
    simulation.batch.forward()


def _differing(base: mujoco.MjModel, models: list[mujoco.MjModel]) -> list[str]:
    """Names of the fields in which one of the models is another than the base."""
    out = ["numeric_data"]
    for name in MODEL_FIELDS:
        own = getattr(base, name, None)
        if (
            name.startswith("opt.") or name in out or any(w in name for w in LEFT_OUT)
            or not isinstance(own, np.ndarray) or own.dtype.kind != "f"
        ):  # fmt: skip
            continue
        same = own.tobytes()
        if any(getattr(m, name).tobytes() != same for m in models):
            out.append(name)
    return out


def _means(simulation: Simulation) -> Array:
    """Means of all slots over the hold, after settling. NaN where a machine failed."""
    for _ in range(round(SETTLING_S / DECISION_S)):
        _advance(simulation)
    kept = [_advance(simulation) for _ in range(round(HOLD_S / DECISION_S))]
    means = np.mean(kept, axis=0)
    means[simulation.warned.any(axis=1)] = np.nan
    return np.asarray(means)


def _advance(simulation: Simulation) -> Array:
    simulation.observe()
    simulation.decide()
    simulation.batch.step(nstep=simulation.steps)
    return np.array(simulation.slots)
