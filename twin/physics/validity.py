"""Whether a wheel on a soil is inside the range in which the soil's law was measured."""

from __future__ import annotations

import math

from twin.physics.bekker import bekker, hard_deflection_m
from twin.physics.block import Soil, Wheel
from twin.physics.shapes import Array
from twin.scenario.soils import LAWS

PRESSURE_KPA = (15.0, 55.0)
"""W / (b d) of the tyres behind Brixius' law [kPa]; Brixius 1987, ASABE D497."""
SLENDERNESS = (0.1, 0.7)
"""b / d of them [-]."""
DEFLECTION_RATIO = (0.10, 0.30)
"""delta / h of them [-]."""
DEEP = 0.25
"""Sinkage over diameter beyond which Bekker's plate is a poor model of a wheel [-]; assumed."""
NARROW_M = 0.05
"""Contact shorter or narrower than this is too small for k_c / b + k_phi; Wong 2008, chapter 2."""


def outside_validity(soil: Array, wheel: Array, load_n: float) -> tuple[str, ...]:
    """Messages on what lies outside the range of the soil's law, one sentence each.

    Brixius: W / (b d), b / d and delta / h, with the load W, the tyre's width b and diameter d, and
    its deflection delta over its section height h. Bekker: the sinkage at rest, and the contact's
    size. There is no message for a user's own law.

    Args:
        soil, wheel: parts of the parameter block (`Soil`, `Wheel`).
        load_n: load of the wheel.
    """
    law = int(soil[Soil.LAW])
    if law == LAWS.index("brixius"):
        return _brixius(wheel, load_n)
    if law == LAWS.index("bekker"):
        return _bekker(soil, wheel, load_n)
    return ()


def _brixius(wheel: Array, load_n: float) -> tuple[str, ...]:
    tyres = 1.0 + float(wheel[Wheel.PAIRED])
    b, d = float(wheel[Wheel.WIDTH_M]) / tyres, float(wheel[Wheel.DIAMETER_M])
    load_n, ratio = load_n / tyres, float(wheel[Wheel.DEFLECTION_RATIO])
    measured = (
        ("W/(b d)", 1e-3 * load_n / (b * d), PRESSURE_KPA, " kPa"),
        ("b/d", b / d, SLENDERNESS, ""),
        ("delta/h", ratio, DEFLECTION_RATIO, ""),
    )
    return tuple(
        f"{name} = {value:.3g}{unit} is outside [{low:g}, {high:g}]{unit}, where Brixius' law holds"
        for name, value, (low, high), unit in measured
        if not low <= value <= high
    )


def _bekker(soil: Array, wheel: Array, load_n: float) -> tuple[str, ...]:
    d, b = float(wheel[Wheel.DIAMETER_M]), float(wheel[Wheel.WIDTH_M])
    z = float(bekker(soil, wheel, load_n, 0.0, 0.0)[4])
    f = float(hard_deflection_m(wheel, load_n))
    length = math.sqrt(d * (z + f)) + math.sqrt(d * f)
    out = []
    if z > DEEP * d:
        out.append(
            f"a load of {load_n:.0f} N sinks a wheel of diameter {d:.2f} m by {z:.2f} m, "
            f"more than {DEEP:g} of it: the soil does not carry it, or Bekker's law does not hold"
        )
    if min(b, length) < NARROW_M:
        out.append(
            f"a contact of {length:.3f} m x {b:.3f} m is smaller than {NARROW_M:g} m, "
            "where Bekker's moduli mean little"
        )
    return tuple(out)
