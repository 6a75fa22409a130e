"""Soil presets, and what of them the laws need."""

from __future__ import annotations

from dataclasses import dataclass

LAWS = ("brixius",)
"""Soil laws by name, in the order of their numbers in the parameter block."""


@dataclass(frozen=True, kw_only=True)
class Preset:
    """A kind of ground; the numbers a scenario's Soil falls back on."""

    about: str
    cone_index_kpa: float
    """Cone index [kPa]."""
    friction: float = 0.88
    """Ceiling of the gross traction ratio; 0.88 in Brixius 1987."""
    slip_rate: float = 7.5
    """k in 1 - exp(-k s); 7.5 for bias tyres, 9.5 for radials (Brixius 1987)."""
    rolling_moment: float = 0.04
    """c0: 0.04 bias, 0.0325 radial (Brixius 1987)."""
    mobility_resistance: float = 1.0
    """m in m / Bn: 1.0 bias, 0.9 radial (Brixius 1987)."""
    strength_cv: float = 0.05
    """How much friction and cone index vary from place to place [-]; assumed."""
    draft_scale: float = 0.70
    """F of ASABE D497: 1.00 fine, 0.70 medium, 0.45 coarse soils."""


PRESETS: dict[str, Preset] = {
    "firm": Preset(
        about="firm field, CI 1200 kPa (D497 firm)", cone_index_kpa=1200.0, draft_scale=0.87,
    ),
    "tilled": Preset(about="tilled field, CI 900 kPa (D497 tilled)", cone_index_kpa=900.0),
    "soft": Preset(
        about="soft or sandy field, CI 450 kPa (D497 soft)", cone_index_kpa=450.0, draft_scale=0.45,
    ),
    "asphalt": Preset(
        about="asphalt, beyond Brixius' range: k, c0, m assumed",
        cone_index_kpa=4000.0, friction=0.95, slip_rate=20.0, rolling_moment=0.015,
        mobility_resistance=0.5,
        strength_cv=0.01,
    ),
    "gravel": Preset(
        about="gravel road, beyond Brixius' range: k, c0 assumed",
        cone_index_kpa=2500.0, friction=0.70, slip_rate=12.0, rolling_moment=0.025,
        strength_cv=0.10,
    ),
    "grass": Preset(
        about="short grass on firm soil; friction assumed",
        cone_index_kpa=1500.0, friction=0.65, strength_cv=0.10,
    ),
}  # fmt: skip
"""Cone indices of the fields: ASABE D497's classes. The roads and grass are extrapolations."""
