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


FURROW_SIDES = {"right": -1, "none": 0, "left": 1}
HITCH_MODES = ("depth", "position", "draft", "float")
ROUGHNESS = {"smooth": 0.0, **{c: 16e-6 * 4.0**i for i, c in enumerate("ABCDEF")}}
"""G_d(n0) at n0 = 0.1 cycles/m [m3]: geometric means of ISO 8608's classes."""
MOST_PATCHES = 4
STEPS_S = (0.0005, 0.001, 0.002)


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
    ripple_cv: float = 0.08
    """Coefficient of variation of one share's draft by shear failure, wave by wave [-]."""
    strength_cv: float | None = None
    """Coefficient of variation of friction and cone index with place [-]."""
    rocks_per_100m2: float = 0.0
    """How many rocks lie in the plough's way."""
    rock_kn: float = 15.0
    """Extra draft of a rock at its peak [kN]."""

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
        check_range("soil.ripple_cv", self.ripple_cv, 0.0, 0.5)
        check_range("soil.strength_cv", resolved.strength_cv, 0.0, 0.3)
        check_range("soil.rocks_per_100m2", self.rocks_per_100m2, 0.0, 25.0)
        check_range("soil.rock_kn", self.rock_kn, 0.0, 50.0)

    def resolved(self) -> Preset:
        """The preset with this soil's own numbers in place."""
        own = {
            name: value
            for name in ("friction", "cone_index_kpa", "draft_scale", "strength_cv")
            if (value := getattr(self, name)) is not None
        }
        return dataclasses.replace(PRESETS[self.preset], **own)


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A stretch of the course where the soil differs."""

    start_m: float
    """Where it begins, along the course [m]."""
    length_m: float
    friction_factor: float = 1.0
    """Friction there, over that of the soil around."""
    cone_index_factor: float = 1.0
    """Cone index there, over that of the soil around."""

    def __post_init__(self) -> None:
        check_range("patch.start_m", self.start_m, -1000.0, 10000.0)
        check_range("patch.length_m", self.length_m, 0.5, 10000.0)
        check_range("patch.friction_factor", self.friction_factor, 0.1, 2.0)
        check_range("patch.cone_index_factor", self.cone_index_factor, 0.1, 4.0)


@dataclass(frozen=True, kw_only=True)
class Field:
    """The shape of the ground."""

    cross_slope_deg: float = 0.0
    """Slope across the course [deg]; positive rises to the left."""
    grade_deg: float = 0.0
    """Slope along the course [deg]; positive rises ahead."""
    roughness_class: str = "smooth"
    """Roughness of the surface by ISO 8608, A to F; "smooth" is a plane."""
    patches: tuple[Patch, ...] = ()
    """Stretches of other soil, four at most; overlapping ones multiply."""

    def __post_init__(self) -> None:
        check_range("field.cross_slope_deg", self.cross_slope_deg, -25.0, 25.0)
        check_range("field.grade_deg", self.grade_deg, -15.0, 15.0)
        if len(self.patches) > MOST_PATCHES:
            raise OutOfRange("field.patches", len(self.patches), f"0 to {MOST_PATCHES} patches")
        if self.roughness_class not in ROUGHNESS:
            raise UnknownName("roughness class", self.roughness_class, ROUGHNESS)


@dataclass(frozen=True, kw_only=True)
class Plough:
    """How the plough is set."""

    depth_m: float = 0.25
    """Working depth [m]."""
    wheel_share: float = 0.48
    """Share of the plough's weight and downward soil force the depth wheel is set to carry [-]."""
    furrow: str = "right"
    """Side whose wheels run in the last furrow: right, left, or none. A reversible plough turns
    over at the headland, so the side alternates from pass to pass."""
    hitch: str = "depth"
    """How the hitch is controlled: depth (the operator trims it), position, draft or float."""

    def __post_init__(self) -> None:
        if self.furrow not in FURROW_SIDES:
            raise UnknownName("furrow side", self.furrow, FURROW_SIDES)
        if self.hitch not in HITCH_MODES:
            raise UnknownName("hitch mode", self.hitch, HITCH_MODES)
        check_range("plough.depth_m", self.depth_m, 0.05, 0.35)
        check_range("plough.wheel_share", self.wheel_share, 0.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Drive:
    """How the tractor is driven: one gear, one throttle setting, held through the run."""

    gear_ratio: float = 66.0
    """Engine turns per turn of the rear axle [-]."""
    engine_set_rpm: float = 1665.0
    """No-load speed the governor is set to [rpm]."""
    all_wheel_drive: bool = False
    """Engage the front axle."""
    differential_lock: bool = True
    """Turn both rear wheels together."""

    def __post_init__(self) -> None:
        check_range("drive.gear_ratio", self.gear_ratio, 15.0, 300.0)
        check_range("drive.engine_set_rpm", self.engine_set_rpm, 900.0, 2400.0)


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
    timestep_s: float = 0.002
    """Time step of the physics [s]."""
    seed: int = 0

    def __post_init__(self) -> None:
        if self.machine not in MACHINES:
            raise UnknownName("machine", self.machine, MACHINES)
        if self.timestep_s not in STEPS_S:
            raise OutOfRange("timestep_s", self.timestep_s, f"the choices {STEPS_S}")
        if not 0 <= self.seed < 2**31:
            raise OutOfRange("seed", self.seed, "[0, 2147483647]")
