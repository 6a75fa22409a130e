"""An implement as its file describes it; a field that is None is derived by the rules of its kind.

Implement axes: x forward, y left, z up, from the middle of its lower hitch points. Each class is a
table of the implement's TOML file. The rules are in `twin.vehicle.implement_derive`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated

from twin.errors import BadInput, OutOfRange, UnknownName
from twin.sensors.checks import Range
from twin.vehicle.kinds import KINDS
from twin.vehicle.machine import SCHEMA, Point, check_given
from twin.vehicle.source import Source, check_grade

HITCHES = ("three-point", "drawbar")
MOST_TOOLS = 16
"""Bodies or tools, at most: what the parameter block has room for."""
NONE = "none"
"""Name for a machine without implement."""


@dataclass(frozen=True, kw_only=True)
class GaugeWheel:
    """The wheel that runs on the unworked ground and limits the depth."""

    fitted: bool = True
    radius_m: Annotated[float | None, Range(0.1, 0.8)] = None
    x_m: Annotated[float | None, Range(-8, 0)] = None
    stiffness_npm: Annotated[float | None, Range(1e3, 1e6)] = None
    damping_nspm: Annotated[float | None, Range(10, 1e5)] = None
    resistance_ratio: Annotated[float | None, Range(0, 0.5)] = None
    """Rolling resistance over load."""


@dataclass(frozen=True, kw_only=True)
class Draft:
    """Draft by ASABE D497, with the kind's coefficients or your own, or by a law of your own."""

    law: str = "d497"
    """d497, or your own as module:function."""
    a: Annotated[float | None, Range(0, 5000)] = None
    """A of D497 [N per cm of depth, and per m of width or per tool]."""
    b: Annotated[float | None, Range(-100, 500)] = None
    """B of D497, per km/h."""
    c: Annotated[float | None, Range(-10, 100)] = None
    """C of D497, per (km/h)**2."""
    factor_medium: Annotated[float | None, Range(0.05, 1.5)] = None
    """Soil factor F of D497 on medium soil; on fine soil it is 1."""
    factor_coarse: Annotated[float | None, Range(0.05, 1.5)] = None
    """Soil factor F of D497 on coarse soil."""
    vertical_ratio: Annotated[float | None, Range(-0.5, 1)] = None
    """Downward force over draft."""
    side_ratio: Annotated[float | None, Range(0, 0.6)] = None
    """Side force towards the land over draft."""
    force_depth_ratio: Annotated[float | None, Range(0.1, 1)] = None
    """Depth at which the force acts over the working depth."""


@dataclass(frozen=True, kw_only=True)
class Implement:
    """An implement on the linkage: bodies or tools, mass, hitch, and its draft."""

    schema: int = SCHEMA
    name: str = "implement"
    about: str = ""
    """One line of description."""
    grade: str = "given"
    """Grade of all numbers of the file for which `sources` has no entry."""
    source: str = ""
    mjcf: str | None = None
    """A hand-made MJCF with the documented numerics, beside the file."""
    kind: str = "mouldboard"
    """mouldboard, chisel, subsoiler, sweep, cultivator or none."""
    width_m: Annotated[float | None, Range(0.1, 12)] = None
    """Working width."""
    bodies: int | None = None
    """Number of bodies or tools."""
    rows: int | None = None
    """Bars on which the tools stand, one behind the other."""
    mass_kg: Annotated[float | None, Range(5, 10000)] = None
    hitch: str = "three-point"
    """three-point, or drawbar: pulled at one point, the implement carries its own weight."""
    depth_m: Point | None = None
    """Least and greatest working depth."""
    length_m: Annotated[float | None, Range(0.3, 10)] = None
    """Length from the hitch points to the last body."""
    clearance_m: Annotated[float | None, Range(0.2, 1.5)] = None
    """Height of the hitch points above the soles."""
    mast_m: Annotated[float | None, Range(0.2, 1.2)] = None
    """Height of the top link's pin above the lower hitch points."""
    gauge_wheel: GaugeWheel = dataclasses.field(default_factory=GaugeWheel)
    draft: Draft = dataclasses.field(default_factory=Draft)
    sources: tuple[Source, ...] = ()
    """As `Machine.sources`."""
    folder: str = ""

    def __post_init__(self) -> None:
        if self.schema != SCHEMA:
            raise OutOfRange("schema", self.schema, f"what is known: {SCHEMA}")
        check_grade("grade", self.grade)
        if self.kind not in (*KINDS, NONE):
            raise UnknownName("kind", self.kind, (*KINDS, NONE))
        if self.hitch not in HITCHES:
            raise UnknownName("hitch", self.hitch, HITCHES)
        check_given("", self)
        check_given("gauge_wheel", self.gauge_wheel)
        check_given("draft", self.draft)
        if self.draft.law != "d497" and ":" not in self.draft.law:
            raise UnknownName("implement law", self.draft.law, ("d497", "module:function"))
        if self.kind != NONE:
            self._check()

    @property
    def depths_m(self) -> Point:
        """Least and greatest working depth."""
        return self.depth_m or KINDS[self.kind].depth_m

    @property
    def furrow(self) -> bool:
        """Whether the wheels of one side run in the last furrow behind it."""
        return KINDS[self.kind].furrow

    def _check(self) -> None:
        kind = KINDS[self.kind]
        if self.bodies is not None and not 1 <= self.bodies <= kind.most:
            raise OutOfRange(
                "bodies", self.bodies, f"the whole numbers 1 to {kind.most} of kind {self.kind}"
            )
        if self.rows is not None and not 1 <= self.rows <= 6:
            raise OutOfRange("rows", self.rows, "[1, 6]")
        if self.depth_m is not None and not 0.01 <= self.depth_m[0] < self.depth_m[1] <= 0.8:
            raise OutOfRange(
                "depth_m", f"{self.depth_m[0]:g}, {self.depth_m[1]:g}",
                "two rising depths in [0.01, 0.8]",
            )  # fmt: skip
        if self.mjcf is not None:
            return
        for name in ("width_m", "bodies", "mass_kg"):
            if getattr(self, name) is None:
                raise BadInput(f"{name} is missing; the data sheet's would do")
        width_m, bodies = self.width_m or 0.0, self.bodies or 1
        one_m = width_m / bodies
        if not kind.narrowest_m <= one_m <= kind.widest_m:
            raise OutOfRange(
                "width_m", f"{self.width_m:g}",
                f"[{kind.narrowest_m * bodies:.3g}, {kind.widest_m * bodies:.3g}], what "
                f"bodies = {self.bodies} of kind {self.kind} work",
            )  # fmt: skip
