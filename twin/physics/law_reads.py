"""Which of a soil's numbers a law reads: what the text of a user's law names, or what moves it."""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Callable

import numpy as np

from twin.physics.block import Soil, Wheel
from twin.physics.shapes import Forces
from twin.plugins.lookup import attribute

SLOTS = {
    "friction": (Soil.FRICTION, Soil.COHESION_PA, Soil.TAN_PHI),
    "cone_index_kpa": (Soil.CONE_INDEX_KPA,),
    "k_c_kn_per_m_n1": (Soil.K_C,),
    "k_phi_kn_per_m_n2": (Soil.K_PHI,),
    "sinkage_exponent": (Soil.SINKAGE_EXPONENT,),
    "cohesion_kpa": (Soil.COHESION_PA,),
    "friction_angle_deg": (Soil.TAN_PHI,),
    "shear_modulus_m": (Soil.SHEAR_LONG_M, Soil.SHEAR_LAT_M),
    "lateral_shear_ratio": (Soil.SHEAR_LAT_M,),
    "unit_weight_knpm3": (Soil.UNIT_WEIGHT_NPM3,),
    "stress_peak": (Soil.PEAK,),
    "stress_peak_slip": (Soil.PEAK_SLIP,),
    "slip_sinkage": (Soil.SLIP_SINKAGE,),
}
"""Field of a scenario's soil -> the numbers of the parameter block that it sets."""
_TYPICAL = {
    Soil.FRICTION: 0.8, Soil.CONE_INDEX_KPA: 900.0, Soil.SLIP_RATE: 7.5, Soil.ROLLING_MOMENT: 0.04,
    Soil.MOBILITY_RESISTANCE: 1.0, Soil.DRAFT_SCALE: 0.7, Soil.K_C: 1e4, Soil.K_PHI: 1e6,
    Soil.SINKAGE_EXPONENT: 0.8, Soil.COHESION_PA: 1e4, Soil.TAN_PHI: 0.6, Soil.SHEAR_LONG_M: 0.05,
    Soil.SHEAR_LAT_M: 0.05, Soil.UNIT_WEIGHT_NPM3: 1.5e4, Soil.PEAK: 0.4, Soil.PEAK_SLIP: 0.15,
    Soil.SLIP_SINKAGE: 1.0,
    Wheel.WIDTH_M: 0.467, Wheel.DIAMETER_M: 1.755, Wheel.DEFLECTION_RATIO: 0.2,
    Wheel.FREE_ROLLING_RADIUS_M: 0.85, Wheel.STIFFNESS_NPM: 3.83e5, Wheel.LATERAL_RATIO: 0.85,
    Wheel.RELAXATION_LONG_M: 0.3, Wheel.RELAXATION_LAT_M: 0.6,
}  # fmt: skip
"""A field, and the rear tyre of a tractor on it."""
_POINTS = tuple(itertools.product((3e3, 3e4), (-0.3, 0.0, 0.05, 0.6), (0.0, 0.2)))
"""Loads [N], slips and side slips at which a law is asked."""


def fields_read(name: str) -> frozenset[str]:
    """The fields in `SLOTS` that a user's law reads.

    A field is read if the text of the law's module contains the name of a number that the field
    sets, or if the law's result changes at some load and slip when that number is a tenth less.
    A law that cannot be called here is taken to read all.

    Args:
        name: the law, `module:function`.

    Raises:
        BadInput: there is no such law.
    """
    law: Callable[..., Forces] = attribute("soil law", name)
    law = getattr(law, "py_func", law)
    try:
        text = inspect.getsource(inspect.getmodule(law))  # type: ignore[arg-type]
        usual = _answers(law, ())
        moved = {f for f, slots in SLOTS.items() if _answers(law, slots) != usual}
    except Exception:  # whatever a user's law raises; compiling it will say what is wrong
        return frozenset(SLOTS)
    return frozenset(
        f for f, slots in SLOTS.items() if f in moved or any(s.name in text for s in slots)
    )


def _answers(law: Callable[..., Forces], lowered: tuple[Soil, ...]) -> bytes:
    """What a law says at all points, on a soil of which some numbers are a tenth less."""
    soil, wheel = np.zeros(Soil.SIZE), np.zeros(Wheel.SIZE)
    for slot, value in _TYPICAL.items():
        (soil if isinstance(slot, Soil) else wheel)[slot] = value
    soil[list(lowered)] *= 0.9
    with np.errstate(all="ignore"):
        said = [law(soil.copy(), wheel.copy(), *point) for point in _POINTS]
    return np.array(said, dtype=np.float64).tobytes()
