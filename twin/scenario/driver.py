"""The habits of the driver."""

from __future__ import annotations

from dataclasses import dataclass

from twin.errors import check_range


@dataclass(frozen=True, kw_only=True)
class Driver:
    """Habits of the driver: what he does without an event."""

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
    """Speed without slip on the headlands [km/h]: by gear at headland_rpm, or else by engine speed,
    and by gear where that does not reach. None for what the gear of work gives."""
    headland_rpm_sd: float = 0.0
    """Standard deviation of `headland_rpm`, as the driver's foot moves [rpm]."""
    pause_s: float = 0.0
    """How long the machine stands where it changes its direction [s]."""
    road_kmh: float | None = None
    """Speed without slip on the road to the field and back [km/h]; None for that of work."""
    road_rpm: float | None = None
    """Engine speed that the governor is set to on the road [rpm]; None for that of work."""

    def __post_init__(self) -> None:
        check_range("driver.reaction_s", self.reaction_s, 0.0, 3.0)
        check_range("driver.pause_s", self.pause_s, 0.0, 30.0)
        check_range("driver.headland_rpm_sd", self.headland_rpm_sd, 0.0, 1000.0)
        if self.headland_rpm is not None:
            check_range("driver.headland_rpm", self.headland_rpm, 100.0, 9000.0)
        if self.road_rpm is not None:
            check_range("driver.road_rpm", self.road_rpm, 100.0, 9000.0)
        if self.headland_kmh is not None:
            check_range("driver.headland_kmh", self.headland_kmh, 0.5, 20.0)
        if self.road_kmh is not None:
            check_range("driver.road_kmh", self.road_kmh, 1.0, 60.0)

    @property
    def plain(self) -> bool:
        """Whether only events change gear and throttle."""
        given = (self.headland_rpm, self.headland_kmh, self.road_kmh, self.road_rpm)
        return not (self.shifts or self.starts_standing) and given == (None,) * 4
