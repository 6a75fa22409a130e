"""The ground's material: a preset, and what a scenario changes of it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

from twin.errors import BadInput, OutOfRange, UnknownName, check_range
from twin.io.plain import Plain
from twin.scenario.soil_files import preset as preset_of
from twin.scenario.soils import LAWS, PRESETS, Deformable, Preset

FRICTIONS, CONE_INDICES_KPA = (0.05, 1.5), (50.0, 5000.0)
"""Friction and cone index that a soil may have, on its patches too."""
DEFORMABLE_RANGES = {
    "k_c_kn_per_m_n1": (0.0, 1000.0),
    "k_phi_kn_per_m_n2": (10.0, 1e5),
    "sinkage_exponent": (0.1, 1.6),
    "cohesion_kpa": (0.0, 150.0),
    "friction_angle_deg": (0.0, 50.0),
    "shear_modulus_m": (0.002, 0.2),
    "lateral_shear_ratio": (0.2, 5.0),
    "unit_weight_knpm3": (0.0, 25.0),
    "stress_peak": (0.0, 0.8),
    "stress_peak_slip": (0.0, 0.5),
    "slip_sinkage": (0.0, 5.0),
}
"""Ranges of what Bekker's law needs, somewhat wider than Wong's tables."""
LEAST_BORNE_KPA = 20.0
"""Pressure at 0.1 m sinkage a wheel needs [kPa]; the softest of Wong's soils has 27."""
BORNE_PER_COHESION = 3.0
"""That pressure over the cohesion, at least [-]; 5.1 for a strip on clay (Prandtl)."""
NEEDED = tuple(DEFORMABLE_RANGES)[:6]
"""What of it has no general value."""
KEPT_RANGES = {
    "friction": (0.05, 1.5),
    "front_grip": (0.01, 10.0),
    "slip_rate": (0.1, 100.0),
    "rolling_moment": (0.0, 1.0),
    "mobility_resistance": (0.0, 10.0),
}
"""Ranges of a preset's numbers that are no fields of a soil, or that its fields are set against."""


@dataclass(frozen=True, kw_only=True)
class Soil:
    """The ground's material. What is None follows the preset."""

    preset: str = "firm"
    """Soil by name: firm, tilled, soft, asphalt, gravel, dry, wet, grass, sandy-loam-11,
    sandy-loam-15, sandy-loam-22, sandy-loam-23, clayey-38, heavy-clay-25, lean-clay-22,
    upland-sandy-loam-51, rubicon-sandy-loam-43, north-gower-46, grenville-loam-24, dry-sand,
    lete-sand. `twin list` says what each is. Or a soil's TOML file, as twin calibrate writes."""
    law: str = "brixius"
    """Tyre-soil law: brixius, bekker, or your own as module:function."""
    friction: float | None = None
    """Ceiling of the gross traction ratio [-]; 0.88 in Brixius. Cohesion and tan(phi) in Bekker's
    law are multiplied by this over the preset's own friction."""
    cone_index_kpa: float | None = None
    """Cone index [kPa]; soft 450, tilled 900, firm 1200."""
    draft_scale: float | None = None
    """F of ASABE D497 [-]; coarse 0.45, medium 0.70, fine 1.00."""
    draft_cv: float = 0.12
    """Coefficient of variation of one share's draft with place [-]."""
    draft_length_m: float = 4.0
    """Distance between independent values of the draft's variation [m]."""
    ripple_cv: float = 0.08
    """Coefficient of variation of one share's draft by shear failure, wave by wave [-]."""
    strength_cv: float | None = None
    """Coefficient of variation of friction and cone index with place [-]."""
    rocks_per_100m2: float = 0.0
    """Rocks in the plough's way per 100 m2 of ground [-]."""
    rock_kn: float = 15.0
    """Extra draft of a rock at its peak [kN]."""
    k_c_kn_per_m_n1: float | None = None
    """Bekker's cohesive modulus of deformation [kN/m**(n + 1)]; LETE sand 102."""
    k_phi_kn_per_m_n2: float | None = None
    """Bekker's frictional modulus of deformation [kN/m**(n + 2)]; LETE sand 5301."""
    sinkage_exponent: float | None = None
    """Bekker's exponent n of the sinkage [-]; LETE sand 0.793."""
    cohesion_kpa: float | None = None
    """Cohesion c in Bekker's law [kPa]; LETE sand 1.3."""
    friction_angle_deg: float | None = None
    """Angle of internal friction phi in Bekker's law [deg]; LETE sand 31.1."""
    shear_modulus_m: float | None = None
    """Janosi's shear deformation modulus K in Bekker's law [m]; LETE sand 0.012."""
    lateral_shear_ratio: float | None = None
    """K across the wheel over K along it [-]."""
    unit_weight_knpm3: float | None = None
    """Unit weight of the soil a sideslipping wheel pushes aside, in Bekker's law [kN/m3]."""
    stress_peak: float | None = None
    """c_1 in theta_m = (c_1 + c_2 |s|) theta_1, the place of the greatest normal stress [-]."""
    stress_peak_slip: float | None = None
    """c_2 in it [-]; with both 0 the stress is Bekker's, greatest under the hub."""
    slip_sinkage: float | None = None
    """S in Bekker's law: slip s sinks a wheel 1 + S s times as deep [-]; 1 after Lyasko 2010."""
    numbers: Preset | None = None
    """The preset's own numbers as a run has kept them in its scenario.json; None looks them up."""

    def __post_init__(self) -> None:
        if not self._keeps_preset and preset_of(self.preset) is None:
            raise UnknownName("soil preset", self.preset, PRESETS)
        if self.law not in LAWS and ":" not in self.law:
            raise UnknownName("soil law", self.law, LAWS)
        resolved = self.resolved
        check_range("soil.friction", resolved.friction, *FRICTIONS)
        if self.cone_index_kpa is not None or not math.isnan(resolved.cone_index_kpa):
            check_range("soil.cone_index_kpa", resolved.cone_index_kpa, *CONE_INDICES_KPA)
        elif self.law == "brixius":
            raise BadInput(
                f"soil preset '{self.preset}' has no cone index, which Brixius' law needs; "
                "set soil.cone_index_kpa, or soil.law to bekker"
            )
        if resolved.deformable is not None:
            known = PRESETS.get(self.preset)
            if known is None or resolved.deformable is not known.deformable:  # those are in range
                for name, (low, high) in DEFORMABLE_RANGES.items():
                    check_range(f"soil.{name}", getattr(resolved.deformable, name), low, high)
            if self.law == "bekker":
                _check_bearing(resolved.deformable, self.friction_scale)
        elif self.law == "bekker":
            raise BadInput(
                f"soil preset '{self.preset}' has no numbers for Bekker's law; another preset, "
                f"or all of soil.{', soil.'.join(NEEDED)}, would do"
            )
        check_range("soil.draft_scale", resolved.draft_scale, 0.0, 2.0)
        check_range("soil.draft_cv", self.draft_cv, 0.0, 0.5)
        check_range("soil.draft_length_m", self.draft_length_m, 0.2, 100.0)
        check_range("soil.ripple_cv", self.ripple_cv, 0.0, 0.5)
        check_range("soil.strength_cv", resolved.strength_cv, 0.0, 0.3)
        check_range("soil.rocks_per_100m2", self.rocks_per_100m2, 0.0, 25.0)
        check_range("soil.rock_kn", self.rock_kn, 0.0, 50.0)
        if self.numbers is not None:
            for name, (low, high) in KEPT_RANGES.items():
                check_range(f"soil.numbers.{name}", getattr(self.numbers, name), low, high)

    @property
    def _keeps_preset(self) -> bool:
        """Whether the kept numbers are those of the preset; beside another they mean nothing."""
        return self.numbers is not None and self.numbers.name == self.preset

    @property
    def _preset(self) -> Preset:
        kept = self.numbers if self._keeps_preset else None
        found = preset_of(self.preset) if kept is None else kept
        assert found is not None
        return found

    def with_numbers(self) -> Soil:
        """The same soil, which no edit of the preset changes any more."""
        return dataclasses.replace(
            self, numbers=dataclasses.replace(self._preset, name=self.preset)
        )

    @cached_property
    def resolved(self) -> Preset:
        """The preset with this soil's own numbers in place."""
        preset = self._preset
        own = self._given("friction", "cone_index_kpa", "draft_scale", "strength_cv")
        return dataclasses.replace(preset, **own, deformable=self._deformable(preset.deformable))

    @property
    def friction_scale(self) -> float:
        """Friction over the preset's own: what cohesion and tan(phi) are multiplied by [-]."""
        return self.resolved.friction / self._preset.friction

    def _deformable(self, preset: Deformable | None) -> Deformable | None:
        own = self._given(*DEFORMABLE_RANGES)
        if preset is not None:
            return dataclasses.replace(preset, **own) if own else preset
        return Deformable(**own) if own.keys() >= set(NEEDED) else None

    def _given(self, *names: str) -> dict[str, Plain]:
        """The named fields that are not None."""
        return {n: value for n in names if (value := getattr(self, n)) is not None}


def _check_bearing(soil: Deformable, friction_scale: float) -> None:
    """Refuse a soil that bears less than a wheel needs, or than its own cohesion lets it bear."""
    borne_kpa = soil.k_phi_kn_per_m_n2 * 0.1**soil.sinkage_exponent
    cohesion_kpa = friction_scale * soil.cohesion_kpa
    least_kpa = max(LEAST_BORNE_KPA, BORNE_PER_COHESION * cohesion_kpa)
    scaled = "" if friction_scale == 1.0 else f" times {friction_scale:.3g} by soil.friction"
    if borne_kpa < least_kpa:
        raise OutOfRange(
            "soil.k_phi_kn_per_m_n2",
            f"{soil.k_phi_kn_per_m_n2:g}",
            f"what this soil can have: at soil.sinkage_exponent {soil.sinkage_exponent:g} it bears "
            f"{borne_kpa:.3g} kPa at 0.1 m, and with soil.cohesion_kpa {soil.cohesion_kpa:g}"
            f"{scaled} at least {least_kpa:.3g} kPa would do",
        )
