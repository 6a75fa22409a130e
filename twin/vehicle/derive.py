"""All numbers of a machine from its file: a number that is left out is derived by a stated rule.

The rules keep the proportions of a 103 kW tractor of 5260 kg on 18.4-38 tyres with a wheelbase of
2.55 m; the sources of its numbers are in models/taishan_1404a/README.md.

The module is longer than 300 lines because it is a list of rules, in the order of their dependence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from twin.vehicle.machine import Axle, Machine
from twin.vehicle.sheet import Sheet
from twin.vehicle.source import Graded
from twin.vehicle.tyre_code import INCH_M, tyre_size

GRAVITY_MPS2 = 9.81
RPM = math.pi / 30.0
USUAL_KMH = 7.7
"""Speed without slip of the gear that is used where neither file nor scenario gives one."""
FRONT_SHARES = {"rear": 0.38, "all": 0.42}
"""Share of the weight on the front axle by driven axles; tractors with two driven wheels have .35
to .40, with four .40 to .45."""
CG_OVER_RADIUS = 1.08
DUAL = 2.0


@dataclass(frozen=True)
class Derived:
    """Every number of a machine or an implement, with its grade and source."""

    numbers: Mapping[str, Graded]
    """Numbers by path, as `rear.track_m`; a field of the file keeps its path."""

    def __getitem__(self, path: str) -> float:
        return self.numbers[path].value


@lru_cache(maxsize=64)
def derive(machine: Machine) -> Derived:
    """The numbers of a machine without a hand-made MJCF."""
    sheet = Sheet(machine)
    mass_kg = sheet.take("mass_kg", 0.0, "given", "")
    wheelbase_m = sheet.take("wheelbase_m", 0.0, "given", "")
    for name in ("front", "rear"):
        _size(sheet, name, getattr(machine, name))
    _masses(sheet, machine, mass_kg, wheelbase_m)
    for name in ("front", "rear"):
        _tyre(sheet, name, getattr(machine, name))
    _heights(sheet, mass_kg, wheelbase_m)
    _engine(sheet, machine)
    _gears(sheet, machine)
    _couplings(sheet, machine, mass_kg)
    _linkage(sheet, machine, mass_kg)
    _places(sheet, machine, wheelbase_m)
    return Derived(sheet.numbers)


def _size(sheet: Sheet, name: str, axle: Axle) -> None:
    """Width, diameter, rim and build of the tyre; the track."""
    code = axle.tyre
    size = None if code is None else tyre_size(code, f"{name}.tyre")
    why = "" if size is None else f"{code}: {size.aspect}"
    width_m = sheet.take(
        f"{name}.width_m", 0.0 if size is None else size.width_m, "published", f"{code}: its width"
    )
    diameter_m = sheet.take(
        f"{name}.diameter_m", 0.0 if size is None else size.diameter_m, "derived", why
    )
    rim_m = diameter_m - 1.7 * width_m if size is None else size.rim_m
    sheet.write(f"{name}.rim_m", max(0.3 * diameter_m, rim_m), "derived", "the code, or 0.85 width")
    radial = axle.radial if axle.radial is not None else bool(size and size.radial)
    sheet.write(f"{name}.radial", float(radial), "derived", "the code's R")
    low = "" if size is None else size.low_pressure
    sheet.take(
        f"{name}.deflection_ratio", {"": 0.20, "IF": 0.24, "VF": 0.28}[low], "assumed",
        "ASABE D497 from memory: 0.20; IF and VF tyres a fifth and two fifths more",
    )  # fmt: skip
    other = "rear" if name == "front" else "front"
    rule = sheet.given(f"{other}.track_m")
    sheet.take(
        f"{name}.track_m", rule or 0.70 * sheet.numbers["wheelbase_m"].value, "assumed",
        "the other axle's, or 0.70 of the wheelbase",
    )  # fmt: skip


def _masses(sheet: Sheet, machine: Machine, mass_kg: float, wheelbase_m: float) -> None:
    """Total mass, its share in front, and the parts."""
    hung_kg = sum(b.mass_kg for b in machine.ballast)
    total_kg = sheet.write("total_kg", mass_kg + hung_kg, "derived", "mass_kg and the ballast")
    front_kg, rear_kg = machine.front_axle_kg, machine.rear_axle_kg
    if front_kg is not None or rear_kg is not None:
        front_kg = total_kg - rear_kg if front_kg is None else front_kg  # type: ignore[operator]
        share = front_kg / (front_kg + rear_kg) if rear_kg else front_kg / total_kg
        path = "front_axle_kg" if machine.front_axle_kg is not None else "rear_axle_kg"
        grade, why = sheet.origin(path)
    else:
        share, grade = FRONT_SHARES[machine.drive.driven], "assumed"
        why = "0.38 with two driven wheels, 0.42 with four"
        if hung_kg:
            moment = sum(b.mass_kg * b.x_m for b in machine.ballast)
            share = (share * mass_kg + moment / wheelbase_m) / total_kg
    sheet.write("front_share", share, grade, why)
    sheet.write("front_axle_kg", share * total_kg, grade, why)
    sheet.write("rear_axle_kg", (1.0 - share) * total_kg, grade, why)
    for name in ("front", "rear"):
        width, diameter = (sheet.numbers[f"{name}.{n}"].value for n in ("width_m", "diameter_m"))
        pair = DUAL if sheet.given(f"{name}.duals") else 1.0
        sheet.take(
            f"{name}.wheel_kg", min(pair * 180.0 * width * diameter**2, 0.12 * mass_kg), "assumed",
            "180 kg/m3 of width and diameter squared, a tenth about; at most 0.12 of the mass",
        )  # fmt: skip


def _tyre(sheet: Sheet, name: str, axle: Axle) -> None:
    """Springs and radii of the tyre."""
    number = {k.partition(".")[2]: v.value for k, v in sheet.numbers.items() if k.startswith(name)}
    width_m, diameter_m = number["width_m"], number["diameter_m"]
    load_n = sheet.write(
        f"{name}.nominal_load_n", 0.5 * GRAVITY_MPS2 * sheet.numbers[f"{name}_axle_kg"].value,
        "derived", "half the axle's load, level",
    )  # fmt: skip
    pressure = sheet.take(
        f"{name}.pressure_kpa", 160.0 if name == "front" else 110.0, "assumed",
        "160 kPa in front and 110 behind, usual on fields",
    )  # fmt: skip
    rim_in, width_in = number["rim_m"] / INCH_M, width_m / INCH_M
    rule = 1e3 * (172.0 - 1.77 * rim_in + 16.8 + 0.34 * width_in * rim_in * 0.01 * pressure)
    if diameter_m < 0.6:  # below the tyres that the formula was fitted to
        rule = 0.5 * load_n / (0.0125 * diameter_m)
    stiffness = sheet.take(
        f"{name}.stiffness_npm", rule, "derived" if diameter_m >= 0.6 else "assumed",
        "Lines and Murphy 1991 from memory: 172 - 1.77 R + 5.6 A + 0.34 w R p kN/m, 3 years old; "
        "of small wheels half the load over 1.25 % of the diameter",
    )  # fmt: skip
    sheet.take(
        f"{name}.damping_nspm", 0.009 * stiffness, "assumed", "0.009 s of the stiffness: 3 to 4 "
        "kN s/m of a tractor's",
    )  # fmt: skip
    pair = DUAL if axle.duals else 1.0
    deflection_m = sheet.write(
        f"{name}.static_deflection_m", load_n / (pair * stiffness), "derived", "load over stiffness"
    )
    free_m = sheet.take(
        f"{name}.free_rolling_radius_m", 0.967 * 0.5 * diameter_m, "derived",
        "0.967 of the radius, as of an 18.4-38",
    )  # fmt: skip
    sheet.take(
        f"{name}.rolling_radius_m", free_m - deflection_m / 3.0, "derived",
        "free rolling radius less a third of the deflection",
    )  # fmt: skip
    sheet.take(f"{name}.relaxation_long_m", 0.12 * diameter_m, "assumed", "0.12 diameters")
    sheet.take(f"{name}.relaxation_lat_m", 0.40 * diameter_m, "assumed", "0.40 diameters")
    sheet.take(
        f"{name}.lateral_ratio", 0.65 if name == "front" else 0.85, "assumed",
        "0.65 in front and 0.85 behind, as of a tractor whose slides were published",
    )  # fmt: skip
    sheet.take(
        f"{name}.shear_damping_s", 0.114 * diameter_m, "assumed", "0.114 s per m of diameter"
    )


def _heights(sheet: Sheet, mass_kg: float, wheelbase_m: float) -> None:
    """Heights of the axles and of the centre of gravity; the body that the other parts leave."""
    n = {path: number.value for path, number in sheet.numbers.items()}
    rear_m = sheet.write(
        "rear.height_m", 0.5 * n["rear.diameter_m"] - n["rear.static_deflection_m"], "derived",
        "half the diameter less the deflection",
    )  # fmt: skip
    front_m = sheet.write(
        "front.height_m", 0.5 * n["front.diameter_m"] - n["front.static_deflection_m"], "derived",
        "half the diameter less the deflection",
    )  # fmt: skip
    sheet.take(
        "cg_height_m", CG_OVER_RADIUS * 0.5 * n["rear.diameter_m"], "assumed",
        "1.08 radii of the rear tyre",
    )  # fmt: skip
    sheet.take(
        "length_m", wheelbase_m + 0.5 * n["front.diameter_m"] + 0.9 * 0.5 * n["rear.diameter_m"]
        + 0.3 * wheelbase_m, "assumed", "wheelbase, wheels, and the front weights",
    )  # fmt: skip
    tyres = 3.3 if sheet.given("rear.duals") else 1.0  # the outer ones stand 1.15 widths outside
    sheet.take(
        "width_m", n["rear.track_m"] + tyres * n["rear.width_m"], "derived", "track and tyres"
    )
    sheet.take("height_m", 1.62 * n["rear.diameter_m"] + 0.15, "assumed", "1.62 rear diameters")
    sheet.write("front.hub_m", front_m - rear_m, "derived", "height of the hubs over the rear's")


def _engine(sheet: Sheet, machine: Machine) -> None:
    engine, take = machine.engine, sheet.take
    electric = engine.kind == "electric"
    rated_rpm = take("engine.rated_rpm", 0.0, "given", "")
    power_kw, torque_nm, pto_kw = (
        engine.rated_power_kw, engine.rated_torque_nm, engine.pto_power_kw
    )  # fmt: skip
    if power_kw is not None and pto_kw is not None:
        eta = take(
            "engine.pto_efficiency", pto_kw / power_kw, "derived", "PTO power over crank power"
        )
    else:
        eta = take(
            "engine.pto_efficiency", 1.0 if electric else 0.90, "assumed",
            "0.90 as in ASABE D497, from memory; .86 to .92 of single tractors",
        )  # fmt: skip
    if power_kw is None and engine.pto_power_kw is not None:
        power_kw = sheet.write(
            "engine.rated_power_kw", engine.pto_power_kw / eta, "derived",
            "PTO power over pto_efficiency",
        )  # fmt: skip
    elif power_kw is None and engine.torque_points:
        at = _interpolated(rated_rpm, engine.torque_points)
        power_kw = sheet.write(
            "engine.rated_power_kw", 1e-3 * at * rated_rpm * RPM, "derived", "the torque points"
        )
    elif power_kw is None:
        power_kw = sheet.write(
            "engine.rated_power_kw", engine.max_power_kw or 0.0, "derived", "max_power_kw"
        )
    else:
        take("engine.rated_power_kw", power_kw, "given", "")
    if engine.pto_power_kw is not None:
        take("engine.pto_power_kw", 0.0, "given", "")
    rule = 1e3 * power_kw / (rated_rpm * RPM)
    torque_nm = take("engine.rated_torque_nm", rule, "derived", "rated power over rated speed")
    rise = take("engine.torque_rise", 1.0 if electric else 1.30, "assumed", "1.25 to 1.40 is usual")
    peak_rpm = take("engine.peak_rpm", 0.66 * rated_rpm, "assumed", "two thirds of rated speed")
    peak_w = max(torque_nm * rated_rpm, rise * torque_nm * peak_rpm) * RPM
    points_w = max((rpm * RPM * t for rpm, t in engine.torque_points), default=0.0)
    most_kw = 1e-3 * max(points_w, 0.0) if points_w else power_kw
    take("engine.max_power_kw", most_kw, "derived", "the rated power, or the torque points")
    sheet.write("engine.peak_power_kw", 1e-3 * peak_w, "derived",
                "the greater of rated torque and peak torque, each times its speed")  # fmt: skip
    no_load = rated_rpm * (1.0 + (0.09 if engine.droop is None else engine.droop))
    no_load = take(
        "engine.no_load_rpm", no_load, "assumed" if engine.droop is None else "derived",
        "droop over rated speed; 9 % where none is given, as of mechanical governors (7 to 10 %)",
    )  # fmt: skip
    idle = take(
        "engine.idle_rpm", 0.0 if electric else 0.364 * rated_rpm, "assumed", "0.364 of rated speed"
    )
    sheet.write(
        "engine.droop_rpm_per_nm",
        (0.16 / 3.0 * no_load if electric else no_load - rated_rpm) / torque_nm,
        "assumed" if electric else "derived",
        "no-load less rated speed, over rated torque; of a motor's control .053 of no-load speed",
    )  # fmt: skip
    take("engine.parasitic_nm", (0.0125 if electric else 0.056) * torque_nm, "assumed",
         "0.056 of rated torque for fan, pumps and generator; of a motor 0.0125")  # fmt: skip
    take("engine.inertia_kgm2", (0.002 if electric else 0.0194) * power_kw, "assumed",
         "0.0194 kg m2 a kW of crank, flywheel and clutch; of a motor 0.002")  # fmt: skip
    take("engine.displacement_l", 0.0 if electric else 0.063 * power_kw, "assumed",
         "0.063 l a kW")  # fmt: skip
    take("engine.stroke_m", 0.0 if electric else 0.125, "assumed", "six cylinders of 105 mm")
    take("engine.exhaust_brake_kpa", 0.0 if electric else 250.0, "assumed", "flaps hold 2 to 4 bar")
    take("engine.regeneration_kw", 0.5 * power_kw if electric else 0.0, "assumed",
         "half the power of a motor; a diesel takes nothing back")  # fmt: skip
    take("engine.fuel_l_per_kwh", 0.0 if electric else 0.316, "published",
         "ASABE D497.7 at rated power: 0.22 + 0.096 L/kWh")  # fmt: skip
    if engine.battery_kwh is not None:
        take("engine.battery_kwh", 0.0, "given", "")
        sheet.write(
            "engine.battery_h",
            engine.battery_kwh / power_kw,
            "derived",
            "its energy at rated power",
        )
    rule = 0.8 * no_load if electric else max(0.694 * no_load, 1.2 * idle)
    take("engine.usual_rpm", rule, "assumed", "0.694 of the no-load speed, 0.8 of a motor's")


def _interpolated(rpm: float, points: tuple[tuple[float, float], ...]) -> float:
    low = points[0]
    for high in points[1:]:
        if rpm <= high[0]:
            share = min(max((rpm - low[0]) / (high[0] - low[0]), 0.0), 1.0)
            return low[1] + share * (high[1] - low[1])
        low = high
    return low[1]


def _gears(sheet: Sheet, machine: Machine) -> None:
    n = {path: number.value for path, number in sheet.numbers.items()}
    efficiency = "drawbar over PTO power on concrete is .84 to .89"
    sheet.take("transmission.efficiency", 0.87, "assumed", efficiency)
    rim_m = n["rear.free_rolling_radius_m"]
    wanted = n["engine.usual_rpm"] * RPM * rim_m / (USUAL_KMH / 3.6)
    known = ratios(machine, n["engine.rated_rpm"], rim_m)
    rule = min(known, key=lambda ratio: abs(math.log(ratio / wanted))) if known else wanted
    if machine.transmission.cvt_ratio is not None:
        low, high = machine.transmission.cvt_ratio
        rule = min(max(wanted, low), high)
    sheet.take(
        "transmission.usual_ratio", rule, "assumed",
        "the gear nearest to 7.7 km/h without slip at the usual engine speed",
    )  # fmt: skip


def ratios(machine: Machine, rated_rpm: float, rim_m: float) -> tuple[float, ...]:
    """Engine turns per turn of the rear axle in each gear; empty where the file gives no gears.

    Args:
        machine: gives `ratios`, or `speeds_kmh` from which they are computed.
        rated_rpm: rated engine speed, at which `speeds_kmh` hold.
        rim_m: rolling radius of the rear wheels without load.
    """
    gears = machine.transmission
    by_speed = (rated_rpm * RPM * rim_m / (kmh / 3.6) for kmh in gears.speeds_kmh)
    return gears.ratios or tuple(by_speed)


def _couplings(sheet: Sheet, machine: Machine, mass_kg: float) -> None:
    n = {path: number.value for path, number in sheet.numbers.items()}
    weight_n = GRAVITY_MPS2 * mass_kg
    rear_m, front_m = n["rear.free_rolling_radius_m"], n["front.free_rolling_radius_m"]
    scale = (mass_kg / 5260.0) * (n["wheelbase_m"] / 2.55)
    sheet.write("scale", scale, "derived", "mass times wheelbase over those of the 103 kW tractor")
    take = sheet.take
    take("chassis.brake_nm", 0.35 * weight_n * rear_m, "assumed", "locks the wheel on dry ground")
    take("drive.clutch_nm", 1.5 * n["engine.torque_rise"] * n["engine.rated_torque_nm"], "assumed",
         "1.5 times the peak torque")  # fmt: skip
    take("drive.lock_nm", 0.9 * weight_n * rear_m, "assumed", "more than both tyres hand on")
    take(
        "drive.front_nm", 0.46 * weight_n * front_m, "assumed", "more than the front tyres hand on"
    )
    ratio = rear_m / front_m
    lead = sheet.given("drive.front_lead")
    given = sheet.given("drive.front_ratio")
    if given is not None:
        take("drive.front_ratio", given, "given", "")
        sheet.write("drive.front_lead", given / ratio - 1.0, "derived", "front_ratio and the radii")
    else:
        take("drive.front_lead", 0.02, "assumed", "1 to 5 % is usual")
        lead = 0.02 if lead is None else lead
        sheet.write("drive.front_ratio", ratio * (1.0 + lead), "derived", "radii and the lead")
    take("chassis.steer_limit_rad", 0.75, "assumed", "43 degrees")
    take("chassis.swing_limit_rad", 0.192, "assumed", "11 degrees")


def _linkage(sheet: Sheet, machine: Machine, mass_kg: float) -> None:
    size = 0.5 * sheet.numbers["rear.diameter_m"].value / 0.8775
    why = "in proportion to the rear tyre, as of a category 3 linkage under 18.4-38 tyres"
    sheet.take("linkage.lower_link_m", 0.95 * size, "assumed", why)
    for name, (x, z) in {"lower": (-0.10, -0.32), "top": (-0.28, 0.28)}.items():
        path = f"linkage.{name}_pivot_m"
        given = sheet.given(path)
        grade, said = ("assumed", why) if given is None else sheet.origin(path)
        x, z = (x * size, z * size) if given is None else given
        sheet.write(f"linkage.{name}_pivot_x_m", x, grade, said)
        sheet.write(f"linkage.{name}_pivot_z_m", z, grade, said)
    sheet.take("linkage.lift_n", 15.2 * mass_kg, "assumed", "1.55 times the weight")


def _places(sheet: Sheet, machine: Machine, wheelbase_m: float) -> None:
    """Sensors: the cab's roof, the cab's floor, and under the belly."""
    n = {path: number.value for path, number in sheet.numbers.items()}
    roof_m = n["height_m"] - n["rear.height_m"] - 0.02
    half_m = 0.28 * n["rear.track_m"]
    ahead_m = 0.29 * wheelbase_m
    rules = {
        "gnss_main_m": (ahead_m, half_m, roof_m),
        "gnss_aux_m": (ahead_m, -half_m, roof_m),
        "imu_m": (0.24 * wheelbase_m, 0.0, 0.18 * wheelbase_m),
        "camera_m": (0.49 * wheelbase_m, 0.0, 0.5 - n["rear.height_m"]),
    }
    for name, rule in rules.items():
        path = f"places.{name}"
        given = sheet.given(path)
        grade, said = ("assumed", "roof, cab floor, belly") if given is None else sheet.origin(path)
        for axis, value in zip("xyz", rule if given is None else given, strict=True):
            sheet.write(f"{path}.{axis}", value, grade, said)
