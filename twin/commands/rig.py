"""`twin rig wheel | drawbar | slope | park`: run a test rig; write CSV and a figure.

One module, because the five rigs are options of one command.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from twin.commands.measured import RigOptions, RigResult, print_columns
from twin.commands.output import check_folder
from twin.commands.overrides import named_fields
from twin.commands.parse import parse
from twin.commands.terminal import say, waiting
from twin.errors import BadInput, UnknownName, check_range
from twin.io.plain import Plain
from twin.rig.defaults import PARKED_S, SPEED_MPS, SPEEDS_KMH
from twin.rig.tyre import Tyre
from twin.scenario import Drive, Scenario, Soil
from twin.streams import ZERO_SLIPS
from twin.vehicle.files import USUAL

if TYPE_CHECKING:
    from twin.rig.drawbar import DrawbarCurve

SLIPS = (
    -0.30, -0.20, -0.10, -0.05, -0.02, -0.01, 0.0, 0.005, 0.01, 0.02, 0.035, 0.05, 0.07, 0.10, 0.15,
    0.20, 0.25, 0.30, 0.40, 0.50, 0.60, 0.70,
)  # fmt: skip
COMPARED = (0.05, 0.10, 0.15, 0.20, 0.25, 0.30)
"""Slips at which the drawbar rig is laid beside the wheel rig."""


@dataclass(frozen=True, kw_only=True)
class Wheel(RigOptions):
    """Test one wheel at every given load, slip angle and slip.

    A smooth rigid wheel under Bekker's law, with slip 1 - v / (w R):

    twin rig wheel --soil.law bekker --soil.preset lete-sand --tyre.rigid --tyre.diameter-m 0.9
    --tyre.width-m 0.3 --load-kn 2 5 10 --slip 0 0.1 0.2 0.3 0.4 0.5 --slip-angle-deg 0
    """

    tyre: Tyre = dataclasses.field(default_factory=Tyre)
    soil: Soil = dataclasses.field(default_factory=Soil)
    load_kn: tuple[float, ...] = (20.0,)
    """Vertical loads [kN]."""
    slip: tuple[float, ...] = SLIPS
    """Slips (w R - v) / max(|w R|, |v|) [-], from -0.95 to 0.95."""
    slip_angle_deg: tuple[float, ...] = (0.0, 4.0, 10.0, 20.0)
    """Slip angles [deg]; positive when the wheel slides to its right."""
    radial: bool = False
    """Use Brixius' constants of a radial tyre (k 9.5, c0 0.0325, m 0.9) instead of the soil's."""
    speed_mps: float = SPEED_MPS
    """Speed along the path [m/s]."""
    out: Path = Path("runs/rig-wheel")
    """Folder for wheel.csv, wheel-free.csv and wheel.png."""


@dataclass(frozen=True, kw_only=True)
class Drawbar(RigOptions):
    """Pull the tractor at constant loads. Compare it with the wheel rig and weight transfer.

    With --table: the greatest steady drawbar power of each gear at full throttle, and its fuel.
    """

    machine: str = USUAL
    """The tractor: a name of `twin list`, a TOML file, or a MJCF."""
    soil: Soil = dataclasses.field(default_factory=Soil)
    hitch_m: float | None = None
    """Height of the pull's line of action above the ground [m]; None for 0.45, or the axle's."""
    step_n: float | None = None
    """Step of the pull from one load to the next [N]; None for 500, or 1 % of the weight."""
    most_slip: float = 0.40
    """Slip at which the test ends [-]."""
    all_wheel_drive: bool = False
    """Engage the front axle."""
    table: bool = False
    """Test every gear at full throttle, within 15 % slip, instead of pull against slip."""
    gear_kmh: tuple[float, ...] = SPEEDS_KMH
    """Gears of the table, by their speed at rated engine speed without slip [km/h]."""
    out: Path = Path("runs/rig-drawbar")
    """Folder for drawbar.csv or drawbar-gears.csv, and drawbar.png."""


@dataclass(frozen=True, kw_only=True)
class Slope(RigOptions):
    """Drive the tractor along a line on cross slopes. Compare its crab angle with theory."""

    machine: str = USUAL
    """The tractor: a name of `twin list`, a TOML file, or a MJCF."""
    soil: Soil = dataclasses.field(default_factory=Soil)
    cross_slope_deg: tuple[float, ...] = (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0)
    """Cross slopes [deg]; positive rises to the left."""
    out: Path = Path("runs/rig-slope")
    """Folder for slope.csv and slope.png."""


@dataclass(frozen=True, kw_only=True)
class Park(RigOptions):
    """Park the tractor on slopes with the brakes on and measure how far it creeps."""

    machine: str = USUAL
    """The tractor: a name of `twin list`, a TOML file, or a MJCF."""
    soil: Soil = dataclasses.field(default_factory=Soil)
    cross_slope_deg: tuple[float, ...] = (0.0, 5.0, 10.0, 15.0, 18.0)
    """Cross slopes [deg], each without grade."""
    grade_deg: tuple[float, ...] = (-15.0, -8.0, 8.0, 15.0)
    """Grades [deg], each without cross slope."""
    parked_s: float = PARKED_S
    """Duration of the test [s]."""
    out: Path = Path("runs/rig-park")
    """Folder for park.csv and park.png."""


def main(args: Sequence[str]) -> int:
    """Run a rig by name."""
    if not args or args[0].startswith("-"):
        if args and args[0] in ("-h", "--help"):
            for name, (kind, _) in RIGS.items():
                print(f"twin rig {name:<8}  {kind.__doc__.splitlines()[0]}")
            return 0
        raise BadInput(f"twin rig needs the name of a rig first: {', '.join(RIGS)}")
    if args[0] not in RIGS:
        raise UnknownName("rig", args[0], RIGS)
    kind, run = RIGS[args[0]]
    if kind is Wheel and {"machine", "implement"} & named_fields(args[1:]):
        raise BadInput(
            "twin rig wheel tests one wheel and takes no machine; --tyre.machine NAME|FILE, which "
            "gives it the tyre of a machine, would do"
        )
    options = parse(kind, args[1:], prog=f"twin rig {args[0]}")
    check_folder("out", options.out)
    check_folder("figures", options.figures)
    _refuse_unread(options, named_fields(args[1:]))
    talks = not (options.quiet or options.json)
    with waiting(f"{args[0]} rig", shown=talks):
        found = run(options)
    files = found.write(options.out, options.figures)
    if options.json:
        print(found.to_json())
    if talks:
        for table in found.shown:
            print_columns(table)
        if any("slip" in table for table in found.shown):
            say(f"slip is zero at: {ZERO_SLIPS['law']}", style="dim")
        say(", ".join(str(f) for f in files))
    return 0


def _wheel(options: Wheel) -> RigResult:
    from twin.rig import figures
    from twin.rig.wheel import outside_range, self_propelled, towed, wheel

    _some(options, "load_kn", "slip", "slip_angle_deg")
    load, angle, slip = (
        a.ravel()
        for a in np.meshgrid(
            1e3 * np.unique(options.load_kn),
            np.radians(np.unique(options.slip_angle_deg)),
            np.unique(options.slip),
            indexing="ij",
        )
    )
    given: dict[str, Plain] = {"speed_mps": options.speed_mps, "radial": options.radial}
    tyre, soil = options.tyre, options.soil
    if not options.quiet:
        _warn(outside_range(tyre, soil, load_n=np.unique(load), radial=options.radial))
    curve = wheel(tyre, soil, slip=slip, load_n=load, slip_angle_rad=angle, **given)
    loads = np.unique(load)
    pulled, driven = (f(tyre, soil, load_n=loads, **given) for f in (towed, self_propelled))
    free = {
        "load_n": loads,
        "towed_slip": pulled.slip,
        "towed_ratio": pulled.towed_ratio,
        "towed_sinkage_m": pulled.sinkage_m,
        "self_propelled_slip": driven.slip,
        "self_propelled_torque_nm": driven.axle_torque_nm,
        "rolling_radius_m": pulled.rolling_radius_m,
    }
    columns = curve.columns()
    straight = (np.abs(angle) == np.abs(angle).min()) & (slip >= 0.0)
    title = f"Wheel rig: {_soil(soil)}, {_tyre(tyre)}"
    return RigResult(
        {"wheel.csv": columns, "wheel-free.csv": free},
        [{name: columns[name][straight] for name in SHOWN}, free],
        "wheel.png",
        lambda: figures.wheel(curve, pulled, title),
    )


SHOWN = (
    "load_n", "slip", "net_pull_n", "axle_torque_nm", "motion_resistance_n", "sinkage_m",
    "gross_traction_ratio", "net_traction_ratio", "tractive_efficiency",
)  # fmt: skip


ONE_GEAR, ALL_GEARS = ("step_n", "most_slip"), ("gear_kmh",)
"""Options of the drawbar rig that the table does not read, and that it alone does."""


def _drawbar(options: Drawbar) -> RigResult:
    return _gears(options) if options.table else _pulled(options)


def _gears(options: Drawbar) -> RigResult:
    from twin.rig import figures
    from twin.rig.gears import gears

    _some(options, "gear_kmh")
    speeds = np.unique(options.gear_kmh)
    found = gears(
        options.soil, speeds_kmh=speeds.tolist(), hitch_m=options.hitch_m,
        machine=options.machine, all_wheel_drive=options.all_wheel_drive,
    )  # fmt: skip
    columns = found.columns()
    shown = {name: columns[name] for name in SHOWN_OF_GEARS}
    title = f"Drawbar rig by gear: {_soil(options.soil)}{_height(options)}"
    return RigResult(
        {"drawbar-gears.csv": columns},
        [shown],
        "drawbar.png",
        lambda: figures.gears(found, title),
    )


SHOWN_OF_GEARS = (
    "gear_kmh", "pull_n", "speed_mps", "slip", "engine_rpm", "drawbar_power_w", "fuel_lph",
)  # fmt: skip


def _pulled(options: Drawbar) -> RigResult:
    from twin.rig import figures
    from twin.rig.drawbar import drawbar, expected_pull_n

    curve = drawbar(
        options.soil,
        hitch_m=options.hitch_m,
        step_n=options.step_n,
        most_slip=options.most_slip,
        gear=Drive(all_wheel_drive=options.all_wheel_drive),
        machine=options.machine,
    )
    if options.all_wheel_drive:
        return _shared(curve, options)
    slips = np.array([s for s in COMPARED if curve.slip[0] <= s <= curve.slip.max()])
    expected = expected_pull_n(
        options.soil, slips, hitch_m=options.hitch_m, machine=options.machine
    )
    ours = np.interp(slips, curve.slip, curve.pull_n)
    table = {"slip": slips, "pull_n": ours, "expected_n": expected, "ratio": ours / expected}
    title = f"Drawbar rig: {_soil(options.soil)}{_height(options)}"
    return RigResult(
        {"drawbar.csv": curve.columns(), "drawbar-expected.csv": table},
        [table],
        "drawbar.png",
        lambda: figures.drawbar(curve, slips, expected, title),
    )


def _shared(curve: DrawbarCurve, options: Drawbar) -> RigResult:
    """Four driven wheels: how the axles share the pull; the closed form is of rear-wheel drive."""
    from twin.rig import figures

    columns = curve.columns()
    shown = ("pull_n", "slip", "front_slip", "front_pull_n", "speed_mps", "drawbar_power_w")
    title = f"Drawbar rig: {_soil(options.soil)}, four driven wheels"
    none = np.zeros(0)
    return RigResult(
        {"drawbar.csv": columns},
        [{name: columns[name] for name in shown}],
        "drawbar.png",
        lambda: figures.drawbar(curve, none, none, title),
    )


def _slope(options: Slope) -> RigResult:
    from twin.rig import figures
    from twin.rig.slope import expected, slope

    _some(options, "cross_slope_deg")
    slopes = np.unique(options.cross_slope_deg)
    for angle in slopes:
        check_range("cross_slope_deg", float(angle), -25.0, 25.0)
    wanted = expected(options.soil, slopes, machine=options.machine)
    seen = slope(options.soil, slopes, machine=options.machine)
    columns = seen.columns()
    own = ("crab_angle_rad", "steer_rad", "slip")
    columns |= {f"expected_{name}": getattr(wanted, name) for name in own}
    title = f"Slope rig: {_soil(options.soil)}"
    return RigResult(
        {"slope.csv": columns},
        [{"cross_slope_deg": slopes} | {n: columns[n] for n in columns if "load" not in n}],
        "slope.png",
        lambda: figures.slope(seen, wanted, title),
    )


def _park(options: Park) -> RigResult:
    from twin.rig import figures
    from twin.rig.park import park

    slopes = [(c, 0.0) for c in options.cross_slope_deg] + [(0.0, g) for g in options.grade_deg]
    if not slopes:
        raise BadInput("--cross-slope-deg and --grade-deg are empty; give at least one slope")
    cross, grade = np.array(slopes).T
    creep = park(
        options.soil, cross_slope_deg=cross, grade_deg=grade, parked_s=options.parked_s,
        machine=options.machine,
    )  # fmt: skip
    title = f"Parking rig: {_soil(options.soil)}, brakes on for {options.parked_s:g} s"
    return RigResult(
        {"park.csv": creep.columns()},
        [creep.columns()],
        "park.png",
        lambda: figures.park(creep, title),
    )


RIGS: dict[str, tuple[Any, Callable[[Any], RigResult]]] = {
    "wheel": (Wheel, _wheel),
    "drawbar": (Drawbar, _drawbar),
    "slope": (Slope, _slope),
    "park": (Park, _park),
}


EVEN = {"soil.strength_cv": "a field, where soil varies; a rig's does not"}
BRIXIUS_ALONE = ("radial", "tyre.deflection_ratio")
"""Options of the wheel rig that Bekker's law does not read."""


def _refuse_unread(options: Any, named: Collection[str]) -> None:
    """Refuse options of the soil or the tyre that the rig does not read."""
    from twin.pipeline.unread import refuse_unread

    soil: Soil = options.soil
    refuse_unread(Scenario(name="rig", soil=soil), named, EVEN)
    for name in BRIXIUS_ALONE:
        if soil.law == "bekker" and name in named:
            raise BadInput(f"{name} would not be read: it needs soil.law = brixius")
    if isinstance(options, Drawbar):
        idle = ONE_GEAR if options.table else ALL_GEARS
        for name in idle:
            if name in named:
                needs = "no --table" if options.table else "--table"
                raise BadInput(f"{name} would not be read: it needs {needs}")


def _some(options: Any, *names: str) -> None:
    for name in names:
        if not getattr(options, name):
            raise BadInput(f"--{name.replace('_', '-')} is empty; give at least one value")


def _warn(sentences: Sequence[str]) -> None:
    for sentence in sentences:
        say(f"beyond the law's range: {sentence}", stderr=True)


def _height(options: Drawbar) -> str:
    return "" if options.hitch_m is None else f", pull at {options.hitch_m:g} m"


def _soil(soil: Soil) -> str:
    own = [
        f"{f.name} {value:g}"
        for f in dataclasses.fields(soil)
        if isinstance(value := getattr(soil, f.name), float) and value != f.default
    ]
    return ", ".join([f"{soil.law} law", f"soil '{soil.preset}'", *own])


def _tyre(tyre: Tyre) -> str:
    from twin.physics.block import Wheel as Size

    sizes = tyre.sizes()
    radius, width = 0.5 * sizes[Size.DIAMETER_M], sizes[Size.WIDTH_M]
    return (
        f"{'rigid wheel' if tyre.rigid else 'tyre'} of radius {radius:.3g} m, width {width:.3g} m"
    )
