"""The parameters that a calibration knows: what each changes, and what is believed of it before.

A parameter has the name of its field in the machine's file (`rear.free_rolling_radius_m`), of the
soil (`soil.draft_scale`), or of the log alone (`log.set_rpm`). It is fitted by its logarithm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

GRADE_SHARES = {"measured": 0.2, "published": 0.4, "given": 0.5, "derived": 0.7, "assumed": 1.0}
"""Prior sd over that of an assumed number, by the grade of the machine file's number."""
FUEL_L_PER_KWH = 0.316
"""Of ASABE D497.7 at rated power, where an engine's own is not given."""


@dataclass(frozen=True, kw_only=True)
class Known:
    """One parameter."""

    name: str
    unit: str
    about: str
    """What it is called in a sentence."""
    spread: float
    """Prior sd of its logarithm where its value is assumed."""
    low: float
    high: float
    settles: str
    """The measurement that separates it from the others."""
    numerics: Callable[[Mapping[str, float], float], dict[str, float]] | None = None
    """Numerics of a hand-made MJCF for a value; None where only a machine's file can hold it."""
    read: Callable[[Mapping[str, float]], float] | None = None
    """Its value from the numerics of a hand-made MJCF."""


def _numeric(name: str, default: float | None = None) -> dict[str, Any]:
    """Reader and writer of a parameter that is one numeric."""
    return {
        "numerics": lambda numbers, value: {name: value},
        "read": lambda numbers: numbers[name] if default is None else numbers.get(name, default),
    }


def _droop(numbers: Mapping[str, float], no_load_rpm: float) -> dict[str, float]:
    """No-load speed and the governor's droop that follows from it."""
    over_rpm = no_load_rpm - numbers["engine.rated_rpm"]
    return {
        "engine.no_load_rpm": no_load_rpm,
        "engine.droop_rpm_per_nm": over_rpm / numbers["engine.rated_torque_nm"],
    }


MACHINE = (
    Known(
        name="rear.free_rolling_radius_m", unit="m", about="rear radius", spread=0.03, low=0.1,
        high=1.5, settles="a drive on a hard road with the plough up, or a measured roll-out",
        **_numeric("tyre_rear.free_rolling_radius_m"),
    ),
    Known(
        name="front.free_rolling_radius_m", unit="m", about="front radius", spread=0.03, low=0.1,
        high=1.5, settles="front wheel speeds on a hard road with the plough up",
        **_numeric("tyre_front.free_rolling_radius_m"),
    ),
    Known(
        name="mass_kg", unit="kg", about="mass", spread=0.10, low=20.0, high=60000.0,
        settles="a weighbridge, or driving up and down a grade that is known",
    ),
    Known(
        name="transmission.efficiency", unit="-", about="transmission's efficiency", spread=0.05,
        low=0.5, high=0.99, settles="engine torque and axle torque in one log",
        **_numeric("engine.transmission_efficiency"),
    ),
    Known(
        name="engine.rated_power_kw", unit="kW", about="rated power", spread=0.06, low=0.05,
        high=1000.0, settles="a dynamometer at the crank, or drawbar power on a hard road",
    ),
    Known(
        name="engine.pto_efficiency", unit="-", about="PTO's efficiency", spread=0.03,
        low=0.5, high=1.0, settles="engine torque beside the PTO's",
    ),
    Known(
        name="engine.parasitic_nm", unit="N m", about="engine's parasitic torque", spread=0.5,
        low=0.1, high=500.0, settles="engine torque while standing with the engine running",
        **_numeric("engine.parasitic_nm"),
    ),
    Known(
        name="engine.no_load_rpm", unit="rpm", about="engine's no-load speed", spread=0.03,
        low=300.0, high=9000.0, settles="engine speed at one lever setting with and without load",
        numerics=_droop, read=lambda numbers: numbers["engine.no_load_rpm"],
    ),
    Known(
        name="engine.fuel_l_per_kwh", unit="L/kWh", about="fuel per energy", spread=0.10, low=0.15,
        high=1.0, settles="fuel rate with axle torque, or on a dynamometer",
    ),
)  # fmt: skip
SOIL = (
    Known(
        name="soil.cone_index_kpa", unit="kPa", about="cone index", spread=0.5, low=50.0,
        high=5000.0, settles="a penetrometer, or a coast-down beside a pass with the plough up",
    ),
    Known(
        name="soil.k_phi_kn_per_m_n2", unit="kN/m**(n+2)", about="modulus of sinkage", spread=0.5,
        low=150.0, high=50000.0, settles="a plate pressed into the soil, or a coast-down",
    ),
    Known(
        name="soil.shear_modulus_m", unit="m", about="shear modulus", spread=0.3, low=0.004,
        high=0.15, settles="a shear ring, or pulls at small and at large slip",
    ),
    Known(
        name="soil.friction", unit="-", about="friction", spread=0.07, low=0.05, high=1.5,
        settles="a pull until the wheels spin",
    ),
    Known(
        name="soil.draft_scale", unit="-", about="draft scale", spread=0.5, low=0.02, high=2.0,
        settles="a drawbar pin, or engine load while ploughing",
    ),
    Known(
        name="soil.mobility_resistance", unit="-", about="rolling resistance", spread=0.3, low=0.05,
        high=10.0, settles="a coast-down, or a pass with the plough up",
    ),
)  # fmt: skip
LOG = (
    Known(
        name="log.set_rpm", unit="rpm", about="engine speed that the throttle asks for",
        spread=0.05, low=100.0, high=9000.0, settles="engine speed without load",
    ),
    Known(
        name="log.reference_torque_nm", unit="N m", about="torque that is an engine load of 1",
        spread=0.3, low=1.0, high=10000.0, settles="the data sheet's reference torque (SPN 544)",
    ),
    Known(
        name="log.carried_kg", unit="kg", about="load that the implement puts on the tractor",
        spread=0.7, low=1.0, high=20000.0, settles="a weighbridge with the implement in the ground",
    ),
    Known(
        name="log.wheel_scale", unit="-", about="true over logged wheel speed at zero slip",
        spread=0.03, low=0.5, high=2.0, settles="driving on a hard road with nothing in the ground",
    ),
)  # fmt: skip
OF_LAW = {
    "brixius": ("friction", "cone_index_kpa", "mobility_resistance", "draft_scale"),
    "bekker": ("friction", "k_phi_kn_per_m_n2", "shear_modulus_m", "draft_scale"),
}
"""What of a soil each law, and the draft, depends on."""
KNOWN = {known.name: known for known in (*MACHINE, *SOIL, *LOG)}


def known(name: str) -> Known:
    """The parameter of a name; `log.set_rpm.2` is the second of its kind."""
    stem = name.rstrip("0123456789").rstrip(".")
    return KNOWN[name] if name in KNOWN else KNOWN[stem]
