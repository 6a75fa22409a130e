"""The gears that a driver can shift to: those of the machine's file, or an assumed ladder."""

from __future__ import annotations

import math
from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange
from twin.scenario.gear import SAME, Gear
from twin.vehicle.numerics import Facts

STEP = 1.2
"""Ratio of neighbouring gears where a file says none: 16 to 24 gears of a field tractor span 2 to
40 km/h in steps of 1.15 to 1.25; assumed."""
SLOWEST_KMH, FASTEST_KMH = 2.0, 42.0
"""Speeds at rated engine speed of the slowest and the fastest gear of such a ladder; assumed."""
CVT_SLOWEST = 12.0
"""Greatest ratio over the usual one of a continuously variable transmission whose file says no
range; assumed."""


@dataclass(frozen=True)
class Gearbox:
    """How the ratio changes, and to what."""

    kind: str
    """powershift, synchronised, cvt or electric."""
    ratios: tuple[float, ...]
    """Engine turns per turn of the rear axle, from the slowest gear to the fastest; those of
    reverse are the same. Two limits, slowest first, of a CVT."""
    start: float
    """Ratio that a scenario drives."""

    @property
    def stepless(self) -> bool:
        """Whether any ratio between the two limits can be driven."""
        return self.kind == "cvt"

    @property
    def gear(self) -> int:
        """Number of the gear that a scenario drives, from 1 for the slowest."""
        return 1 + self.ratios.index(self.nearest(self.start))

    def nearest(self, ratio: float) -> float:
        """The ratio that can be driven and is nearest to one."""
        if self.stepless:
            return min(max(ratio, self.ratios[1]), self.ratios[0])
        return min(self.ratios, key=lambda known: abs(math.log(known / ratio)))

    def of_gear(self, gear: int, machine: str) -> float:
        """The ratio of a gear by its number. Raises OutOfRange, or BadInput for a CVT."""
        if self.stepless:
            raise BadInput(
                f"gear = {gear}: {machine} has a continuously variable transmission without gears; "
                "kmh would do"
            )
        if not 1 <= gear <= len(self.ratios):
            raise OutOfRange("gear", gear, f"[1, {len(self.ratios)}], the gears of {machine}")
        return self.ratios[gear - 1]

    def of_speed(self, kmh: float, set_rpm: float, rim_m: float) -> float:
        """The ratio whose speed without slip is nearest to one at an engine speed."""
        return self.nearest(set_rpm * math.pi / 30.0 * rim_m / (kmh / 3.6))


def gearbox(machine: Facts, gear: Gear) -> Gearbox:
    """The gears of a machine in which a scenario drives one."""
    kind, start = machine.transmission, gear.ratio
    if kind == "cvt":
        low, high = machine.ratio_range or (start / CVT_SLOWEST, start * CVT_SLOWEST)
        return Gearbox(kind, (high, low), start)
    if kind == "electric" and not machine.ratios:
        return Gearbox(kind, (start,), start)
    known = machine.ratios
    if not known:
        per_kmh = machine.numbers["engine.rated_rpm"] * math.pi / 30.0 * 3.6
        per_kmh *= machine.numbers["tyre_rear.free_rolling_radius_m"]
        slower = math.floor(math.log(per_kmh / SLOWEST_KMH / start) / math.log(STEP))
        faster = math.floor(math.log(start * FASTEST_KMH / per_kmh) / math.log(STEP))
        steps = range(max(slower, 0), -max(faster, 0) - 1, -1)
        return Gearbox(kind, tuple(start * STEP**k for k in steps), start)
    apart = [r for r in sorted(known, reverse=True) if abs(r / start - 1.0) > SAME]
    return Gearbox(kind, tuple(sorted((*apart, start), reverse=True)), start)
