"""The wheel under test: a tyre of a machine, or one given by its sizes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from twin.errors import BadInput, UnknownName, check_range
from twin.physics.block import BUILD, Wheel
from twin.vehicle import files
from twin.vehicle.numerics import machine_facts

AXLES = ("front", "rear")
RIGID_NPM = 1e9
"""Stiffness that counts as rigid: 10 um at 10 kN [N/m]."""
MOST_DEFLECTION = 0.2
"""Deflection over radius beyond which a tyre would run on its rim."""
SIZES = tuple(f for f in Wheel if Wheel.WIDTH_M <= f <= Wheel.NOMINAL_LOAD_N)
"""Numbers of a tyre in a model, in the order of the block."""


@dataclass(frozen=True, kw_only=True)
class Tyre:
    """The wheel under test. What is None follows the machine's tyre."""

    machine: str = files.USUAL
    """Whose tyre."""
    axle: str = "rear"
    """front or rear."""
    width_m: float | None = None
    """Section width [m]; 0.467 for an 18.4-38."""
    diameter_m: float | None = None
    """Unloaded outer diameter [m]; 1.755 for an 18.4-38."""
    deflection_ratio: float | None = None
    """Deflection over section height in Brixius' mobility number [-]; 0.20."""
    free_rolling_radius_m: float | None = None
    """Rolling radius without load [m]; in proportion to the diameter when None."""
    stiffness_npm: float | None = None
    """Vertical stiffness [N/m]; 383e3 for an 18.4-38."""
    relaxation_long_m: float | None = None
    """Relaxation length along [m]."""
    relaxation_lat_m: float | None = None
    """Relaxation length across [m]."""
    lateral_ratio: float | None = None
    """Lateral over longitudinal slip stiffness [-]; 0.85."""
    rigid: bool = False
    """A smooth rigid wheel: no deflection, the rolling radius is the radius."""

    def __post_init__(self) -> None:
        files.machine(self.machine)
        if self.axle not in AXLES:
            raise UnknownName("axle", self.axle, AXLES)
        for name, low, high in (
            ("width_m", 0.02, 2.0), ("diameter_m", 0.1, 4.0), ("deflection_ratio", 0.0, 0.5),
            ("free_rolling_radius_m", 0.05, 2.0), ("stiffness_npm", 1e3, RIGID_NPM),
            ("relaxation_long_m", 0.01, 5.0), ("relaxation_lat_m", 0.01, 5.0),
            ("lateral_ratio", 0.05, 2.0),
        ):  # fmt: skip
            if (value := getattr(self, name)) is not None:
                check_range(f"tyre.{name}", value, low, high)
        for name in ("stiffness_npm", "deflection_ratio", "free_rolling_radius_m"):
            if self.rigid and getattr(self, name) is not None:
                raise BadInput(f"tyre.rigid and tyre.{name} contradict each other; give one")

    def sizes(self) -> dict[Wheel, float]:
        """The tyre's numbers for the parameter block."""
        sizes = machine_tyre(self.machine, self.axle)
        rolling = sizes[Wheel.FREE_ROLLING_RADIUS_M] / sizes[Wheel.DIAMETER_M]
        own = dataclasses.asdict(self)
        sizes |= {f: own[n] for f in SIZES if (n := f.name.lower()) in own and own[n] is not None}
        if self.free_rolling_radius_m is None:
            sizes[Wheel.FREE_ROLLING_RADIUS_M] = rolling * sizes[Wheel.DIAMETER_M]
        if self.rigid:
            sizes[Wheel.STIFFNESS_NPM] = RIGID_NPM
            sizes[Wheel.DEFLECTION_RATIO] = 0.0
            sizes[Wheel.FREE_ROLLING_RADIUS_M] = 0.5 * sizes[Wheel.DIAMETER_M]
        return sizes


def machine_tyre(machine: str, axle: str) -> dict[Wheel, float]:
    """The sizes a machine's model gives for the tyre of an axle."""
    numbers = machine_facts(files.machine(machine)).numbers
    sizes = {f: numbers[f"tyre_{axle}.{f.name.lower()}"] for f in SIZES}
    return sizes | {f: numbers.get(f"tyre_{axle}.{f.name.lower()}", 0.0) for f in BUILD}
