"""What a run is made of: frozen, typed, checked when made.

Every field can be overridden by name.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

from twin.errors import BadInput, OutOfRange, UnknownName
from twin.scenario.course import Course, Drive
from twin.scenario.driver import Driver
from twin.scenario.events import Event
from twin.scenario.field import Field, check_patches
from twin.scenario.gear import Gear, gear
from twin.scenario.gearbox import Gearbox, gearbox
from twin.scenario.plough import Plough
from twin.scenario.possible import refuse_impossible
from twin.scenario.soil import Soil
from twin.sensors import Sensors
from twin.streams import ZERO_SLIPS
from twin.vehicle import Implement, Machine, files
from twin.vehicle.implement import NONE
from twin.vehicle.numerics import Facts, machine_facts

POWERS_KW = (
    (52.0, "plough_2"), (85.0, "plough_3"), (140.0, "plough_1lf435"), (math.inf, "plough_6"),
)  # fmt: skip
"""The plough of a machine whose file names no implement, up to a power."""
STEPS_S = (0.0005, 0.001, 0.002)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One run: a machine on a field, what it does, what measures it, and the seed of all chance."""

    name: str
    """Name of the scenario, in tables and in the name of the run's folder."""
    about: str = ""
    """Description in one line."""
    machine: str = files.USUAL
    """The tractor: a name of `twin list`, a TOML file, or a MJCF with the documented numerics."""
    implement: str | None = None
    """The implement: a name of `twin list`, a TOML file, or none for the tractor alone; None for
    the one that the machine usually has, where a plough is set."""
    soil: Soil = dataclasses.field(default_factory=Soil)
    field: Field = dataclasses.field(default_factory=Field)
    plough: Plough | None = None
    drive: Drive = dataclasses.field(default_factory=Drive)
    course: Course = dataclasses.field(default_factory=Course)
    driver: Driver = dataclasses.field(default_factory=Driver)
    events: tuple[Event, ...] = ()
    """Events on the way: throttle, shifts, stops and more; or a file, with --events."""
    sensors: Sensors = dataclasses.field(default_factory=Sensors)
    timestep_s: float = 0.002
    """Time step of the physics [s]."""
    zero_slip: str = "law"
    """Where slip is zero (ASABE S296): hard-torque, hard-pull, field-torque or field-pull; law for
    the soil law's own zero. The truth's slip and the nominal radii of the set-up follow it."""
    seed: int = 0
    """Seed of everything random: ground, sensors, mounting errors."""
    machine_numbers: Machine | None = None
    """The machine's file as a run has kept it in its scenario.json; None reads it."""
    implement_numbers: Implement | None = None
    """The implement's file, in the same way."""

    def __post_init__(self) -> None:
        if self.implement == NONE:
            object.__setattr__(self, "plough", None)
        elif self.implement is not None and self.plough is None:
            raise BadInput(
                f"implement = {self.implement} is not worked with in scenario '{self.name}'; one "
                "with a plough, such as plough-25cm, would do"
            )
        self._check_machine()
        if self.zero_slip not in ZERO_SLIPS or self.zero_slip == "unknown":
            raise UnknownName("zero_slip", self.zero_slip, set(ZERO_SLIPS) - {"unknown"})
        if self.timestep_s not in STEPS_S:
            raise OutOfRange("timestep_s", self.timestep_s, f"the choices {STEPS_S}")
        if not 0 <= self.seed < 2**31:
            raise OutOfRange("seed", self.seed, "[0, 2147483647]")
        check_patches("soil", self.soil.resolved, self.field.patches)
        if self.field.mixed:
            other = self.field.other_soil.resolved
            check_patches("field.other_soil", other, self.field.patches)
        refuse_impossible(self)

    def _check_machine(self) -> None:
        """What the machine cannot do."""
        facts = self.facts
        _ = self.gear
        if self.plough is not None and not facts.linkage:
            raise BadInput(
                f"machine = {facts.name} has no hitch for a plough; another machine, or "
                "implement = none, would do"
            )
        if self.course.edge_m is not None and "hull.front_m" not in facts.numbers:
            raise BadInput(
                f"course.edge_m needs the outline of the machine, which {facts.name} does not "
                "have; a field has no edge"
            )
        if self.drive.all_wheel_drive and not self.drives_front:
            raise BadInput(
                f"drive.all_wheel_drive = True: {facts.name} has two driven wheels; False would do"
            )
        part = self.implement_file
        if part is None or self.plough is None:
            return
        if part.hitch != "three-point":
            raise BadInput(
                f"implement = {part.name} has hitch = {part.hitch}, which only WheelSlip-v0 pulls; "
                "one with hitch = three-point would do"
            )
        low, high = part.depths_m
        if not low <= self.plough.depth_m <= high:
            raise OutOfRange(
                "plough.depth_m", f"{self.plough.depth_m:g}",
                f"[{low:g}, {high:g}]" + ("" if part.furrow else f", the depths of {part.name}"),
            )  # fmt: skip
        if not part.furrow and self.plough.furrow != "none":
            flat = dataclasses.replace(self.plough, furrow="none")
            object.__setattr__(self, "plough", flat)

    @property
    def drives_front(self) -> bool:
        """Whether the front axle can be engaged; of a hand-made MJCF it is not said."""
        return self.machine_file.mjcf is not None or self.machine_file.drive.driven == "all"

    @cached_property
    def machine_file(self) -> Machine:
        """The machine: as it was kept, or else read."""
        kept = self.machine_numbers
        if kept is not None and kept.name == self.machine:
            return kept
        return files.machine(self.machine)

    @cached_property
    def implement_file(self) -> Implement | None:
        """The implement: as it was kept, or else read; None for the tractor alone."""
        if self.plough is None:
            return None
        kept, name = self.implement_numbers, self.implement
        if name is None:
            name = files.usual_implement(self.machine_file) or usual_plough(self.facts)
        if kept is not None and kept.name == name:
            return kept
        return files.implement(name)

    @property
    def facts(self) -> Facts:
        """What has to be known of the machine."""
        return machine_facts(self.machine_file)

    @property
    def gear(self) -> Gear:
        """The gear and the engine speed that are driven."""
        return gear(self.drive, self.facts)

    @property
    def gearbox(self) -> Gearbox:
        """The gears that the driver can shift to."""
        return gearbox(self.facts, self.gear)

    @property
    def shallowest_m(self) -> float | None:
        """Least depth that the implement is set to, by `plough` and by events; None without one."""
        if self.plough is None:
            return None
        set_m = (e.depth_m for e in self.events if e.depth_m is not None)
        return min((self.plough.depth_m, *set_m))

    @property
    def deepest_m(self) -> float:
        """Depth at which draft and mix lower the implement no further [m]."""
        part = self.implement_file
        if self.plough is None or part is None:
            return 0.0
        return part.depths_m[1] if self.plough.deepest_m is None else self.plough.deepest_m

    @property
    def expected_draft_scale(self) -> float:
        """F of ASABE D497 that the operator expects [-]."""
        believed = None if self.plough is None else self.plough.expected_draft_scale
        return self.soil.resolved.draft_scale if believed is None else believed

    def with_numbers(self) -> Scenario:
        """The same with its presets' numbers filled in, so that later presets do not change it."""
        other = self.field.other_soil.with_numbers()
        ground = dataclasses.replace(self.field, other_soil=other)
        driven = self.gear
        drive = dataclasses.replace(
            self.drive, gear_ratio=driven.ratio, engine_set_rpm=driven.set_rpm, gear_kmh=None
        )
        part = self.implement_file
        return dataclasses.replace(
            self, soil=self.soil.with_numbers(), field=ground, drive=drive,
            machine=self.machine_file.name, machine_numbers=self.machine_file,
            implement=None if part is None else part.name, implement_numbers=part,
        )  # fmt: skip


def usual_plough(facts: Facts) -> str:
    """The plough of a machine whose file names no implement, by its power."""
    power_kw = 1e-3 * facts.numbers["engine.max_power_w"]
    return next(name for most_kw, name in POWERS_KW if power_kw <= most_kw)
