"""The brake pedal: pressed where the ground drives the machine faster than the governor asks.

By default a run has one gear: the driver brakes and does not shift down.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from twin.compute.compiled import law
from twin.simulation.controls import lagged, within

LEFT_TO_ENGINE = 0.05
"""Speed above the governor's at which the driver begins to brake: below, the engine's own drag
acts, which a governor calls up within some per cent [-]; assumed."""
REACTION_S = 0.2
"""Lag between what the driver feels and the pedal [s]; assumed."""
SLOWING_S, HOLDING_S = 0.3, 0.7
"""Gains: 1 m/s too fast asks for 3.3 m/s2, and for 2 m/s2 more each second as long as it lasts
[s, s]; assumed."""
EASED_MPS2 = 0.5
"""A throttle that is closed asks for a speed that falls no faster than this [m/s2]: the engine is
given the time to slow down; assumed."""


class Drivetrain(NamedTuple):
    """What a driver knows of engine, gear and brakes."""

    gear_ratio: float
    """Engine turns per turn of the driven axle."""
    idle_rpm: float
    no_load_rpm: float
    """No-load engine speeds with the throttle closed and open."""
    mps_per_radps: float
    """Speed of the driven rims over that of the engine."""
    pedal_per_mps2: float
    """Pedal that slows the whole machine by 1 m/s2."""


class BrakePedal(NamedTuple):
    """The pedal, and the state of the controller behind it."""

    asked_radps: float = 0.0
    """Engine speed that the throttle asks for, as it is eased down."""
    felt_mps: float = 0.0
    """Overspeed after the reaction lag."""
    held_mps2: float = 0.0
    """Integral term: deceleration found so far against the slope."""
    pedal: float = 0.0
    """0 released, 1 pressed down."""


@law
def governed_radps(known: Drivetrain, throttle: float) -> float:
    """No-load engine speed that a throttle from 0 to 1 asks for."""
    span_rpm = known.no_load_rpm - known.idle_rpm
    return (known.idle_rpm + within(0.0, throttle, 1.0) * span_rpm) * math.pi / 30.0


@law
def press(
    known: Drivetrain, last: BrakePedal, engine_radps: float, asked_radps: float, dt_s: float
) -> BrakePedal:
    """The pedal for the next interval.

        e = (r / i) (w - 1.05 w_0)          felt with a lag of 0.2 s
        a = e / 0.3 s + int e dt / (0.7 s)**2        pedal = clip(a m r / (2 C), 0, 1)

    Args:
        known: engine, gear and brakes.
        last: the pedal as it was.
        engine_radps: w.
        asked_radps: w_0, the speed the governor is set to; where it is lowered, it is eased down.
        dt_s: the interval.
    """
    eased = last.asked_radps - EASED_MPS2 / known.mps_per_radps * dt_s
    asked = max(asked_radps, eased)
    over_mps = known.mps_per_radps * (engine_radps - (1.0 + LEFT_TO_ENGINE) * asked)
    felt = lagged(last.felt_mps, over_mps, REACTION_S, dt_s)
    most = 1.0 / known.pedal_per_mps2
    held = within(0.0, last.held_mps2 + felt * dt_s / HOLDING_S**2, most)
    pedal = within(0.0, (felt / SLOWING_S + held) * known.pedal_per_mps2, 1.0)
    return BrakePedal(asked, felt, held, pedal)
