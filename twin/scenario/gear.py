"""Which gear is driven, and at what engine speed: a scenario's wish on its machine."""

from __future__ import annotations

import math
from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange, check_range
from twin.scenario.course import Drive
from twin.vehicle.numerics import Facts

SAME = 5e-3
"""Relative difference within which a ratio is that of a gear."""


@dataclass(frozen=True)
class Gear:
    """What is driven."""

    ratio: float
    """Engine turns per turn of the rear axle."""
    set_rpm: float
    """No-load speed the governor is set to."""


def gear(drive: Drive, machine: Facts) -> Gear:
    """The gear and the engine speed of a drive on a machine.

    Raises:
        OutOfRange: the engine does not run so, or a ratio outside the transmission's range.
        BadInput: a ratio that is none of the transmission's gears.
    """
    set_rpm = machine.usual_rpm if drive.engine_set_rpm is None else drive.engine_set_rpm
    idle, top = (machine.numbers[f"engine.{n}_rpm"] for n in ("idle", "no_load"))
    check_range(
        "drive.engine_set_rpm", set_rpm, max(300.0 if top >= 1000.0 else 0.0, 1.125 * idle), top
    )
    if drive.gear_kmh is not None:
        rim_m = machine.numbers["tyre_rear.free_rolling_radius_m"]
        ratio = set_rpm * math.pi / 30.0 * rim_m / (drive.gear_kmh / 3.6)
        if machine.ratios:
            ratio = min(machine.ratios, key=lambda known: abs(math.log(known / ratio)))
        elif machine.ratio_range is not None:
            low, high = machine.ratio_range
            if not low <= ratio <= high:
                fastest, slowest = (drive.gear_kmh * ratio / r for r in (low, high))
                raise OutOfRange(
                    "drive.gear_kmh", f"{drive.gear_kmh:g}", f"[{slowest:.3g}, {fastest:.3g}], "
                    f"what {machine.name} drives at {set_rpm:g} rpm",
                )  # fmt: skip
        return Gear(ratio, set_rpm)
    if drive.gear_ratio is None:
        return Gear(machine.usual_ratio, set_rpm)
    ratio = drive.gear_ratio
    if machine.ratios and min(abs(known / ratio - 1.0) for known in machine.ratios) > SAME:
        near = min(machine.ratios, key=lambda known: abs(math.log(known / ratio)))
        raise BadInput(
            f"drive.gear_ratio = {ratio:g} is no gear of {machine.name}; its nearest is {near:.4g}"
        )
    if machine.ratio_range is not None:
        check_range("drive.gear_ratio", ratio, *machine.ratio_range)
    return Gear(ratio, set_rpm)
