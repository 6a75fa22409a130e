"""The documented <numeric> values of a MJCF, from which laws and loader know a machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

from twin.errors import BadInput, UnknownName
from twin.plugins.lookup import line
from twin.vehicle.derive import RPM, USUAL_KMH, Derived, derive, ratios
from twin.vehicle.files import mjcf_path
from twin.vehicle.implement import NONE, Implement
from twin.vehicle.implement_derive import derive_implement
from twin.vehicle.kinds import KINDS
from twin.vehicle.machine import Machine

PREFIX = "plough."
"""Prefix of an implement's names in the MJCF of a machine with implement."""
TYRE = {
    "deflection_ratio": "deflection_ratio",
    "free_rolling_radius_m": "free_rolling_radius_m",
    "nominal_rolling_radius_m": "rolling_radius_m",
    "relaxation_long_m": "relaxation_long_m",
    "relaxation_lat_m": "relaxation_lat_m",
    "lateral_ratio": "lateral_ratio",
    "shear_damping_s": "shear_damping_s",
    "nominal_load_n": "nominal_load_n",
}
"""Numeric of a tyre -> its field in a machine's file."""
RADIAL = {
    "slip_rate_change": 9.5 / 7.5 - 1.0,
    "rolling_moment_change": 0.0325 / 0.04 - 1.0,
    "mobility_resistance_change": 0.9 - 1.0,
}
"""Relative change of the constants of Brixius' law by a radial tyre; Brixius 1987."""
DIESEL, ELECTRIC = 0.0, 1.0
PTO_FUEL = 0.22 + 0.096
"""Fuel over PTO energy by ASABE D497.7 at rated power [L/kWh]."""
NEEDED = (
    *(f"tyre_{axle}.{n}" for axle in ("front", "rear") for n in ("width_m", "diameter_m", *TYRE)),
    *(f"tyre_{axle}.{n}" for axle in ("front", "rear") for n in ("stiffness_npm", "damping_nspm")),
    *(f"engine.{n}" for n in (
        "kind", "max_power_w", "rated_torque_nm", "rated_rpm", "torque_rise", "peak_rpm",
        "no_load_rpm", "idle_rpm", "droop_rpm_per_nm", "parasitic_nm", "inertia_kgm2",
        "displacement_m3", "stroke_m", "exhaust_brake_pa", "regeneration_w",
        "transmission_efficiency",
    )),
    *(f"{c}.{n}" for c in ("brake", "clutch", "lock", "front_drive")
      for n in ("capacity_nm", "windup_rad", "damping_s")),
    "front_drive.ratio",
)  # fmt: skip
"""Numerics that the MJCF of a machine must have."""


@dataclass(frozen=True)
class Facts:
    """The properties of a machine that a scenario is checked against."""

    name: str
    numbers: Mapping[str, float]
    """Its <numeric> values by name."""
    linkage: bool
    lock: bool
    """Whether the rear differential can be locked."""
    ratios: tuple[float, ...]
    """Ratio of each gear; empty where any ratio is allowed."""
    ratio_range: tuple[float, float] | None
    usual_ratio: float
    usual_rpm: float
    transmission: str
    """One of `twin.vehicle.machine.TRANSMISSIONS`."""

    @property
    def diesel(self) -> bool:
        """Whether it burns fuel."""
        return self.numbers["engine.kind"] == DIESEL


def machine_facts(machine: Machine) -> Facts:
    """The properties of a machine that a scenario is checked against.

    Raises:
        BadInput: a hand-made MJCF lacks a numeric, or carries an implement already.
    """
    path = mjcf_path(machine)
    stamp = 0 if path is None else path.stat().st_mtime_ns
    return _facts(machine, path, stamp)


@lru_cache(maxsize=64)
def _facts(machine: Machine, path: Path | None, stamp: int) -> Facts:
    if path is None:
        numbers, linkage = machine_numerics(machine, derive(machine)), machine.linkage.fitted
    else:
        numbers, bodies = _of_mjcf(path)
        numbers |= own_numerics(machine)
        linkage = "lower_links" in bodies
        carried = sorted(n for n in (*bodies, *numbers) if n.startswith(PREFIX))
        if carried:
            raise BadInput(
                f"{path} carries an implement already ({carried[0]}); a MJCF of the machine alone, "
                "as twin machine export writes without --implement, would do"
            )
        for name in NEEDED:
            if name not in numbers:
                raise BadInput(f"{path} has no <numeric name='{name}'>; see models/taishan_1404a")
    gears, engine = machine.transmission, machine.engine
    rim_m, rated_rpm = numbers["tyre_rear.free_rolling_radius_m"], numbers["engine.rated_rpm"]
    if path is None:
        known = derive(machine)
        usual_ratio, usual_rpm = known["transmission.usual_ratio"], known["engine.usual_rpm"]
    else:
        usual_rpm = engine.usual_rpm or 0.694 * numbers["engine.no_load_rpm"]
        usual_ratio = gears.usual_ratio or usual_rpm * RPM * rim_m / (USUAL_KMH / 3.6)
    return Facts(
        name=machine.name, numbers=numbers, linkage=linkage, lock=machine.drive.differential_lock,
        ratios=ratios(machine, rated_rpm, rim_m), ratio_range=gears.cvt_ratio,
        usual_ratio=usual_ratio, usual_rpm=usual_rpm, transmission=transmission_kind(machine),
    )  # fmt: skip


def transmission_kind(machine: Machine) -> str:
    """How the ratio changes, one of TRANSMISSIONS: `kind` of the file, or by its other fields."""
    gears = machine.transmission
    if gears.kind is not None:
        return gears.kind
    if machine.engine.kind == "electric":
        return "electric"
    if gears.cvt_ratio is not None:
        return "cvt"
    return "synchronised" if gears.ratios or gears.speeds_kmh else "powershift"


def own_numerics(machine: Machine) -> dict[str, float]:
    """Values by which a machine's file replaces numerics of its hand-made MJCF, by name.

    Raises:
        UnknownName: the MJCF has no such numeric.
    """
    for numeric in machine.numerics:
        if numeric.name not in NEEDED:
            raise UnknownName("numeric", numeric.name, NEEDED)
    return {numeric.name: numeric.value for numeric in machine.numerics}


def _of_mjcf(path: Path) -> tuple[dict[str, float], frozenset[str]]:
    """The numerics and the names of the bodies of a MJCF and of the files it includes."""
    numbers: dict[str, float] = {}
    bodies: set[str] = set()
    try:
        root = ElementTree.parse(path).getroot()
        for element in root.iter():
            if element.tag == "include":
                inner = path.parent / element.get("file", "")
                more, others = _of_mjcf(inner)
                numbers |= more
                bodies |= others
            elif element.tag == "numeric":
                numbers[element.get("name", "")] = float(element.get("data", "").split()[0])
            elif element.tag == "body":
                bodies.add(element.get("name", ""))
    except (OSError, ElementTree.ParseError, ValueError, IndexError) as error:
        raise BadInput(f"{path} is no MJCF: {line(error)}") from None
    return numbers, frozenset(bodies)


def machine_numerics(machine: Machine, n: Derived) -> dict[str, float]:
    """The numerics of a machine with a generated MJCF, from its derived numbers `n`."""
    out: dict[str, float] = {}
    for axle in ("front", "rear"):
        pair = 2.0 if getattr(machine, axle).duals else 1.0
        width_m, diameter_m = n[f"{axle}.width_m"], n[f"{axle}.diameter_m"]
        tyre = {name: n[f"{axle}.{path}"] for name, path in TYRE.items()}
        tyre |= {"width_m": pair * width_m, "diameter_m": diameter_m}
        tyre |= {k: pair * n[f"{axle}.{k}"] for k in ("stiffness_npm", "damping_nspm")}
        tyre["paired"] = pair - 1.0
        if n[f"{axle}.radial"]:
            tyre |= RADIAL
        out |= {f"tyre_{axle}.{name}": value for name, value in tyre.items()}
    out |= _engine(machine, n)
    out |= {
        "furrow.edge_m": 0.5 * (n["rear.track_m"] - n["rear.width_m"]),
        "furrow.width_m": max(0.5, n["rear.width_m"] + 0.033),
        "furrow.wall_stiffness_npm": 400e3,
        "furrow.wall_damping_nspm": 20e3,
        "hull.front_m": n["length_m"] - 0.45 * n["rear.diameter_m"],
        "hull.rear_m": 0.45 * n["rear.diameter_m"],
        "hull.half_width_m": 0.5 * n["width_m"],
    }
    elements = {
        "brake": (n["chassis.brake_nm"], 0.01, 0.02),
        "clutch": (n["drive.clutch_nm"], 0.15, 0.005),
        "lock": (n["drive.lock_nm"], 0.04, 0.005),
        "front_drive": (n["drive.front_nm"], 0.10, 0.005),
    }
    for name, sizes in elements.items():
        for what, value in zip(("capacity_nm", "windup_rad", "damping_s"), sizes, strict=True):
            out[f"{name}.{what}"] = value
    return out | {
        "front_drive.ratio": n["drive.front_ratio"],
        "front_ballast.x_m": n["wheelbase_m"] + 0.5 * n["front.diameter_m"] + 0.15,
        "front_ballast.z_m": -0.10 * n["rear.diameter_m"] / 1.755,
    }


def _engine(machine: Machine, n: Derived) -> dict[str, float]:
    electric = machine.engine.kind == "electric"
    same = ("rated_torque_nm", "rated_rpm", "torque_rise", "peak_rpm", "no_load_rpm", "idle_rpm",
            "droop_rpm_per_nm", "parasitic_nm", "inertia_kgm2", "stroke_m")  # fmt: skip
    out = {f"engine.{name}": n[f"engine.{name}"] for name in same}
    points = machine.engine.torque_points
    out |= {
        "engine.kind": ELECTRIC if electric else DIESEL,
        "engine.max_power_w": 1e3 * n["engine.max_power_kw"],
        "engine.displacement_m3": 1e-3 * n["engine.displacement_l"],
        "engine.exhaust_brake_pa": 1e3 * n["engine.exhaust_brake_kpa"],
        "engine.regeneration_w": 1e3 * n["engine.regeneration_kw"],
        "engine.transmission_efficiency": n["transmission.efficiency"],
        "engine.pto_efficiency": n["engine.pto_efficiency"],
        "engine.fuel_ratio": n["engine.fuel_l_per_kwh"] / PTO_FUEL,
        "engine.point_count": float(len(points)),
    }
    for i, (rpm, torque) in enumerate(points):
        out |= {f"engine.point_{i}_rpm": rpm, f"engine.point_{i}_nm": torque}
    return out


def implement_numbers(part: Implement) -> dict[str, float]:
    """The numerics of an implement by name, without PREFIX."""
    if part.kind == NONE:
        return {}
    path = mjcf_path(part)
    if path is not None:
        numbers, _ = _of_mjcf(path)
        return _completed(part, numbers)
    return implement_numerics(derive_implement(part))


def implement_numerics(n: Derived) -> dict[str, float]:
    """The numerics of an implement with a generated MJCF, from its derived numbers `n`."""
    out = {name: n[name] for name in ("bodies", "body_width_m", "soil_stiffness_npm")}
    out |= {f"draft_{k}": n[f"draft.{k}"] for k in ("a", "b", "c", "width")}
    same = ("factor_medium", "factor_coarse", "vertical_ratio", "side_ratio", "force_depth_ratio")
    out |= {name: n[f"draft.{name}"] for name in same}
    wheel = ("radius_m", "stiffness_npm", "damping_nspm", "resistance_ratio")
    out |= {f"depth_wheel.{name}": n[f"gauge_wheel.{name}"] for name in wheel}
    return out | {"sole_below_hitch_m": n["clearance_m"]}


def _completed(part: Implement, numbers: dict[str, float]) -> dict[str, float]:
    """The numerics of a hand-made MJCF, with those that its kind gives it."""
    kind = KINDS[part.kind]
    own = numbers.get("body_width_m", 1.0) if kind.per == "m" else 1.0
    usual = {
        "draft_b": 0.0, "draft_width": own, "factor_medium": kind.medium,
        "factor_coarse": kind.coarse,
    }  # fmt: skip
    return usual | numbers
