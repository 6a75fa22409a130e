"""How the plough, or another implement, is set."""

from __future__ import annotations

from dataclasses import dataclass

from twin.errors import OutOfRange, UnknownName, check_range

FURROW_SIDES = {"right": -1, "none": 0, "left": 1}
HITCH_MODES = ("depth", "position", "draft", "mix", "float")
DRAFT_MODES = ("draft", "mix")
"""Modes of the hitch in which the depth follows the draft."""
FRONT_BALLAST_KG = 500.0
"""Front weights of a tractor that carries the whole plough [kg]; assumed, a usual set is 400 to 600
for this class."""
TOP_LINK_DROP_M = 0.15
"""How far below the upper hole the top link is pinned to float [m]; assumed, brackets have three to
five holes over some 0.2 m."""


@dataclass(frozen=True, kw_only=True)
class Plough:
    """How the implement is set. `Scenario.implement` says which one it is."""

    depth_m: float = 0.25
    """Working depth [m], within what the implement works at."""
    wheel_share: float = 0.48
    """Share of the plough's weight and downward soil force the depth wheel is set to carry in
    the hitch modes depth, position and mix [-]. In float it carries what the links do not. In
    draft, and in mix with `draft_mix` = 1, it is up and touches the ground only at `deepest_m`."""
    furrow: str = "right"
    """Side whose wheels run in the last furrow: right, left, or none. A reversible plough turns
    over at the headland, so the side alternates from pass to pass. None behind what turns no
    furrow, as a cultivator."""
    hitch: str = "depth"
    """How the hitch is controlled: depth (the operator trims it), position (the lever's angle is
    held), draft, mix (of position and draft) or float (the lift carries nothing)."""
    expected_draft_scale: float | None = None
    """F of ASABE D497 on the soil that the operator sets lever, draft and depth wheel for [-]; None
    for the soil's own."""
    draft_mix: float = 0.5
    """Share of the draft in `mix`: 0 follows the lever's position, 1 the draft [-]."""
    sensitivity_rad: float = 0.03
    """Gain of draft control: twice the expected draft acts as this error of the angle [rad]."""
    drop_rate_radps: float = 0.35
    """Fastest lowering of the lower links [rad/s]; 0.35 is 0.33 m/s at the hitch points."""
    upper_limit_rad: float = 0.6
    """Angle of the lower links to which the lift raises the plough, and no further [rad]."""
    deepest_m: float | None = None
    """Depth at which draft and mix lower no further [m]; None for the implement's greatest."""
    front_ballast_kg: float | None = None
    """Weights on the tractor's front [kg]. None: 500 where the depth wheel is up, as the tractor
    then carries the whole plough and would rear up, and 0 otherwise."""
    top_link_drop_m: float | None = None
    """How far below its upper hole the top link is pinned to the tractor [m]; None: 0.15 in
    float, where a steeper link puts more of the plough on the rear wheels, and 0 otherwise."""

    def __post_init__(self) -> None:
        if self.furrow not in FURROW_SIDES:
            raise UnknownName("furrow side", self.furrow, FURROW_SIDES)
        if self.hitch not in HITCH_MODES:
            raise UnknownName("hitch mode", self.hitch, HITCH_MODES)
        check_range("plough.depth_m", self.depth_m, 0.01, 0.8)
        check_range("plough.wheel_share", self.wheel_share, 0.0, 1.0)
        if self.expected_draft_scale is not None:
            check_range("plough.expected_draft_scale", self.expected_draft_scale, 0.0, 2.0)
        check_range("plough.draft_mix", self.draft_mix, 0.0, 1.0)
        check_range("plough.sensitivity_rad", self.sensitivity_rad, 0.01, 0.1)
        check_range("plough.drop_rate_radps", self.drop_rate_radps, 0.05, 1.0)
        check_range("plough.upper_limit_rad", self.upper_limit_rad, 0.4, 0.9)
        if self.deepest_m is not None:
            check_range("plough.deepest_m", self.deepest_m, 0.01, 0.9)
            if self.hitch in DRAFT_MODES and self.deepest_m < self.depth_m:
                raise OutOfRange(
                    "plough.deepest_m", f"{self.deepest_m:g}",
                    f"[{self.depth_m:g}, 0.9]: no shallower than plough.depth_m",
                )  # fmt: skip
        if self.front_ballast_kg is not None:
            check_range("plough.front_ballast_kg", self.front_ballast_kg, 0.0, 1000.0)
        if self.top_link_drop_m is not None:
            check_range("plough.top_link_drop_m", self.top_link_drop_m, 0.0, 0.25)

    @property
    def ballast_kg(self) -> float:
        """Weights on the tractor's front in this mode."""
        if self.front_ballast_kg is not None:
            return self.front_ballast_kg
        return FRONT_BALLAST_KG if self.wheel_up else 0.0

    @property
    def mix(self) -> float:
        """What the lift follows: 0 the lever's position, or neither; 1 the draft."""
        return {"draft": 1.0, "mix": self.draft_mix}.get(self.hitch, 0.0)

    @property
    def wheel_up(self) -> bool:
        """Whether the depth wheel is up: where nothing but the draft is held."""
        return self.mix == 1.0

    @property
    def drop_m(self) -> float:
        """How far below its upper hole the top link is pinned in this mode."""
        if self.top_link_drop_m is not None:
            return self.top_link_drop_m
        return TOP_LINK_DROP_M if self.hitch == "float" else 0.0
