"""The shape of the ground, and stretches of it where the soil differs."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange, UnknownName, check_range
from twin.scenario.soil import CONE_INDICES_KPA, FRICTIONS, Soil
from twin.scenario.soils import BLEND_M, Preset

ROUGHNESS = {"smooth": 0.0, **{c: 16e-6 * 4.0**i for i, c in enumerate("ABCDEF")}}
"""G_d(n0) at n0 = 0.1 cycles/m [m3]: geometric means of ISO 8608's classes."""
MOST_PATCHES = 4


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A stretch of the course where the soil differs."""

    start_m: float
    """Start of the patch along the course [m]."""
    length_m: float
    """Length of the patch along the course [m]."""
    friction_factor: float = 1.0
    """Friction there, over that of the soil around [-]."""
    cone_index_factor: float = 1.0
    """Cone index there, over that of the soil around [-]."""

    def __post_init__(self) -> None:
        check_range("patch.start_m", self.start_m, -20000.0, 10000.0)
        check_range("patch.length_m", self.length_m, 0.5, 40000.0)
        check_range("patch.friction_factor", self.friction_factor, 0.1, 2.0)
        check_range("patch.cone_index_factor", self.cone_index_factor, 0.1, 4.0)


SOFT = Soil(preset="soft")


@dataclass(frozen=True, kw_only=True)
class Field:
    """The shape of the ground."""

    cross_slope_deg: float = 0.0
    """Slope across the course [deg]; positive rises to the left."""
    grade_deg: float = 0.0
    """Slope along the course [deg]; positive rises ahead."""
    roughness_class: str = "smooth"
    """Roughness of the surface by ISO 8608, A to F; "smooth" is a plane."""
    height_map: str | None = None
    """Your own heights above the plane: a .npy file of metres, columns along the course, rows
    across it from the right, the middle row on the course's line. Instead of a roughness class."""
    soil_map: str | None = None
    """Share of `other_soil` by place: a .npy file of shares from 0 to 1, laid as `height_map`."""
    map_cell_m: float = 0.25
    """Distance between the nodes of your maps [m]."""
    map_start_m: float = -10.0
    """Place of the maps' first column along the course [m]; beyond it the border's values hold."""
    other_share: float = 0.0
    """Share of the ground covered by random areas of `other_soil` [-]."""
    other_length_m: float = 10.0
    """Size of those areas [m]."""
    other_soil: Soil = SOFT
    """The other soil of the map or of the random areas: its law, friction, strength and draft
    scale. Variation with place and rocks are those of `soil` everywhere."""
    patches: tuple[Patch, ...] = ()
    """Stretches where friction and cone index are scaled, four at most; they multiply."""

    @property
    def mixed(self) -> bool:
        """Whether some of the ground is of the other soil."""
        return self.soil_map is not None or self.other_share > 0.0

    def __post_init__(self) -> None:
        check_range("field.cross_slope_deg", self.cross_slope_deg, -25.0, 25.0)
        check_range("field.grade_deg", self.grade_deg, -15.0, 15.0)
        if len(self.patches) > MOST_PATCHES:
            raise OutOfRange("field.patches", len(self.patches), f"0 to {MOST_PATCHES} patches")
        if self.roughness_class not in ROUGHNESS:
            raise UnknownName("roughness class", self.roughness_class, ROUGHNESS)
        if self.height_map is not None and self.roughness_class != "smooth":
            raise BadInput(
                f"field.height_map goes without field.roughness_class = {self.roughness_class}: "
                "the map has its own roughness; leave one of them"
            )
        if self.soil_map is not None and self.other_share > 0.0:
            raise BadInput(
                f"field.soil_map goes without field.other_share = {self.other_share:g}: the map "
                "says where the other soil is; leave one of them"
            )
        check_range("field.map_cell_m", self.map_cell_m, 0.02, 10.0)
        check_range("field.map_start_m", self.map_start_m, -1000.0, 1000.0)
        check_range("field.other_share", self.other_share, 0.0, 0.9)
        check_range("field.other_length_m", self.other_length_m, 1.0, 100.0)


def factor_at(patches: tuple[Patch, ...], kind: str, s_m: float) -> float:
    """Product of the patches' factors at a place along the course, as `physics.ground` has it.

    Each edge is a ramp of length `BLEND_M` with its middle at the edge.

    Args:
        patches: those of a ground.
        kind: "friction_factor" or "cone_index_factor".
        s_m: place along the course [m].
    """
    return float(math.prod(1.0 + _share(p, s_m) * (getattr(p, kind) - 1.0) for p in patches))


def _share(patch: Patch, s_m: float) -> float:
    """How much of a patch's factor acts at a place [-]: 1 inside, 0 outside."""
    inside_m = min(s_m - patch.start_m, patch.start_m + patch.length_m - s_m)
    return min(1.0, max(0.0, inside_m / BLEND_M + 0.5))


def check_patches(where: str, soil: Preset, patches: tuple[Patch, ...]) -> None:
    """Refuse patches on which a soil would leave the ranges it is held to elsewhere.

    The places looked at are each edge, and the ends of its ramp: there the patches that act change.

    Args:
        where: the soil's field in a scenario.
        soil: its numbers.
        patches: those of the ground it lies on.

    Raises:
        OutOfRange: friction or cone index of the soil times the factors of all patches at a place.
            It names the patch there whose factor is furthest from 1.
    """
    edges_m = (edge for p in patches for edge in (p.start_m, p.start_m + p.length_m))
    ramp_m = (-0.5 * BLEND_M, 0.0, 0.5 * BLEND_M)
    places_m = sorted({edge + step for edge in edges_m for step in ramp_m})
    ranges = {"friction": FRICTIONS, "cone_index_kpa": CONE_INDICES_KPA}
    for s_m, (name, (low, high)) in itertools.product(places_m, ranges.items()):
        kind = f"{name.removesuffix('_kpa')}_factor"
        factor = round(factor_at(patches, kind, s_m), 9)  # 1 at the end of a ramp, to the bit
        value = getattr(soil, name) * factor
        if not (math.isnan(value) or low <= value <= high):
            sizes = [abs(math.log(getattr(p, kind))) * _share(p, s_m) for p in patches]
            raise OutOfRange(
                f"field.patches[{sizes.index(max(sizes))}].{kind}", f"{factor:g} at {s_m:g} m",
                f"what {where}.{name} = {getattr(soil, name):g} allows: times the factor it is "
                f"{value:g}, and [{low:g}, {high:g}] would do",
            )  # fmt: skip
