"""Drawbar power by gear: in each, the best of loads that are held, at full throttle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput, check_range
from twin.machine.fuel import fuel_lph
from twin.machine.plough_setting import GRAVITY_MPS2
from twin.rig.defaults import SPEEDS_KMH
from twin.rig.drawbar import drawbar
from twin.rig.table import Measured
from twin.rig.tractor import tractor
from twin.scenario import Drive, Soil
from twin.vehicle import Machine, files

Array = NDArray[np.float64]

MOST_SLIP = 0.15
"""Slip at which a test of a wheeled tractor on a hard track ends [-]; OECD Code 2, from memory."""
FIRST, STEP = 0.3, 0.02
"""First load and step over the largest pull that power and weight allow in a gear."""


@dataclass(frozen=True, kw_only=True)
class Gears(Measured):
    """The best hold of each gear. Shape (n,)."""

    gear_ratio: Array
    """Engine turns per turn of the rear axle."""
    gear_kmh: Array
    """At rated engine speed without slip."""
    pull_n: Array
    speed_mps: Array
    slip: Array
    engine_rpm: Array
    crank_power_w: Array
    drawbar_power_w: Array
    fuel_lph: Array


def gears(
    soil: Soil,
    *,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    hitch_m: float | None = None,
    machine: str | Machine = files.USUAL,
    all_wheel_drive: bool = False,
) -> Gears:
    """Greatest steady drawbar power in each gear, as OECD Code 2 measures it.

    Every load is held for 5 s at steady speed, at full throttle; loads with more than 15 % slip do
    not count. What is measured is pull times speed; nothing is inferred from the engine.

    Args:
        soil: what lies under it, the same everywhere.
        speeds_kmh: gears, by their speed at rated engine speed without slip.
        hitch_m: height of the pull above the ground.
        machine: a name of `twin list`, a file, or what a file holds; one with fixed gears has the
            nearest to each.
        all_wheel_drive: engage the front axle.

    Raises:
        OutOfRange: a speed outside 3 to 30 km/h, or a height outside what can be tested.
        BadInput: no speed is given, or the tractor pulls nothing within 15 % slip in a gear.
        UnknownName: there is no such machine.
    """
    if not len(speeds_kmh):
        raise BadInput("speeds_kmh is empty; give at least one speed [km/h]")
    rows = [_best(soil, speed, hitch_m, machine, all_wheel_drive) for speed in speeds_kmh]
    return Gears(**{name: np.array([row[name] for row in rows]) for name in rows[0]})


def _best(
    soil: Soil, gear_kmh: float, hitch_m: float | None, name: str | Machine, all_wheel_drive: bool
) -> dict[str, float]:
    check_range("speeds_kmh", gear_kmh, 3.0, 30.0)
    machine = tractor("rig-gears", soil, machine=name)
    numbers, speed_mps = machine.numbers, gear_kmh / 3.6
    rated_radps = numbers["engine.rated_rpm"] * math.pi / 30.0
    ratio = rated_radps * numbers["tyre_rear.free_rolling_radius_m"] / speed_mps
    if known := machine.scenario.facts.ratios:
        ratio = min(known, key=lambda r: abs(math.log(r / ratio)))
    weight_n = GRAVITY_MPS2 * float(machine.model.body("tractor").subtreemass[0])
    most_n = min(numbers["engine.max_power_w"] / speed_mps, weight_n)
    curve = drawbar(
        soil, hitch_m=hitch_m, first_n=FIRST * most_n, step_n=STEP * most_n, most_slip=MOST_SLIP,
        gear=Drive(gear_ratio=ratio, engine_set_rpm=numbers["engine.no_load_rpm"],
                   all_wheel_drive=all_wheel_drive),
        machine=name,
    )  # fmt: skip
    power_w = np.where(curve.slip <= MOST_SLIP, curve.drawbar_power_w, 0.0)
    best = int(np.argmax(power_w))
    if power_w[best] <= 0.0:
        raise BadInput(f"the gear of {gear_kmh:g} km/h pulls nothing at {MOST_SLIP:.0%} slip")
    crank_w, rpm = float(curve.crank_power_w[best]), float(curve.engine_rpm[best])
    return {
        "gear_ratio": ratio, "gear_kmh": gear_kmh, "pull_n": float(curve.pull_n[best]),
        "speed_mps": float(curve.speed_mps[best]), "slip": float(curve.slip[best]),
        "engine_rpm": rpm, "crank_power_w": crank_w,
        "drawbar_power_w": float(power_w[best]),
        "fuel_lph": float(fuel_lph(numbers, crank_w, rpm * math.pi / 30.0)),
    }  # fmt: skip
