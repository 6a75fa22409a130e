"""Inconsistencies in a machine's file: numbers that contradict each other, and unusual ones.

The module is longer than 300 lines because it is a list of rules, each with its message.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from twin.errors import BadInput
from twin.vehicle.derive import RPM, Derived, derive
from twin.vehicle.machine import Machine
from twin.vehicle.tyre_code import tyre_size

MOST_OVER_RATED = 1.35
"""Upper limit of maximum over rated power of a diesel [-]: with boost it is 1.10 to 1.25."""
REACHED = 0.8
"""The last point of a full-load curve is at least at this share of rated speed [-]."""
LEAST_ON_TYRE_NPM3 = 4500.0
"""Least wheel load / (width x diameter**2) of a rear tyre [N/m^3]: wide tyres under light tractors
have 6500, those of heavy ones 8000 to 20000."""
LEAST_WHEELBASE = 1.25
"""Least wheelbase over diameter of the rear tyre [-]; tractors have 1.4 to 2."""
SHARES = (0.12, 0.70)
"""Least and greatest share of the weight on the front axle of a tractor [-]."""
SMALL_M = 0.8
"""Diameter below which a tyre is no tractor's, so that the checks for tractors do not apply."""
LEADS = (-0.005, 0.06)
"""Least and greatest usual lead of the front axle [-]; designers choose 1 to 5 %."""


@dataclass(frozen=True)
class Finding:
    """One inconsistency."""

    path: str
    """The field."""
    said: str
    """Message: the value, what contradicts it, and which value is possible."""
    fatal: bool = True
    """Whether the file must be refused; False for a value that is only unusual."""

    def __str__(self) -> str:
        return f"{self.path} {self.said}"


def findings(machine: Machine) -> list[Finding]:
    """All inconsistencies of a file, the fatal ones first."""
    if machine.mass_kg is None or machine.wheelbase_m is None:
        return []  # a hand-made MJCF that says nothing beside it
    found = [*_given_twice(machine)]
    if not found:
        n = derive(machine)
        for look in (_masses, _tyres, _engine, _gears, _drive, _shape):
            found += look(machine, n)
    return sorted(found, key=lambda f: not f.fatal)


def refuse_inconsistent(machine: Machine) -> None:
    """Raise BadInput for the first fatal inconsistency."""
    for finding in findings(machine):
        if finding.fatal:
            raise BadInput(str(finding))


def _far(one: float, other: float, within: float) -> bool:
    return abs(one - other) > within * abs(other)


def _given_twice(machine: Machine) -> Iterator[Finding]:
    """Two fields for one quantity."""
    engine, drive = machine.engine, machine.drive
    if drive.front_lead is not None and drive.front_ratio is not None:
        yield Finding("drive.front_ratio", f"= {drive.front_ratio:g} beside drive.front_lead = "
                      f"{drive.front_lead:g}; one of them would do")  # fmt: skip
    if engine.droop is not None and engine.no_load_rpm is not None:
        yield Finding("engine.no_load_rpm", f"= {engine.no_load_rpm:g} beside engine.droop = "
                      f"{engine.droop:g}; one of them would do")  # fmt: skip


def _masses(machine: Machine, n: Derived) -> Iterator[Finding]:
    total = n["total_kg"]
    front, rear = machine.front_axle_kg, machine.rear_axle_kg
    if front is not None and rear is not None and _far(front + rear, total, 0.01):
        yield Finding(
            "front_axle_kg", f"= {front:g} and rear_axle_kg = {rear:g} make {front + rear:g} kg, "
            f"but mass_kg and the ballast are {total:g} kg; axle loads that make it would do",
        )  # fmt: skip
    elif not SHARES[0] <= n["front_share"] <= SHARES[1]:
        yield Finding(
            "front_axle_kg", f"= {n['front_axle_kg']:.4g} is {n['front_share']:.0%} of "
            f"{total:g} kg; 12 to 70 % would do",
        )  # fmt: skip
    per_t = n["engine.max_power_kw"] / (1e-3 * total)
    if not 1.5 <= per_t <= 90.0:
        yield Finding(
            "mass_kg", f"= {n['mass_kg']:g} for {n['engine.max_power_kw']:g} kW is {per_t:.3g} kW "
            "per tonne; 1.5 to 90 would do",
        )  # fmt: skip
    wheels = 2.0 * (n["front.wheel_kg"] + n["rear.wheel_kg"])
    if wheels > 0.75 * n["mass_kg"]:
        yield Finding(
            "rear.wheel_kg", f"= {n['rear.wheel_kg']:g}: the wheels weigh {wheels:.4g} of "
            f"{n['mass_kg']:g} kg; three quarters at most would do",
        )  # fmt: skip
    for i, weight in enumerate(machine.ballast):
        if not -1.5 - n["rear.diameter_m"] <= weight.x_m <= n["wheelbase_m"] + 2.5:
            yield Finding(
                f"ballast.{i}.x_m", f"= {weight.x_m:g} is not on a machine with wheelbase_m = "
                f"{n['wheelbase_m']:g}; metres ahead of the rear axle would do",
            )  # fmt: skip
    low, high = 0.2 * n["rear.diameter_m"], 1.2 * n["rear.diameter_m"]
    if not low <= n["cg_height_m"] <= high:
        yield Finding(
            "cg_height_m", f"= {n['cg_height_m']:g} with rear tyres of {n['rear.diameter_m']:.3g} "
            f"m; {low:.2g} to {high:.2g} above the ground would do",
        )  # fmt: skip


def _tyres(machine: Machine, n: Derived) -> Iterator[Finding]:
    for name in ("front", "rear"):
        axle = getattr(machine, name)
        width, diameter = n[f"{name}.width_m"], n[f"{name}.diameter_m"]
        if axle.tyre is not None:
            size = tyre_size(axle.tyre)
            for what, given, coded, within in (
                ("diameter_m", diameter, size.diameter_m, 0.05),
                ("width_m", width, size.width_m, 0.15),
            ):
                if _far(given, coded, within):
                    yield Finding(
                        f"{name}.{what}", f"= {given:g} is not that of a {axle.tyre}; about "
                        f"{coded:.3g} would do",
                    )  # fmt: skip
        if not 0.05 <= width / diameter <= 0.7:
            yield Finding(
                f"{name}.width_m", f"= {width:g} on a diameter of {diameter:g} m; 0.05 to 0.7 of "
                "it would do",
            )  # fmt: skip
        free, rolling = n[f"{name}.free_rolling_radius_m"], n[f"{name}.rolling_radius_m"]
        if not 0.88 <= free / (0.5 * diameter) <= 1.0:
            yield Finding(
                f"{name}.free_rolling_radius_m", f"= {free:g} with a radius of "
                f"{0.5 * diameter:.4g} m; 0.88 to 1 of it would do",
            )  # fmt: skip
        if not 0.9 * free <= rolling <= free:
            yield Finding(
                f"{name}.rolling_radius_m", f"= {rolling:g} with a free rolling radius of "
                f"{free:.4g} m; 0.9 to 1 of it would do",
            )  # fmt: skip
        section = 0.5 * (diameter - n[f"{name}.rim_m"])
        deflection = n[f"{name}.static_deflection_m"]
        if deflection > 0.45 * section:
            tyre = axle.tyre or f"{diameter:g} m"
            yield Finding(
                f"{name}.tyre", f"= {tyre} is pressed in by {deflection:.3g} m of its "
                f"{section:.3g} m under {n[f'{name}.nominal_load_n']:.4g} N; a larger tyre, a "
                "higher pressure_kpa or duals would do",
            )  # fmt: skip
        elif deflection > 0.30 * section:
            yield Finding(
                f"{name}.pressure_kpa", f"= {n[f'{name}.pressure_kpa']:g} under "
                f"{n[f'{name}.nominal_load_n']:.4g} N: pressed in by {deflection / section:.0%} of "
                "the section height; below 30 % is usual", fatal=False,
            )  # fmt: skip
    height = machine.rear_axle_height_m
    if height is not None and _far(height, n["rear.height_m"], 0.05):
        yield Finding(
            "rear_axle_height_m", f"= {height:g}, but the tyre carries the axle at "
            f"{n['rear.height_m']:.3g} m; a tyre or a height that agree would do",
        )  # fmt: skip
    rear_m, load_n = n["rear.diameter_m"], n["rear.nominal_load_n"]
    size_m3 = n["rear.width_m"] * rear_m**2
    shared = SHARES[0] <= n["front_share"] <= SHARES[1]  # else the loads themselves are told
    if shared and rear_m >= SMALL_M and load_n < LEAST_ON_TYRE_NPM3 * size_m3:
        yield Finding(
            "rear.tyre" if machine.rear.tyre else "rear.diameter_m",
            f"= {machine.rear.tyre or f'{rear_m:g}'}, {n['rear.width_m']:.3g} m wide and "
            f"{rear_m:.3g} m high, carries {load_n / 9.81:.4g} kg alone; above "
            f"{LEAST_ON_TYRE_NPM3 * size_m3 / 9.81:.4g} kg is usual", fatal=False,
        )  # fmt: skip
    if n["wheelbase_m"] < LEAST_WHEELBASE * rear_m:
        yield Finding(
            "wheelbase_m", f"= {n['wheelbase_m']:g} with rear tyres {rear_m:.3g} m high; above "
            f"{LEAST_WHEELBASE * rear_m:.3g} is usual", fatal=False,
        )  # fmt: skip
    if n["front.diameter_m"] > 1.3 * n["rear.diameter_m"]:
        yield Finding(
            "front.diameter_m", f"= {n['front.diameter_m']:.3g} is above the rear's "
            f"{n['rear.diameter_m']:.3g}; exchanged?", fatal=False,
        )  # fmt: skip


def _engine(machine: Machine, n: Derived) -> Iterator[Finding]:
    engine = machine.engine
    rated_rpm, rated_kw = n["engine.rated_rpm"], n["engine.rated_power_kw"]
    by_torque = 1e-3 * n["engine.rated_torque_nm"] * rated_rpm * RPM
    if engine.kind == "diesel" and _far(by_torque, rated_kw, 0.03):
        yield Finding(
            "engine.rated_torque_nm", f"= {n['engine.rated_torque_nm']:g} at {rated_rpm:g} rpm is "
            f"{by_torque:.4g} kW, but rated_power_kw is {rated_kw:g}; "
            f"{1e3 * rated_kw / (rated_rpm * RPM):.4g} would do",
        )  # fmt: skip
    if engine.pto_power_kw is not None and engine.pto_power_kw > rated_kw:
        yield Finding(
            "engine.pto_power_kw", f"= {engine.pto_power_kw:g} is above rated_power_kw = "
            f"{rated_kw:g}; a smaller PTO power would do",
        )  # fmt: skip
    points = engine.torque_points
    if points and points[-1][0] < REACHED * rated_rpm:
        yield Finding(
            "engine.torque_points", f"end at {points[-1][0]:g} rpm, but rated_rpm is {rated_rpm:g};"
            " pairs [rpm, N m] up to that speed would do",
        )  # fmt: skip
    elif n["engine.max_power_kw"] < 0.999 * rated_kw:
        yield Finding(
            _written(machine, "max_power_kw", "torque_points"),
            f"= {n['engine.max_power_kw']:g} is below rated_power_kw = {rated_kw:g}; "
            "no less than that would do",
        )  # fmt: skip
    if engine.kind == "diesel" and n["engine.max_power_kw"] > MOST_OVER_RATED * rated_kw:
        yield Finding(
            _written(machine, "max_power_kw", "torque_points"),
            f"= {n['engine.max_power_kw']:.4g} kW is above {MOST_OVER_RATED:g} times "
            f"rated_power_kw = {rated_kw:.4g}; {MOST_OVER_RATED * rated_kw:.4g} at most "
            "would do",
        )  # fmt: skip
    for rpm, torque in engine.torque_points:
        if abs(rpm - rated_rpm) < 1.0 and _far(1e-3 * torque * rpm * RPM, rated_kw, 0.05):
            yield Finding(
                "engine.torque_points", f"give {1e-3 * torque * rpm * RPM:.4g} kW at {rpm:g} rpm, "
                f"but rated_power_kw is {rated_kw:g}; points that agree would do",
            )  # fmt: skip
    order = ("idle_rpm", "peak_rpm", "rated_rpm", "no_load_rpm")
    for low, high in pairwise(order):
        if not n[f"engine.{low}"] < n[f"engine.{high}"]:
            named = _written(machine, low, high)
            other = f"engine.{high if named.endswith(low) else low}"
            side = "below" if named.endswith(low) else "above"
            yield Finding(
                named, f"= {n[named]:g} is not {side} {other} = {n[other]:g}; idle, peak, rated "
                "and no-load speed by rising speed would do",
            )  # fmt: skip
    usual = n["engine.usual_rpm"]
    if not 1.12 * n["engine.idle_rpm"] <= usual <= 1.0001 * n["engine.no_load_rpm"]:
        yield Finding(
            "engine.usual_rpm", f"= {usual:g} is outside "
            f"[{1.12 * n['engine.idle_rpm']:.4g}, {n['engine.no_load_rpm']:.4g}], idle to no-load "
            "speed",
        )  # fmt: skip
    if n["engine.parasitic_nm"] > 0.3 * n["engine.rated_torque_nm"]:
        yield Finding(
            "engine.parasitic_nm", f"= {n['engine.parasitic_nm']:g} of a rated torque of "
            f"{n['engine.rated_torque_nm']:.4g}; 0.3 of it at most would do",
        )  # fmt: skip
    if engine.kind == "electric" and engine.exhaust_brake_kpa:
        yield Finding(
            "engine.exhaust_brake_kpa", f"= {engine.exhaust_brake_kpa:g} of an electric motor; "
            "none would do",
        )  # fmt: skip
    if engine.kind == "diesel" and engine.battery_kwh:
        yield Finding(
            "engine.battery_kwh", f"= {engine.battery_kwh:g} of a diesel; kind = electric would do"
        )
    if n["drive.clutch_nm"] < n["engine.torque_rise"] * n["engine.rated_torque_nm"]:
        yield Finding(
            "drive.clutch_nm", f"= {n['drive.clutch_nm']:g} is below the peak torque of "
            f"{n['engine.torque_rise'] * n['engine.rated_torque_nm']:.4g}; more would do",
        )  # fmt: skip


def _written(machine: Machine, one: str, other: str) -> str:
    """Path of the one of two engine's fields that the file has; the first where it has both."""
    engine = machine.engine
    return f"engine.{other if getattr(engine, one) is None and getattr(engine, other) else one}"


def _gears(machine: Machine, n: Derived) -> Iterator[Finding]:
    from twin.vehicle.derive import ratios

    known = ratios(machine, n["engine.rated_rpm"], n["rear.free_rolling_radius_m"])
    rim = n["engine.rated_rpm"] * RPM * n["rear.free_rolling_radius_m"] * 3.6
    for i, ratio in enumerate(known):
        if not 0.05 <= rim / ratio <= 90.0:
            yield Finding(
                f"transmission.ratios.{i}", f"= {ratio:g} drives {rim / ratio:.3g} km/h at rated "
                "speed; engine turns per turn of the rear axle, for 0.05 to 90 km/h, would do",
            )  # fmt: skip
    usual = n["transmission.usual_ratio"]
    if known and min(abs(math.log(usual / r)) for r in known) > 0.005:
        yield Finding(
            "transmission.usual_ratio", f"= {usual:g} is none of transmission.ratios; one of them "
            "would do",
        )  # fmt: skip
    if not known and not 0.3 <= rim / usual <= 90.0:
        yield Finding(
            "transmission.usual_ratio", f"= {usual:g} drives {rim / usual:.3g} km/h at rated "
            "speed; engine turns per turn of the rear axle, for 0.3 to 90 km/h, would do",
        )  # fmt: skip


def _drive(machine: Machine, n: Derived) -> Iterator[Finding]:
    lead = n["drive.front_lead"]
    if machine.drive.driven == "all" and not LEADS[0] <= lead <= LEADS[1]:
        yield Finding(
            "drive.front_lead" if machine.drive.front_ratio is None else "drive.front_ratio",
            f"gives the front axle a lead of {lead:.1%}; 0 to 6 % would do, more winds the drive "
            f"up, and a ratio of {n['drive.front_ratio'] / (1.0 + lead) * 1.02:.4g} has 2 %",
            fatal=False,
        )  # fmt: skip


def _shape(machine: Machine, n: Derived) -> Iterator[Finding]:
    wheelbase = n["wheelbase_m"]
    room = 0.5 * (n["front.diameter_m"] + n["rear.diameter_m"])
    if wheelbase < 0.95 * room:
        yield Finding(
            "wheelbase_m", f"= {wheelbase:g}: front and rear tyres of {n['front.diameter_m']:.3g} "
            f"and {n['rear.diameter_m']:.3g} m overlap; above {room:.3g} would do",
        )  # fmt: skip
    if wheelbase > 3.2 * room:
        yield Finding(
            "wheelbase_m", f"= {wheelbase:g} between tyres of {n['front.diameter_m']:.3g} and "
            f"{n['rear.diameter_m']:.3g} m; {room:.2g} to {3.2 * room:.2g} would do",
        )  # fmt: skip
    for name in ("front", "rear"):
        track = n[f"{name}.track_m"]
        if track < 1.15 * n[f"{name}.width_m"]:
            yield Finding(
                f"{name}.track_m", f"= {track:g} between tyres {n[f'{name}.width_m']:.3g} m wide; "
                "between their middles, above 1.15 widths, would do",
            )  # fmt: skip
        if not 0.3 * wheelbase <= track <= 1.6 * wheelbase:
            yield Finding(
                f"{name}.track_m", f"= {track:g} with wheelbase_m = {wheelbase:g}; 0.3 to 1.6 of "
                "it would do",
            )  # fmt: skip
    for name in ("length_m", "width_m", "height_m"):
        least = {"length_m": wheelbase, "width_m": 0.8 * n["rear.track_m"],
                 "height_m": 0.6 * n["rear.diameter_m"]}[name]  # fmt: skip
        if n[name] < least:
            yield Finding(name, f"= {n[name]:g} is below {least:.3g}, what wheels and axles need")
    for name in ("gnss_main_m", "gnss_aux_m", "imu_m", "camera_m"):
        place = [n[f"places.{name}.{axis}"] for axis in "xyz"]
        outside = max(abs(place[0]) - 1.6 * n["length_m"], abs(place[1]) - 1.5 * n["width_m"],
                      abs(place[2]) - 1.5 * n["height_m"])  # fmt: skip
        if outside > 0.0:
            said = ", ".join(f"{p:g}" for p in place)
            yield Finding(
                f"places.{name}", f"= {said} is not on the machine; metres from the rear axle "
                "would do",
            )  # fmt: skip
    main, aux = ([n[f"places.{k}.{a}"] for a in "xyz"] for k in ("gnss_main_m", "gnss_aux_m"))
    if math.dist(main, aux) < 0.05:
        yield Finding("places.gnss_aux_m", "stands where places.gnss_main_m does; 0.05 m apart "
                      "or more would do")  # fmt: skip
    if machine.linkage.fitted:
        low, top = n["linkage.lower_pivot_z_m"], n["linkage.top_pivot_z_m"]
        if top <= low:
            yield Finding(
                "linkage.top_pivot_m", f"is {top:g} m above the rear axle, below the lower links' "
                f"{low:g}; above it would do",
            )  # fmt: skip
        if low < -0.95 * n["rear.height_m"]:
            yield Finding(
                "linkage.lower_pivot_m", f"is {low:g} m above the rear axle, in the ground; above "
                f"{-n['rear.height_m']:.3g} would do",
            )  # fmt: skip
