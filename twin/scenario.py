"""What a run is made of: frozen, typed, checked when made.

Every field can be overridden by name.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from twin.errors import BadInput, OutOfRange, UnknownName, check_range
from twin.sensors import Sensors
from twin.soils import LAWS, PRESETS, Deformable, Preset

MACHINES = {
    "taishan_1404a": "103 kW two-wheel-drive tractor, 5260 kg, with a four-furrow plough",
    "electric_tractor": "1 kW rear-wheel-drive electric tractor, 115 kg, without implement",
}


FURROW_SIDES = {"right": -1, "none": 0, "left": 1}
HITCH_MODES = ("depth", "position", "draft", "mix", "float")
DRAFT_MODES = ("draft", "mix")
"""Those in which the depth follows the draft."""
FRONT_BALLAST_KG = 500.0
"""Front weights of a tractor that carries the whole plough [kg]; assumed, a usual set is 400 to 600
for this class."""
TOP_LINK_DROP_M = 0.15
"""How far below the upper hole the top link is pinned to float [m]; assumed, brackets have three to
five holes over some 0.2 m."""
ROUGHNESS = {"smooth": 0.0, **{c: 16e-6 * 4.0**i for i, c in enumerate("ABCDEF")}}
"""G_d(n0) at n0 = 0.1 cycles/m [m3]: geometric means of ISO 8608's classes."""
MOST_PATCHES = 4
FRICTIONS, CONE_INDICES_KPA = (0.05, 1.5), (50.0, 5000.0)
"""Friction and cone index that a soil may have, on its patches too."""
LEAST_APPROACH_M = 15.0
"""Shortest approach after a turn [m]."""
STEPS_S = (0.0005, 0.001, 0.002)
DEFORMABLE_RANGES = {
    "k_c_kn_per_m_n1": (0.0, 1000.0),
    "k_phi_kn_per_m_n2": (10.0, 1e5),
    "sinkage_exponent": (0.1, 1.6),
    "cohesion_kpa": (0.0, 150.0),
    "friction_angle_deg": (0.0, 50.0),
    "shear_modulus_m": (0.002, 0.2),
    "lateral_shear_ratio": (0.2, 5.0),
    "unit_weight_knpm3": (0.0, 25.0),
    "stress_peak": (0.0, 0.8),
    "stress_peak_slip": (0.0, 0.5),
    "slip_sinkage": (0.0, 5.0),
}
"""Ranges of what Bekker's law needs, somewhat wider than Wong's tables."""
LEAST_BORNE_KPA = 20.0
"""Pressure at 0.1 m sinkage a wheel needs [kPa]; the softest of Wong's soils has 27."""
BORNE_PER_COHESION = 3.0
"""That pressure over the cohesion, at least [-]; 5.1 for a strip on clay (Prandtl)."""
NEEDED = tuple(DEFORMABLE_RANGES)[:6]
"""What of it has no general value."""
KEPT_RANGES = {
    "friction": (0.05, 1.5),
    "front_grip": (0.01, 10.0),
    "slip_rate": (0.1, 100.0),
    "rolling_moment": (0.0, 1.0),
    "mobility_resistance": (0.0, 10.0),
}
"""Ranges of a preset's numbers that are no fields of a soil, or that its fields are set against."""


@dataclass(frozen=True, kw_only=True)
class Soil:
    """The ground's material. What is None follows the preset."""

    preset: str = "firm"
    """One of twin.soils.PRESETS."""
    law: str = "brixius"
    """Tyre-soil law: brixius, bekker, or your own as module:function."""
    friction: float | None = None
    """Ceiling of the gross traction ratio [-]; 0.88 in Brixius. Cohesion and tan(phi) in Bekker's
    law are multiplied by this over the preset's own friction."""
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
    k_c_kn_per_m_n1: float | None = None
    """Bekker's cohesive modulus of deformation [kN/m**(n + 1)]; LETE sand 102."""
    k_phi_kn_per_m_n2: float | None = None
    """Bekker's frictional modulus of deformation [kN/m**(n + 2)]; LETE sand 5301."""
    sinkage_exponent: float | None = None
    """Bekker's exponent n of the sinkage [-]; LETE sand 0.793."""
    cohesion_kpa: float | None = None
    """Cohesion c in Bekker's law [kPa]; LETE sand 1.3."""
    friction_angle_deg: float | None = None
    """Angle of internal friction phi in Bekker's law [deg]; LETE sand 31.1."""
    shear_modulus_m: float | None = None
    """Janosi's shear deformation modulus K in Bekker's law [m]; LETE sand 0.012."""
    lateral_shear_ratio: float | None = None
    """K across the wheel over K along it [-]."""
    unit_weight_knpm3: float | None = None
    """Unit weight of the soil a sideslipping wheel pushes aside, in Bekker's law [kN/m3]."""
    stress_peak: float | None = None
    """c_1 in theta_m = (c_1 + c_2 |s|) theta_1, the place of the greatest normal stress [-]."""
    stress_peak_slip: float | None = None
    """c_2 in it [-]; with both 0 the stress is Bekker's, greatest under the hub."""
    slip_sinkage: float | None = None
    """S in Bekker's law: slip s sinks a wheel 1 + S s times as deep [-]; 1 after Lyasko 2010."""
    numbers: Preset | None = None
    """The preset's own numbers as a run has kept them in its scenario.json; None looks them up."""

    def __post_init__(self) -> None:
        if self.preset not in PRESETS and not self._keeps_preset:
            raise UnknownName("soil preset", self.preset, PRESETS)
        if self.law not in LAWS and ":" not in self.law:
            raise UnknownName("soil law", self.law, LAWS)
        resolved = self.resolved
        check_range("soil.friction", resolved.friction, *FRICTIONS)
        if self.cone_index_kpa is not None or not math.isnan(resolved.cone_index_kpa):
            check_range("soil.cone_index_kpa", resolved.cone_index_kpa, *CONE_INDICES_KPA)
        elif self.law == "brixius":
            raise BadInput(
                f"soil preset '{self.preset}' has no cone index, which Brixius' law needs; "
                "set soil.cone_index_kpa, or soil.law to bekker"
            )
        if resolved.deformable is not None:
            known = PRESETS.get(self.preset)
            if known is None or resolved.deformable is not known.deformable:  # those are in range
                for name, (low, high) in DEFORMABLE_RANGES.items():
                    check_range(f"soil.{name}", getattr(resolved.deformable, name), low, high)
            if self.law == "bekker":
                _check_bearing(resolved.deformable, self.friction_scale)
        elif self.law == "bekker":
            raise BadInput(
                f"soil preset '{self.preset}' has no numbers for Bekker's law; another preset, "
                f"or all of soil.{', soil.'.join(NEEDED)}, would do"
            )
        check_range("soil.draft_scale", resolved.draft_scale, 0.0, 2.0)
        check_range("soil.draft_cv", self.draft_cv, 0.0, 0.5)
        check_range("soil.draft_length_m", self.draft_length_m, 0.2, 100.0)
        check_range("soil.ripple_cv", self.ripple_cv, 0.0, 0.5)
        check_range("soil.strength_cv", resolved.strength_cv, 0.0, 0.3)
        check_range("soil.rocks_per_100m2", self.rocks_per_100m2, 0.0, 25.0)
        check_range("soil.rock_kn", self.rock_kn, 0.0, 50.0)
        if self.numbers is not None:
            for name, (low, high) in KEPT_RANGES.items():
                check_range(f"soil.numbers.{name}", getattr(self.numbers, name), low, high)

    @property
    def _keeps_preset(self) -> bool:
        """Whether the kept numbers are those of the preset; beside another they mean nothing."""
        return self.numbers is not None and self.numbers.name == self.preset

    @property
    def _preset(self) -> Preset:
        kept = self.numbers if self._keeps_preset else None
        return PRESETS[self.preset] if kept is None else kept

    def with_numbers(self) -> Soil:
        """The same soil, which no edit of the preset changes any more."""
        return dataclasses.replace(
            self, numbers=dataclasses.replace(self._preset, name=self.preset)
        )

    @cached_property
    def resolved(self) -> Preset:
        """The preset with this soil's own numbers in place."""
        preset = self._preset
        own = self._given("friction", "cone_index_kpa", "draft_scale", "strength_cv")
        return dataclasses.replace(preset, **own, deformable=self._deformable(preset.deformable))

    @property
    def friction_scale(self) -> float:
        """Friction over the preset's own: what cohesion and tan(phi) are multiplied by [-]."""
        return self.resolved.friction / self._preset.friction

    def _deformable(self, preset: Deformable | None) -> Deformable | None:
        own = self._given(*DEFORMABLE_RANGES)
        if preset is not None:
            return dataclasses.replace(preset, **own) if own else preset
        return Deformable(**own) if own.keys() >= set(NEEDED) else None

    def _given(self, *names: str) -> dict[str, Any]:
        """The named fields that are not None."""
        return {n: value for n in names if (value := getattr(self, n)) is not None}


def _check_bearing(soil: Deformable, friction_scale: float) -> None:
    """Refuse a soil that bears less than a wheel needs, or than its own cohesion lets it bear."""
    borne_kpa = soil.k_phi_kn_per_m_n2 * 0.1**soil.sinkage_exponent
    cohesion_kpa = friction_scale * soil.cohesion_kpa
    least_kpa = max(LEAST_BORNE_KPA, BORNE_PER_COHESION * cohesion_kpa)
    scaled = "" if friction_scale == 1.0 else f" times {friction_scale:.3g} by soil.friction"
    if borne_kpa < least_kpa:
        raise OutOfRange(
            "soil.k_phi_kn_per_m_n2",
            f"{soil.k_phi_kn_per_m_n2:g}",
            f"what this soil can have: at soil.sinkage_exponent {soil.sinkage_exponent:g} it bears "
            f"{borne_kpa:.3g} kPa at 0.1 m, and with soil.cohesion_kpa {soil.cohesion_kpa:g}"
            f"{scaled} at least {least_kpa:.3g} kPa would do",
        )


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


SOFT = Soil(preset="soft")


@dataclass(frozen=True, kw_only=True)
class Field:
    """The shape of the ground."""

    cross_slope_deg: float = 0.0
    """Slope across the course [deg]; positive rises to the left."""
    grade_deg: float = 0.0
    """Slope along the course [deg]; positive rises ahead."""
    roughness_class: str = "smooth"
    """Roughness of the surface by ISO 8608, A to F; "smooth" is a plane."""
    height_map: str | None = None
    """Your own heights above the plane: a .npy file of metres, columns along the course, rows
    across it from the right, its middle on the line. Instead of a roughness class."""
    soil_map: str | None = None
    """Where `other_soil` is: a .npy file of shares from 0 to 1, laid as `height_map`."""
    map_cell_m: float = 0.25
    """Distance between the nodes of your maps [m]."""
    map_start_m: float = -10.0
    """Where their first column lies along the course [m]; past their border its value goes on."""
    other_share: float = 0.0
    """Share of the ground covered by patches of `other_soil`, made from the seed [-]."""
    other_length_m: float = 10.0
    """Size of those patches [m]."""
    other_soil: Soil = SOFT
    """The soil of the map or the patches: its law, friction, strength and scale of the draft. What
    varies with place, and rocks, are those of `soil` everywhere."""
    patches: tuple[Patch, ...] = ()
    """Stretches of other soil, four at most; overlapping ones multiply."""

    def __post_init__(self) -> None:
        check_range("field.cross_slope_deg", self.cross_slope_deg, -25.0, 25.0)
        check_range("field.grade_deg", self.grade_deg, -15.0, 15.0)
        if len(self.patches) > MOST_PATCHES:
            raise OutOfRange("field.patches", len(self.patches), f"0 to {MOST_PATCHES} patches")
        if self.roughness_class not in ROUGHNESS:
            raise UnknownName("roughness class", self.roughness_class, ROUGHNESS)
        if self.height_map is not None and self.roughness_class != "smooth":
            raise BadInput(
                f"field.height_map goes without field.roughness_class = {self.roughness_class}: "
                "the map has its own roughness; leave one of them"
            )
        if self.soil_map is not None and self.other_share > 0.0:
            raise BadInput(
                f"field.soil_map goes without field.other_share = {self.other_share:g}: the map "
                "says where the other soil is; leave one of them"
            )
        check_range("field.map_cell_m", self.map_cell_m, 0.02, 10.0)
        check_range("field.map_start_m", self.map_start_m, -1000.0, 1000.0)
        check_range("field.other_share", self.other_share, 0.0, 0.9)
        check_range("field.other_length_m", self.other_length_m, 1.0, 100.0)


@dataclass(frozen=True, kw_only=True)
class Plough:
    """How the plough is set."""

    depth_m: float = 0.25
    """Working depth [m]."""
    wheel_share: float = 0.48
    """Share of the plough's weight and downward soil force the depth wheel is set to carry in
    depth, position and mix [-]. In float it carries what the links do not; in draft, and a mix of
    1, it is up and touches at `deepest_m`."""
    furrow: str = "right"
    """Side whose wheels run in the last furrow: right, left, or none. A reversible plough turns
    over at the headland, so the side alternates from pass to pass."""
    hitch: str = "depth"
    """How the hitch is controlled: depth (the operator trims it), position (the lever's angle is
    held), draft, mix (of position and draft) or float (the lift carries nothing)."""
    expected_draft_scale: float | None = None
    """F of ASABE D497 on the soil that the operator sets lever, draft and depth wheel for [-]; None
    for the soil's own."""
    draft_mix: float = 0.5
    """What mix follows: 0 the lever's position, 1 the draft [-]."""
    sensitivity_rad: float = 0.03
    """Error of the lower links' angle that a draft of twice the expected counts as [rad]."""
    drop_rate_radps: float = 0.35
    """How fast the lift lowers at most [rad/s]; 0.35 is 0.33 m/s at the hitch points."""
    upper_limit_rad: float = 0.6
    """Angle of the lower links to which the lift raises the plough, and no further [rad]."""
    deepest_m: float = 0.35
    """Depth at which draft and mix lower no further [m]; 0.35 is the plough's greatest."""
    front_ballast_kg: float | None = None
    """Weights on the tractor's front [kg]. None for 500 where the depth wheel is up, so that the
    tractor carries the whole plough and would rear up, and else for none."""
    top_link_drop_m: float | None = None
    """How far below its upper hole the top link is pinned to the tractor [m]; None for 0.15 in
    float, where a steeper link puts more of the plough on the rear wheels, and else 0."""

    def __post_init__(self) -> None:
        if self.furrow not in FURROW_SIDES:
            raise UnknownName("furrow side", self.furrow, FURROW_SIDES)
        if self.hitch not in HITCH_MODES:
            raise UnknownName("hitch mode", self.hitch, HITCH_MODES)
        check_range("plough.depth_m", self.depth_m, 0.05, 0.35)
        check_range("plough.wheel_share", self.wheel_share, 0.0, 1.0)
        if self.expected_draft_scale is not None:
            check_range("plough.expected_draft_scale", self.expected_draft_scale, 0.0, 2.0)
        check_range("plough.draft_mix", self.draft_mix, 0.0, 1.0)
        check_range("plough.sensitivity_rad", self.sensitivity_rad, 0.01, 0.1)
        check_range("plough.drop_rate_radps", self.drop_rate_radps, 0.05, 1.0)
        check_range("plough.upper_limit_rad", self.upper_limit_rad, 0.4, 0.9)
        check_range("plough.deepest_m", self.deepest_m, 0.05, 0.4)
        if self.hitch in DRAFT_MODES and self.deepest_m < self.depth_m:
            raise OutOfRange(
                "plough.deepest_m", f"{self.deepest_m:g}",
                f"[{self.depth_m:g}, 0.4]: no shallower than plough.depth_m",
            )  # fmt: skip
        if self.front_ballast_kg is not None:
            check_range("plough.front_ballast_kg", self.front_ballast_kg, 0.0, 1000.0)
        if self.top_link_drop_m is not None:
            check_range("plough.top_link_drop_m", self.top_link_drop_m, 0.0, 0.25)

    @property
    def ballast_kg(self) -> float:
        """Weights on the tractor's front in this mode."""
        if self.front_ballast_kg is not None:
            return self.front_ballast_kg
        return FRONT_BALLAST_KG if self.wheel_up else 0.0

    @property
    def mix(self) -> float:
        """What the lift follows: 0 the lever's position, or neither; 1 the draft."""
        return {"draft": 1.0, "mix": self.draft_mix}.get(self.hitch, 0.0)

    @property
    def wheel_up(self) -> bool:
        """Whether the depth wheel is up: where nothing but the draft is held."""
        return self.mix == 1.0

    @property
    def drop_m(self) -> float:
        """How far below its upper hole the top link is pinned in this mode."""
        if self.top_link_drop_m is not None:
            return self.top_link_drop_m
        return TOP_LINK_DROP_M if self.hitch == "float" else 0.0


@dataclass(frozen=True, kw_only=True)
class Drive:
    """How the tractor is driven: one gear, one throttle setting, held through the run.

    The driver brakes where the ground drives the engine above that setting.
    """

    gear_ratio: float = 66.0
    """Engine turns per turn of the rear axle [-]."""
    engine_set_rpm: float = 1665.0
    """No-load speed the governor is set to [rpm]."""
    all_wheel_drive: bool = False
    """Engage the front axle."""
    differential_lock: bool = True
    """Turn both rear wheels together."""
    exhaust_brake: bool = False
    """Close the exhaust brake of a diesel while the wheels drive it; an option of the machine."""

    def __post_init__(self) -> None:
        check_range("drive.gear_ratio", self.gear_ratio, 15.0, 300.0)
        check_range("drive.engine_set_rpm", self.engine_set_rpm, 300.0, 3000.0)


@dataclass(frozen=True, kw_only=True)
class Course:
    """Where it is driven: a straight line, or several side by side with turns between.

    With a plough, an approach first with the plough raised.
    """

    approach_m: float = 15.0
    """Distance before the plough is lowered, or before the scored part [m]."""
    length_m: float = 200.0
    """Length of the scored part; with a plough, the ploughed length [m]."""
    passes: int = 1
    """How often the field is crossed, up and down, with turns on the headlands between."""
    heading_deg: float = 0.0
    """Direction of the line, counter-clockwise from east [deg]."""
    start_left_m: float = 0.0
    """Where the rear axle starts, left of the line [m]."""
    hold_line: bool = True
    """Steer along the line; if not, the wheels point straight ahead and the heading is free."""
    edge_m: float | None = None
    """The run ends when a corner of the machine is so far beside the line [m]; None for a field."""
    calibration_m: float = 0.0
    """Drive so far out and back on level ground before the run [m], all the calibration there is;
    the estimators see it, and it is not scored."""

    def __post_init__(self) -> None:
        check_range("course.approach_m", self.approach_m, 0.0, 500.0)
        check_range("course.start_left_m", self.start_left_m, -50.0, 50.0)
        if self.edge_m is not None:
            check_range("course.edge_m", self.edge_m, 0.5, 100.0)
        check_range("course.length_m", self.length_m, 1.0, 5000.0)
        check_range("course.passes", self.passes, 1, 100)
        if self.passes > 1 and self.approach_m < LEAST_APPROACH_M:
            raise OutOfRange(
                "course.approach_m", f"{self.approach_m:g}",
                f"[{LEAST_APPROACH_M:g}, 500] with course.passes = {self.passes}: after a turn the "
                "line has to be found",
            )  # fmt: skip
        if self.passes > 1 and (self.edge_m is not None or not self.hold_line):
            raise BadInput(
                f"course.passes = {self.passes} needs a driver who holds the line on a field "
                "without an edge"
            )
        if self.calibration_m:
            check_range("course.calibration_m", self.calibration_m, 5.0, 500.0)
        check_range("course.heading_deg", self.heading_deg, -180.0, 180.0)


def _check_patches(soil: Preset, patches: tuple[Patch, ...]) -> None:
    """Refuse patches on which the soil would leave the ranges it is held to elsewhere.

    Raises:
        OutOfRange: friction or cone index of the soil times the factors of a patch, and of those
            that overlap it.
    """
    factors = {"friction": FRICTIONS, "cone_index_kpa": CONE_INDICES_KPA}
    for i, patch in enumerate(patches):
        here = [p for p in patches if p.start_m <= patch.start_m < p.start_m + p.length_m]
        for name, (low, high) in factors.items():
            kind = f"{name.removesuffix('_kpa')}_factor"
            factor = math.prod(getattr(p, kind) for p in here)
            value = getattr(soil, name) * factor
            if not (math.isnan(value) or low <= value <= high):
                raise OutOfRange(
                    f"field.patches[{i}].{kind}", f"{factor:g}",
                    f"what soil.{name} = {getattr(soil, name):g} allows: times the factor it is "
                    f"{value:g}, and [{low:g}, {high:g}] would do",
                )  # fmt: skip


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
        _check_patches(self.soil.resolved, self.field.patches)

    @property
    def expected_draft_scale(self) -> float:
        """F of ASABE D497 that the operator expects [-]."""
        believed = None if self.plough is None else self.plough.expected_draft_scale
        return self.soil.resolved.draft_scale if believed is None else believed

    def with_numbers(self) -> Scenario:
        """The same scenario with its presets' numbers in it, so that it stays what was driven."""
        other = self.field.other_soil.with_numbers()
        ground = dataclasses.replace(self.field, other_soil=other)
        return dataclasses.replace(self, soil=self.soil.with_numbers(), field=ground)
