"""What a run is made of: frozen, typed, checked when made.

Every field can be overridden by name.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange, UnknownName, check_range
from twin.scenario.course import Course, Drive
from twin.scenario.field import Field, check_patches
from twin.scenario.plough import Plough
from twin.scenario.soil import Soil
from twin.sensors import Sensors

MACHINES = {
    "taishan_1404a": "103 kW two-wheel-drive tractor, 5260 kg, with a four-furrow plough",
    "electric_tractor": "1 kW rear-wheel-drive electric tractor, 115 kg, without implement",
}

STEPS_S = (0.0005, 0.001, 0.002)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One run: a machine on a field, what it does, what measures it, and the seed of all chance."""

    name: str
    """Its name, in tables and in the name of the run's folder."""
    about: str = ""
    """What it is, in one line."""
    machine: str = "taishan_1404a"
    """The tractor: taishan_1404a (with a plough) or electric_tractor (without)."""
    soil: Soil = dataclasses.field(default_factory=Soil)
    field: Field = dataclasses.field(default_factory=Field)
    plough: Plough | None = None
    drive: Drive = dataclasses.field(default_factory=Drive)
    course: Course = dataclasses.field(default_factory=Course)
    sensors: Sensors = dataclasses.field(default_factory=Sensors)
    timestep_s: float = 0.002
    """Time step of the physics [s]."""
    seed: int = 0
    """Seed of everything random: ground, sensors, mounting errors."""

    def __post_init__(self) -> None:
        if self.machine not in MACHINES:
            raise UnknownName("machine", self.machine, MACHINES)
        if self.machine == "electric_tractor" and self.plough is not None:
            raise BadInput("machine = electric_tractor has no hitch for a plough")
        if self.machine == "taishan_1404a":
            check_range("drive.engine_set_rpm", self.drive.engine_set_rpm, 900.0, 2400.0)
            if self.course.edge_m is not None:
                raise BadInput("course.edge_m is for the electric_tractor; a field has no edge")
        if self.timestep_s not in STEPS_S:
            raise OutOfRange("timestep_s", self.timestep_s, f"the choices {STEPS_S}")
        if not 0 <= self.seed < 2**31:
            raise OutOfRange("seed", self.seed, "[0, 2147483647]")
        check_patches(self.soil.resolved, self.field.patches)

    @property
    def expected_draft_scale(self) -> float:
        """F of ASABE D497 that the operator expects [-]."""
        believed = None if self.plough is None else self.plough.expected_draft_scale
        return self.soil.resolved.draft_scale if believed is None else believed

    def with_numbers(self) -> Scenario:
        """The same with its presets' numbers filled in, so that later presets do not change it."""
        other = self.field.other_soil.with_numbers()
        ground = dataclasses.replace(self.field, other_soil=other)
        return dataclasses.replace(self, soil=self.soil.with_numbers(), field=ground)
