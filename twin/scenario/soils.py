"""Soil presets, and what of them the laws need."""

from __future__ import annotations

import math
from dataclasses import dataclass

LAWS = ("brixius", "bekker")
"""Soil laws by name, in the order of their numbers in the parameter block."""
BLEND_M = 0.5
"""Length over which one patch of soil passes into the next [m]: about that of a contact."""


@dataclass(frozen=True, kw_only=True)
class Deformable:
    """Numbers of Bekker's pressure-sinkage and Janosi-Hanamoto's shear; Wong 2008, chapter 2."""

    k_c_kn_per_m_n1: float
    """Cohesive modulus of deformation k_c [kN/m**(n + 1)]."""
    k_phi_kn_per_m_n2: float
    """Frictional modulus of deformation k_phi [kN/m**(n + 2)]."""
    sinkage_exponent: float
    """n [-]."""
    cohesion_kpa: float
    """c [kPa]."""
    friction_angle_deg: float
    """phi [deg]."""
    shear_modulus_m: float
    """Janosi's K along the wheel [m]."""
    lateral_shear_ratio: float = 1.0
    """K across over K along [-]; assumed."""
    unit_weight_knpm3: float = 15.0
    """Unit weight [kN/m3]; 13 to 18 in topsoils, assumed."""
    stress_peak: float = 0.40
    """c_1 of the greatest normal stress' place, theta_m = (c_1 + c_2 |s|) theta_1 [-]; 0.40 after
    Wong & Reece 1967 (0.18 to 0.43 in their sands); with both 0, Bekker's own stress."""
    stress_peak_slip: float = 0.15
    """c_2 of it [-]; 0 to 0.3."""
    slip_sinkage: float = 1.0
    """S in z = z_0 (1 + S s), how much deeper a slipping wheel sinks [-]; Lyasko 2010 as others
    transcribe him, 1 to 1.8 there, assumed in every soil."""


@dataclass(frozen=True, kw_only=True)
class Preset:
    """A kind of ground; the numbers a scenario's Soil falls back on."""

    about: str
    cone_index_kpa: float = math.nan
    """Cone index [kPa]; NaN where none was measured."""
    deformable: Deformable | None = None
    """What Bekker's law needs; None on ground a wheel does not sink into, or not measured."""
    friction: float = 0.88
    """Ceiling of the gross traction ratio; 0.88 in Brixius 1987."""
    front_grip: float = 1.0
    """Lateral stiffness of the front tyres here over their own on dry soil.

    Lugs hold, ribs do not.
    """
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
    name: str = ""
    """What it is called, where a scenario keeps its numbers."""


def _sinking(
    k_c: float, k_phi: float, n: float, c_kpa: float, phi_deg: float, shear_m: float
) -> Deformable:
    return Deformable(
        k_c_kn_per_m_n1=k_c,
        k_phi_kn_per_m_n2=k_phi,
        sinkage_exponent=n,
        cohesion_kpa=c_kpa,
        friction_angle_deg=phi_deg,
        shear_modulus_m=shear_m,
    )


FIELDS: dict[str, Preset] = {
    "firm": Preset(
        about="firm field, CI 1200 kPa (D497 firm)", cone_index_kpa=1200.0, draft_scale=0.87,
        deformable=_sinking(0.0, 1340.0, 0.80, 4.0, 43.7, 0.052),
    ),
    "tilled": Preset(
        about="tilled field, CI 900 kPa (D497 tilled)", cone_index_kpa=900.0,
        deformable=_sinking(0.0, 1210.0, 0.80, 4.0, 43.2, 0.053),
    ),
    "soft": Preset(
        about="soft or sandy field, CI 450 kPa (D497 soft)", cone_index_kpa=450.0, draft_scale=0.45,
        deformable=_sinking(0.0, 880.0, 0.80, 16.0, 29.1, 0.052),
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
    "dry": Preset(
        about="sandy loam at 11 % moisture under a light tractor; beyond Brixius' range",
        cone_index_kpa=1200.0, strength_cv=0.02,
    ),
    "wet": Preset(
        about="sandy loam at 18 % moisture under a light tractor; front grip set by its slides",
        cone_index_kpa=700.0, strength_cv=0.02, front_grip=0.78,
    ),
    "grass": Preset(
        about="short grass on firm soil; friction assumed",
        cone_index_kpa=1500.0, friction=0.65, strength_cv=0.10,
    ),
}  # fmt: skip
"""Cone indices of the fields: ASABE D497's classes. The roads and grass are extrapolations. The
fields' numbers for Bekker's law are fitted, so that an 18.4-38 tyre under 16 to 26 kN has Brixius'
net and gross traction at 3 to 30 % slip (rms 2.2, 2.7 and 3.5 % of the load) and no more than his
gross traction at full slip, which is what the soil bears. n and c are chosen, c as loams have it in
Wong's table (median 3.5 kPa); soft soil needs more of it, for its traction falls as load grows: no
soil was measured."""

MEASURED: dict[str, tuple[str, Deformable]] = {
    "sandy-loam-11": (
        "sandy loam, 11 % moisture (Strong & Buchele)",
        _sinking(52.53, 1127.97, 0.90, 4.83, 20.0, 0.020),
    ),
    "sandy-loam-15": (
        "sandy loam, 15 % moisture (Land Locomotion Laboratory)",
        _sinking(5.27, 1515.04, 0.70, 1.72, 29.0, 0.025),
    ),
    "sandy-loam-22": (
        "sandy loam, 22 % moisture (Land Locomotion Laboratory); carries no tractor",
        _sinking(2.56, 43.12, 0.20, 1.38, 38.0, 0.020),
    ),
    "sandy-loam-23": (
        "sandy loam, 23 % moisture",
        _sinking(11.42, 808.96, 0.40, 9.65, 35.0, 0.020),
    ),
    "clayey-38": (
        "clayey soil, 38 % moisture (Thailand)",
        _sinking(13.19, 692.15, 0.50, 4.14, 13.0, 0.010),
    ),
    "heavy-clay-25": (
        "heavy clay, 25 % moisture",
        _sinking(12.70, 1555.95, 0.13, 68.95, 34.0, 0.006),
    ),
    "lean-clay-22": (
        "lean clay, 22 % moisture",
        _sinking(16.43, 1724.69, 0.20, 68.95, 20.0, 0.006),
    ),
    "upland-sandy-loam-51": (
        "upland sandy loam, 51 % moisture, loosened",
        _sinking(74.6, 2080.0, 1.10, 3.3, 33.7, 0.025),
    ),
    "rubicon-sandy-loam-43": (
        "Rubicon sandy loam, 43 % moisture",
        _sinking(6.9, 752.0, 0.66, 3.7, 29.8, 0.018),
    ),
    "north-gower-46": (
        "North Gower clayey loam, 46 % moisture",
        _sinking(41.6, 2471.0, 0.73, 6.1, 26.6, 0.020),
    ),
    "grenville-loam-24": (
        "Grenville loam, 24 % moisture",
        _sinking(0.06, 5880.0, 1.01, 3.1, 29.8, 0.015),
    ),
    "dry-sand": (
        "dry sand (Land Locomotion Laboratory)",
        _sinking(0.99, 1528.43, 1.10, 1.04, 28.0, 0.012),
    ),
    "lete-sand": (
        "LETE sand, dry",
        _sinking(102.0, 5301.0, 0.793, 1.3, 31.1, 0.012),
    ),
}  # fmt: skip
"""Wong 2008, Theory of Ground Vehicles, table 2.3: k_c, k_phi, n, c, phi. The shear moduli are what
the book gives for like soils, most of them assumed. No cone index was measured with them."""

PRESETS: dict[str, Preset] = FIELDS | {
    name: Preset(about=f"{about}; Bekker's law alone", deformable=numbers)
    for name, (about, numbers) in MEASURED.items()
}
