"""The habits of the driver."""

from __future__ import annotations

from dataclasses import dataclass

from twin.errors import check_range


@dataclass(frozen=True, kw_only=True)
class Driver:
    """What the driver does without being told."""

    reaction_s: float = 0.5
    """Time from what is noticed to what is done about it [s]."""
    shifts: bool = False
    """Shift down where the engine lugs, and back up to the gear that is asked for where it has
    torque to spare."""
    starts_standing: bool = False
    """Begin the run at a stand with the engine at idle, and set off; if not, it begins rolling."""
    headland_rpm: float | None = None
    """Engine speed that the governor is set to on the headlands [rpm]; None for that of work."""
    headland_kmh: float | None = None
    """Speed without slip on the headlands, by engine speed and, where that does not reach, by gear
    [km/h]; None for what the gear of work gives."""
    road_kmh: float | None = None
    """The same on the road to the field and back [km/h]."""

    def __post_init__(self) -> None:
        check_range("driver.reaction_s", self.reaction_s, 0.0, 3.0)
        if self.headland_rpm is not None:
            check_range("driver.headland_rpm", self.headland_rpm, 100.0, 9000.0)
        if self.headland_kmh is not None:
            check_range("driver.headland_kmh", self.headland_kmh, 0.5, 20.0)
        if self.road_kmh is not None:
            check_range("driver.road_kmh", self.road_kmh, 1.0, 60.0)

    @property
    def plain(self) -> bool:
        """Whether gear and throttle stay as they are, as long as no event changes them."""
        given = (self.headland_rpm, self.headland_kmh, self.road_kmh)
        return not (self.shifts or self.starts_standing) and given == (None, None, None)
