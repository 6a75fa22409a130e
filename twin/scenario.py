"""What a run is made of: frozen, typed, checked when made.

Every field can be overridden by name.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from twin.errors import OutOfRange, UnknownName, check_range
from twin.sensors import Sensors
from twin.soils import LAWS, PRESETS, Preset

MACHINES = {"taishan_1404a": "103 kW two-wheel-drive tractor, 5260 kg, with a four-furrow plough"}


@dataclass(frozen=True, kw_only=True)
class Soil:
    """The ground's material. What is None follows the preset."""

    preset: str = "firm"
    """One of twin.soils.PRESETS."""
    law: str = "brixius"
    """Tyre-soil law."""
    friction: float | None = None
    """Ceiling of the gross traction ratio [-]; 0.88 in Brixius."""
    cone_index_kpa: float | None = None
    """Cone index [kPa]; soft 450, tilled 900, firm 1200."""
    draft_scale: float | None = None
    """F of ASABE D497 [-]; coarse 0.45, medium 0.70, fine 1.00."""
    draft_cv: float = 0.12
    """Coefficient of variation of one share's draft with place [-]."""
    draft_length_m: float = 4.0
    """Distance between independent values of the draft's variation [m]."""

    def __post_init__(self) -> None:
        if self.preset not in PRESETS:
            raise UnknownName("soil preset", self.preset, PRESETS)
        if self.law not in LAWS:
            raise UnknownName("soil law", self.law, LAWS)
        resolved = self.resolved()
        check_range("soil.friction", resolved.friction, 0.05, 1.5)
        check_range("soil.cone_index_kpa", resolved.cone_index_kpa, 50.0, 5000.0)
        check_range("soil.draft_scale", resolved.draft_scale, 0.0, 2.0)
        check_range("soil.draft_cv", self.draft_cv, 0.0, 0.5)
        check_range("soil.draft_length_m", self.draft_length_m, 0.2, 100.0)

    def resolved(self) -> Preset:
        """The preset with this soil's own numbers in place."""
        own = {
            name: value
            for name in ("friction", "cone_index_kpa", "draft_scale")
            if (value := getattr(self, name)) is not None
        }
        return dataclasses.replace(PRESETS[self.preset], **own)


@dataclass(frozen=True, kw_only=True)
class Field:
    """The shape of the ground."""

    cross_slope_deg: float = 0.0
    """Slope across the course [deg]; positive rises to the left."""
    grade_deg: float = 0.0
    """Slope along the course [deg]; positive rises ahead."""
    roughness_class: str = "smooth"
    """Roughness of the surface; "smooth" is a plane."""

    def __post_init__(self) -> None:
        check_range("field.cross_slope_deg", self.cross_slope_deg, -25.0, 25.0)
        check_range("field.grade_deg", self.grade_deg, -15.0, 15.0)
        if self.roughness_class != "smooth":
            raise UnknownName("roughness class", self.roughness_class, ("smooth",))


@dataclass(frozen=True, kw_only=True)
class Plough:
    """How the plough is set."""

    depth_m: float = 0.25
    """Working depth [m]."""
    wheel_share: float = 0.4
    """Share of the plough's weight and downward soil force the depth wheel is set to carry [-]."""

    def __post_init__(self) -> None:
        check_range("plough.depth_m", self.depth_m, 0.05, 0.35)
        check_range("plough.wheel_share", self.wheel_share, 0.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Drive:
    """How the tractor is driven: one gear, one throttle setting, held through the run."""

    gear_ratio: float = 66.0
    """Engine turns per turn of the rear axle [-]."""
    engine_set_rpm: float = 1628.0
    """No-load speed the governor is set to [rpm]."""
    all_wheel_drive: bool = False
    """Engage the front axle."""
    differential_lock: bool = True
    """Turn both rear wheels together."""

    def __post_init__(self) -> None:
        check_range("drive.gear_ratio", self.gear_ratio, 15.0, 300.0)
        check_range("drive.engine_set_rpm", self.engine_set_rpm, 900.0, 2376.0)


@dataclass(frozen=True, kw_only=True)
class Course:
    """Where it is driven: a straight line.

    With a plough, an approach first with the plough raised.
    """

    approach_m: float = 15.0
    """Distance before the plough is lowered, or before the scored part [m]."""
    length_m: float = 200.0
    """Length of the scored part; with a plough, the ploughed length [m]."""
    heading_deg: float = 0.0
    """Direction of the line, counter-clockwise from east [deg]."""

    def __post_init__(self) -> None:
        check_range("course.approach_m", self.approach_m, 1.0, 500.0)
        check_range("course.length_m", self.length_m, 1.0, 5000.0)
        check_range("course.heading_deg", self.heading_deg, -180.0, 180.0)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One run: a machine on a field, what it does, what measures it, and the seed of all chance."""

    name: str
    about: str = ""
    machine: str = "taishan_1404a"
    soil: Soil = dataclasses.field(default_factory=Soil)
    field: Field = dataclasses.field(default_factory=Field)
    plough: Plough | None = None
    drive: Drive = dataclasses.field(default_factory=Drive)
    course: Course = dataclasses.field(default_factory=Course)
    sensors: Sensors = dataclasses.field(default_factory=Sensors)
    seed: int = 0

    def __post_init__(self) -> None:
        if self.machine not in MACHINES:
            raise UnknownName("machine", self.machine, MACHINES)
        if not 0 <= self.seed < 2**31:
            raise OutOfRange("seed", self.seed, "[0, 2147483647]")
