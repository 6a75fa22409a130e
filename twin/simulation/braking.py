"""The driver's foot: brakes where the ground drives the machine faster than the governor asks.

There is one gear for a run, so a driver who would shift down brakes instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from twin.machine.build import Machine

LEFT_TO_ENGINE = 0.05
"""Speed above the governor's at which the driver begins to brake: below, the engine's own drag
acts, which a governor calls up within some per cent [-]; assumed."""
REACTION_S = 0.2
"""Lag between what he feels and his foot [s]; assumed."""
SLOWING_S, HOLDING_S = 0.3, 0.7
"""How he brakes: 1 m/s too fast asks for 3.3 m/s2, and for 2 m/s2 more each second as long as
it lasts [s, s]; assumed."""
EASED_MPS2 = 0.5
"""A throttle that is closed asks for a speed that falls no faster than this [m/s2]: the engine is
given the time to slow down; assumed."""


@dataclass(frozen=True)
class Brakes:
    """What a driver knows of his gear and his brakes."""

    mps_per_radps: float
    """Speed of the driven rims over that of the engine."""
    pedal_per_mps2: float
    """Pedal that slows the whole machine by 1 m/s2."""


@dataclass(frozen=True)
class Foot:
    """The foot on the pedal, and what it remembers; numbers, or arrays of one shape."""

    asked_radps: Any = 0.0
    """Engine speed that the throttle asks for, as it is eased down."""
    felt_mps: Any = 0.0
    """Overspeed as it is felt."""
    held_mps2: Any = 0.0
    """Deceleration found so far against the slope."""
    pedal: Any = 0.0
    """0 released, 1 pressed down."""


def brakes(machine: Machine) -> Brakes:
    """A machine's, as its driver knows them: m r / (2 C), with one brake C on each rear wheel."""
    numbers, model = machine.numbers, machine.model
    radius_m = numbers["tyre_rear.free_rolling_radius_m"]
    mass_kg = float(model.body_subtreemass[model.body("tractor").id])
    return Brakes(
        mps_per_radps=radius_m / machine.scenario.drive.gear_ratio,
        pedal_per_mps2=mass_kg * radius_m / (2.0 * numbers["brake.capacity_nm"]),
    )


def set_radps(machine: Machine, throttle: Any) -> Any:
    """Engine speed that a throttle from 0 to 1 asks for, without load; elementwise."""
    idle, top = (machine.numbers[f"engine.{n}_rpm"] for n in ("idle", "no_load"))
    return (idle + np.clip(throttle, 0.0, 1.0) * (top - idle)) * math.pi / 30.0


def asked_mps(machine: Machine) -> float:
    """Speed of the driven rims that the scenario's throttle asks for, without load."""
    return float(set_radps(machine, machine.throttle) * brakes(machine).mps_per_radps)


def press(known: Brakes, foot: Foot, engine_radps: Any, asked_radps: Any, dt_s: float) -> Foot:
    """The foot in the next interval; numbers, or arrays of one shape.

        e = (r / i) (w - 1.05 w_0)          felt with a lag of 0.2 s
        a = e / 0.3 s + int e dt / (0.7 s)**2        pedal = clip(a m r / (2 C), 0, 1)

    Args:
        known: gear and brakes.
        foot: as it was.
        engine_radps: w.
        asked_radps: w_0, the speed the governor is set to; where it is lowered, it is eased down.
        dt_s: the interval.
    """
    eased = foot.asked_radps - EASED_MPS2 / known.mps_per_radps * dt_s
    asked = np.maximum(asked_radps, eased)
    over_mps = known.mps_per_radps * (engine_radps - (1.0 + LEFT_TO_ENGINE) * asked)
    felt = foot.felt_mps + (over_mps - foot.felt_mps) * dt_s / REACTION_S
    most = 1.0 / known.pedal_per_mps2
    held = np.clip(foot.held_mps2 + felt * dt_s / HOLDING_S**2, 0.0, most)
    pedal = np.clip((felt / SLOWING_S + held) * known.pedal_per_mps2, 0.0, 1.0)
    return Foot(asked, felt, held, pedal)
