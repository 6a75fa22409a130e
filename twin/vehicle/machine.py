"""A machine as a data sheet and a weighbridge describe it; a field that is None is derived.

Body axes: x forward, y left, z up, from the middle of the rear axle. Each class is a table of the
machine's TOML file. The rules for None are in `twin.vehicle.derive`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated

from twin.errors import BadInput, OutOfRange, UnknownName
from twin.sensors.checks import Range, check_fields
from twin.vehicle.source import Source, check_grade
from twin.vehicle.tyre_code import tyre_size

SCHEMA = 1
MOST_POINTS = 10
"""Points of a full-load curve, at most: what the parameter block has room for."""
KINDS = ("diesel", "electric")
DRIVEN = ("rear", "all")
TRANSMISSIONS = ("powershift", "synchronised", "cvt", "electric")
Point = tuple[float, float]
Place = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Axle:
    """The two wheels of an axle: one tyre on each side, or a pair."""

    tyre: str | None = None
    """Size code, such as 18.4R38, 480/70R34 or IF 600/70R30."""
    pressure_kpa: Annotated[float | None, Range(40, 600)] = None
    """Inflation pressure."""
    duals: bool = False
    """Two tyres on each side."""
    track_m: Annotated[float | None, Range(0.2, 4)] = None
    """Distance between the middle planes of the two wheels."""
    width_m: Annotated[float | None, Range(0.02, 1.5)] = None
    """Section width of one tyre."""
    diameter_m: Annotated[float | None, Range(0.1, 3)] = None
    """Outer diameter, not loaded."""
    radial: bool | None = None
    """True for radial, False for bias; None to take it from the size code."""
    free_rolling_radius_m: Annotated[float | None, Range(0.05, 1.5)] = None
    """Rolling radius without load."""
    rolling_radius_m: Annotated[float | None, Range(0.05, 1.5)] = None
    """Rolling radius under the load in work, which estimators get as nominal radius."""
    deflection_ratio: Annotated[float | None, Range(0.02, 0.4)] = None
    """Deflection over section height in Brixius' mobility number [-]."""
    stiffness_npm: Annotated[float | None, Range(5e3, 2e6)] = None
    """Vertical stiffness of one tyre."""
    damping_nspm: Annotated[float | None, Range(50, 5e4)] = None
    relaxation_long_m: Annotated[float | None, Range(0.01, 1)] = None
    relaxation_lat_m: Annotated[float | None, Range(0.01, 3)] = None
    lateral_ratio: Annotated[float | None, Range(0.1, 2)] = None
    """Lateral over longitudinal slip stiffness [-]."""
    shear_damping_s: Annotated[float | None, Range(0.005, 1)] = None
    wheel_kg: Annotated[float | None, Range(0.5, 2000)] = None
    """Mass of one wheel with rim and tyre; of both wheels of a pair."""


@dataclass(frozen=True, kw_only=True)
class Ballast:
    """A weight that hangs on the machine."""

    mass_kg: Annotated[float, Range(0, 10000)]
    x_m: Annotated[float, Range(-3, 8)]
    """Distance ahead of the rear axle."""
    z_m: Annotated[float, Range(-2, 3)] = 0.0
    """Height above the rear axle."""
    name: str = "weight"


@dataclass(frozen=True, kw_only=True)
class Engine:
    """Diesel or electric motor."""

    kind: str = "diesel"
    """diesel or electric."""
    rated_power_kw: Annotated[float | None, Range(0.05, 1000)] = None
    """Power at the crankshaft, at rated speed."""
    pto_power_kw: Annotated[float | None, Range(0.05, 1000)] = None
    """Power at the power take-off (PTO), at rated engine speed; in place of rated_power_kw."""
    max_power_kw: Annotated[float | None, Range(0.05, 1200)] = None
    """Greatest power at the crankshaft, at any speed."""
    rated_rpm: Annotated[float | None, Range(300, 8000)] = None
    rated_torque_nm: Annotated[float | None, Range(0.5, 10000)] = None
    torque_rise: Annotated[float | None, Range(1, 2)] = None
    """Peak torque over rated torque [-]."""
    peak_rpm: Annotated[float | None, Range(100, 8000)] = None
    """Engine speed at the peak torque."""
    torque_points: tuple[Point, ...] = ()
    """Full-load curve as measured: speed [rpm] and torque [N m] of each point, by rising speed."""
    no_load_rpm: Annotated[float | None, Range(300, 9000)] = None
    droop: Annotated[float | None, Range(0.002, 0.3)] = None
    """Governor's droop: no-load speed / rated speed - 1; in place of no_load_rpm."""
    idle_rpm: Annotated[float | None, Range(0, 3000)] = None
    usual_rpm: Annotated[float | None, Range(100, 9000)] = None
    """No-load speed that the governor is set to where a scenario gives none."""
    parasitic_nm: Annotated[float | None, Range(0, 500)] = None
    """Torque of fan, pumps and generator."""
    inertia_kgm2: Annotated[float | None, Range(1e-4, 50)] = None
    displacement_l: Annotated[float | None, Range(0.1, 40)] = None
    stroke_m: Annotated[float | None, Range(0.03, 0.3)] = None
    exhaust_brake_kpa: Annotated[float | None, Range(0, 600)] = None
    pto_efficiency: Annotated[float | None, Range(0.5, 1)] = None
    """PTO power over crankshaft power [-]."""
    fuel_l_per_kwh: Annotated[float | None, Range(0.15, 1)] = None
    """Fuel over PTO energy at rated PTO power [L/kWh]."""
    regeneration_kw: Annotated[float | None, Range(0, 500)] = None
    """Greatest power that an electric motor can regenerate."""
    wheel_torque_nm: Annotated[float | None, Range(0.1, 1e5)] = None
    """Torque limit of the electric motor of each rear wheel; None without wheel motors."""
    battery_kwh: Annotated[float | None, Range(0.01, 2000)] = None
    """Energy of the battery. No run drains it; `twin machine show` prints how long it lasts."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName("engine.kind", self.kind, KINDS)


@dataclass(frozen=True, kw_only=True)
class Transmission:
    """Gears between crankshaft and rear axle."""

    kind: str | None = None
    """How the ratio changes: powershift, synchronised, cvt or electric. None means electric for an
    electric motor, cvt if cvt_ratio is given, synchronised if gears are given, else powershift."""
    ratios: tuple[float, ...] = ()
    """Engine turns per turn of the rear axle, of each gear."""
    speeds_kmh: tuple[float, ...] = ()
    """Speed of each gear at rated engine speed without slip; in place of ratios."""
    cvt_ratio: tuple[float, float] | None = None
    """Least and greatest ratio of a continuously variable transmission."""
    usual_ratio: Annotated[float | None, Range(3, 1000)] = None
    """Ratio that is used where a scenario gives none."""
    efficiency: Annotated[float | None, Range(0.4, 1)] = None

    def __post_init__(self) -> None:
        if self.kind is not None and self.kind not in TRANSMISSIONS:
            raise UnknownName("transmission.kind", self.kind, TRANSMISSIONS)
        if self.kind == "cvt" and (self.ratios or self.speeds_kmh):
            raise BadInput(
                "transmission.kind = cvt has no gears; cvt_ratio = [least, greatest] would do"
            )
        if self.kind != "cvt" and self.kind is not None and self.cvt_ratio is not None:
            raise BadInput(f"transmission.kind = {self.kind} has no cvt_ratio; kind = cvt would do")


@dataclass(frozen=True, kw_only=True)
class Drive:
    """Driven axles, differential and clutch; a torque that is None is derived by a rule."""

    driven: str = "rear"
    """rear: only the rear axle is driven; all: the front axle can be engaged too."""
    front_lead: Annotated[float | None, Range(-0.2, 0.2)] = None
    """Front rim speed / rear rim speed - 1, with the front axle engaged."""
    front_ratio: Annotated[float | None, Range(0.5, 4)] = None
    """Turns of the front axle per turn of the rear; in place of front_lead."""
    differential_lock: bool = True
    """Whether the rear differential can be locked."""
    clutch_nm: Annotated[float | None, Range(0.5, 20000)] = None
    """Greatest torque that the clutch transmits before it slips, at the engine [N m]."""
    lock_nm: Annotated[float | None, Range(1, 1e6)] = None
    """Greatest torque that the differential lock transmits between the half-axles [N m]."""
    front_nm: Annotated[float | None, Range(1, 1e6)] = None
    """Greatest torque that the front-axle drive transmits, at the front axle [N m]."""

    def __post_init__(self) -> None:
        if self.driven not in DRIVEN:
            raise UnknownName("drive.driven", self.driven, DRIVEN)


@dataclass(frozen=True, kw_only=True)
class Chassis:
    """Brakes, steering and the front axle's pivot."""

    brake_nm: Annotated[float | None, Range(1, 1e6)] = None
    """Greatest torque of the brake of one rear wheel [N m]."""
    steer_limit_rad: Annotated[float | None, Range(0.1, 1.2)] = None
    """Largest steering angle of a front wheel [rad]."""
    swing_limit_rad: Annotated[float | None, Range(0.02, 0.5)] = None
    """Largest swing of the front axle to each side [rad]."""


@dataclass(frozen=True, kw_only=True)
class Linkage:
    """The three-point linkage; pivots are ahead of and above the rear axle."""

    fitted: bool = True
    lower_link_m: Annotated[float | None, Range(0.2, 2)] = None
    """Length of the lower links."""
    lower_pivot_m: Point | None = None
    """x and z of their front pivots."""
    top_pivot_m: Point | None = None
    """x and z of the top link's upper hole on the tractor."""
    lift_n: Annotated[float | None, Range(200, 3e5)] = None
    """Lifting force at the ends of the lower links [N]."""


@dataclass(frozen=True, kw_only=True)
class Places:
    """Positions of the sensors in body axes, from the rear-axle centre [m]."""

    gnss_main_m: Place | None = None
    gnss_aux_m: Place | None = None
    imu_m: Place | None = None
    camera_m: Place | None = None


@dataclass(frozen=True, kw_only=True)
class Numeric:
    """A value that replaces a <numeric> of a hand-made MJCF."""

    name: str
    """Name of the <numeric>, as `tyre_rear.free_rolling_radius_m`."""
    value: float


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A tractor as its file describes it; what is None is derived by a rule (`twin machine show`).

    `mass_kg` is without implement and without the listed ballast; the axle loads include that
    ballast.
    """

    schema: int = SCHEMA
    """Version of the file's format."""
    name: str = "machine"
    about: str = ""
    """One line of description."""
    grade: str = "given"
    """Grade of all numbers of the file for which `sources` has no entry."""
    source: str = ""
    """Source of all numbers of the file for which `sources` has no entry."""
    mjcf: str | None = None
    """A hand-made MJCF in the file's folder, used in place of a generated one."""
    numerics: tuple[Numeric, ...] = ()
    """Values that replace numerics of the hand-made MJCF, for instance from a calibration."""
    implement: str | None = None
    """Default implement: a name or a file; None for a plough that fits the power."""
    mass_kg: Annotated[float | None, Range(20, 60000)] = None
    front_axle_kg: Annotated[float | None, Range(5, 40000)] = None
    rear_axle_kg: Annotated[float | None, Range(5, 40000)] = None
    wheelbase_m: Annotated[float | None, Range(0.3, 6)] = None
    cg_height_m: Annotated[float | None, Range(0.05, 3)] = None
    """Height of the centre of gravity above the ground [m]."""
    length_m: Annotated[float | None, Range(0.5, 12)] = None
    width_m: Annotated[float | None, Range(0.2, 6)] = None
    height_m: Annotated[float | None, Range(0.2, 6)] = None
    rear_axle_height_m: Annotated[float | None, Range(0.05, 1.5)] = None
    """Height of the rear axle above the ground on loaded tyres [m], by tape; only a check."""
    front: Axle = dataclasses.field(default_factory=Axle)
    rear: Axle = dataclasses.field(default_factory=Axle)
    ballast: tuple[Ballast, ...] = ()
    engine: Engine = dataclasses.field(default_factory=Engine)
    transmission: Transmission = dataclasses.field(default_factory=Transmission)
    drive: Drive = dataclasses.field(default_factory=Drive)
    chassis: Chassis = dataclasses.field(default_factory=Chassis)
    linkage: Linkage = dataclasses.field(default_factory=Linkage)
    places: Places = dataclasses.field(default_factory=Places)
    sources: tuple[Source, ...] = ()
    """Grade and source of the numbers that the file writes as `{value, grade, source}`."""
    folder: str = ""
    """Folder of the file; empty for a machine that comes with the package."""

    def __post_init__(self) -> None:
        if self.schema != SCHEMA:
            raise OutOfRange("schema", self.schema, f"what is known: {SCHEMA}")
        check_grade("grade", self.grade)
        if not self.name or not self.name.replace("_", "").replace("-", "").isalnum():
            raise BadInput(f"name = '{self.name}': letters, digits, _ and - would do")
        for part in (f.name for f in dataclasses.fields(self)):
            held = getattr(self, part)
            if isinstance(held, (Axle, Engine, Transmission, Drive, Chassis, Linkage, Places)):
                check_given(part, held)
        for i, weight in enumerate(self.ballast):
            check_given(f"ballast.{i}", weight)
        check_given("", self)
        if self.mjcf is None:
            if self.numerics:
                raise BadInput("numerics need a hand-made MJCF; the fields of the file would do")
            _check_needed(self)
        for axle in ("front", "rear"):
            if (code := getattr(self, axle).tyre) is not None:
                tyre_size(code, f"{axle}.tyre")
        _check_curve(self.engine)
        _check_gears(self.transmission)


def check_given(prefix: str, config: object) -> None:
    """Raise OutOfRange for a field of `config` that is not None and lies outside its Range.

    `prefix` stands before the field's name in the message.
    """
    check_fields(prefix, config, given_only=True)


def _check_needed(machine: Machine) -> None:
    """What no rule can derive."""
    for name, why in (("mass_kg", "the weighbridge's"), ("wheelbase_m", "the data sheet's")):
        if getattr(machine, name) is None:
            raise BadInput(f"{name} is missing; {why} would do")
    for name in ("front", "rear"):
        axle: Axle = getattr(machine, name)
        if axle.tyre is None and (axle.width_m is None or axle.diameter_m is None):
            raise BadInput(
                f"{name}.tyre is missing; a size code such as 18.4R38, or {name}.width_m and "
                f"{name}.diameter_m, would do"
            )
    engine = machine.engine
    if engine.kind == "electric":
        if engine.max_power_kw is None and engine.rated_power_kw is None:
            raise BadInput("engine.rated_power_kw is missing; the motor's would do")
    elif engine.rated_power_kw is None and not (engine.pto_power_kw or engine.torque_points):
        raise BadInput(
            "engine.rated_power_kw is missing; it, engine.pto_power_kw or engine.torque_points "
            "would do"
        )
    if engine.rated_rpm is None:
        raise BadInput("engine.rated_rpm is missing; the data sheet's would do")


def _check_curve(engine: Engine) -> None:
    points = engine.torque_points
    if not points:
        return
    if not 2 <= len(points) <= MOST_POINTS:
        raise OutOfRange("engine.torque_points: number", len(points), f"[2, {MOST_POINTS}]")
    for i, (rpm, torque) in enumerate(points):
        if i and rpm <= points[i - 1][0]:
            raise BadInput(
                f"engine.torque_points.{i} = {rpm:g} rpm does not rise from {points[i - 1][0]:g}; "
                "pairs [rpm, N m] by rising speed would do"
            )
        if not 0.0 < torque < 20000.0:
            raise OutOfRange(f"engine.torque_points.{i}: torque", f"{torque:g}", "(0, 20000) N m")


def _check_gears(transmission: Transmission) -> None:
    given = [n for n in ("ratios", "speeds_kmh", "cvt_ratio") if getattr(transmission, n)]
    if len(given) > 1:
        raise BadInput(
            f"transmission.{given[0]} and transmission.{given[1]} contradict each other; one of "
            "them would do"
        )
    for name, low, high in (("ratios", 3.0, 3000.0), ("speeds_kmh", 0.1, 100.0)):
        for i, value in enumerate(getattr(transmission, name)):
            if not low <= value <= high:
                raise OutOfRange(f"transmission.{name}.{i}", f"{value:g}", f"[{low:g}, {high:g}]")
    if (cvt := transmission.cvt_ratio) is not None and not 3.0 <= cvt[0] < cvt[1] <= 3000.0:
        raise OutOfRange(
            "transmission.cvt_ratio", f"{cvt[0]:g}, {cvt[1]:g}", "two rising ratios in [3, 3000]"
        )
