"""How a drive ends: as it was meant to, or early, where the tractor can no longer do its work."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

LOOK_BACK_S, NOW_S = 5.0, 1.0
"""Time over which a stall and a spin are judged, and what of it counts as now [s]; assumed."""
STALL_M = 0.25
"""A drive that gains less in that time has stalled [m]: the slowest that counts is 0.05 m/s."""
STUCK_SLIP = 0.6
"""Slip above which wheels only spin, over all of that time and still now: Brixius'
1 - exp(-7.5 s) is 0.989 there, so more slip brings no more pull, and the ground gives way. Below
minus this they only skid."""
OVERSPEED = 1.15
"""Engine speed over the no-load speed at full throttle that no engine should see [-]; governors
hold within about a tenth. Over `NOW_S` without a break it ends the drive."""


class Outcome(StrEnum):
    """How a drive can end."""

    DRIVEN = "course driven"
    EDGE = "course driven to the edge"
    SHALLOW = "never at its depth"
    STALLED = "stalled"
    STUCK = "stuck"
    SLID = "slid away"
    RAN_AWAY = "ran away"
    LEFT_LINE = "left the line"
    ROLLED_OVER = "rolled over"


_MEASURED: dict[Outcome, tuple[str, str]] = {
    Outcome.DRIVEN: ("m", ""),
    Outcome.EDGE: ("m", ""),
    Outcome.SHALLOW: ("m", "the plough came to {cm:.1f} cm"),
    Outcome.STALLED: ("m", "{measured:.2f} m gained in {back_s:g} s"),
    Outcome.STUCK: (
        "1",
        "the wheels spin, slip {measured:.0%}, above {stuck:.0%} over {back_s:g} s",
    ),
    Outcome.SLID: (
        "1",
        "the wheels skid, slip {measured:.0%}, below -{stuck:.0%} over {back_s:g} s",
    ),
    Outcome.RAN_AWAY: (
        "rpm",
        "the ground drives the engine at {measured:.0f} rpm, over {now_s:g} s above {over:g} of "
        "its no-load speed, and its brakes do not hold it",
    ),
    Outcome.LEFT_LINE: ("m", "{measured:.1f} m beside it"),
    Outcome.ROLLED_OVER: ("deg", "{measured:.0f} degrees from the vertical"),
}
"""Unit of what was measured, and its words."""


@dataclass(frozen=True, kw_only=True)
class End:
    """How, when and where a drive ended."""

    outcome: Outcome
    time_s: float
    """Time of the end, on the clock of the epochs [s]."""
    along_m: float
    """Distance along `way` [m]."""
    left_m: float
    """Distance from the line of `way`, positive to the left [m]."""
    way: str = "the course"
    """Part that was being driven: the course, one of its passes, or the turn before one."""
    measured: float
    """Value that decided the end, in `unit`: metres driven along, the depth reached, metres
    gained, the slip, the engine's speed, metres beside the line, degrees from the vertical."""

    @property
    def as_planned(self) -> bool:
        """True if the drive reached the end of the course, or the edge that ends the course."""
        return self.outcome in (Outcome.DRIVEN, Outcome.EDGE)

    @property
    def early(self) -> bool:
        """True if the drive ended before the end of the course."""
        return not (self.as_planned or self.outcome is Outcome.SHALLOW)

    @property
    def unit(self) -> str:
        """Unit of `measured`."""
        return _MEASURED[self.outcome][0]

    def __str__(self) -> str:
        """`rolled over at 12.3 s, 14.2 m along the course: 47 degrees from the vertical`."""
        if self.as_planned:
            return str(self.outcome)
        words = _MEASURED[self.outcome][1].format(
            measured=self.measured,
            cm=100.0 * self.measured,
            back_s=LOOK_BACK_S,
            stuck=STUCK_SLIP,
            now_s=NOW_S,
            over=OVERSPEED,
        )
        when = f" at {self.time_s:.1f} s, {self.along_m:.1f} m along {self.way}"
        return f"{self.outcome}{when if self.early else ''}: {words}"

    def plain(self) -> dict[str, bool | float | str]:
        """End as plain JSON values, for scores.json."""
        return {
            "outcome": str(self.outcome), "as_planned": self.as_planned, "time_s": self.time_s,
            "along_m": self.along_m, "left_m": self.left_m, "way": self.way,
            "measured": self.measured, "unit": self.unit,
        }  # fmt: skip
