"""How the tractor is driven, and where."""

from __future__ import annotations

from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange, UnknownName, check_range

HEADLANDS = ("loop", "backing")
LEAST_APPROACH_M = 15.0
"""Shortest approach after a turn [m]."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """How the tractor is driven: one gear, one throttle setting, held through the run.

    The driver brakes where the ground drives the engine above that setting.
    """

    gear_ratio: float | None = None
    """Engine turns per turn of the rear axle [-]; None for the machine's usual gear."""
    engine_set_rpm: float | None = None
    """No-load speed the governor is set to [rpm]; None for the machine's usual one."""
    gear_kmh: float | None = None
    """In place of gear_ratio: the gear whose speed without slip is nearest at the set speed [km/h];
    just that speed where the machine has no fixed gears."""
    all_wheel_drive: bool = False
    """Engage the front axle."""
    differential_lock: bool = True
    """Turn both rear wheels together."""
    exhaust_brake: bool = False
    """Close the exhaust brake of a diesel while the wheels drive it; an option of the machine."""

    def __post_init__(self) -> None:
        if self.gear_ratio is not None:
            check_range("drive.gear_ratio", self.gear_ratio, 5.0, 1000.0)
        if self.engine_set_rpm is not None:
            check_range("drive.engine_set_rpm", self.engine_set_rpm, 100.0, 9000.0)
        if self.gear_kmh is not None:
            check_range("drive.gear_kmh", self.gear_kmh, 0.5, 60.0)
            if self.gear_ratio is not None:
                raise BadInput(
                    f"drive.gear_ratio = {self.gear_ratio:g} and drive.gear_kmh = "
                    f"{self.gear_kmh:g} contradict each other; one of them would do"
                )


@dataclass(frozen=True, kw_only=True)
class Course:
    """The planned way: a straight line, or several side by side with turns between.

    With a plough, an approach first with the plough raised.
    """

    approach_m: float = 15.0
    """Distance before the plough is lowered, or before `length_m` begins [m]."""
    length_m: float = 200.0
    """Distance after the approach [m]; with a plough, the ploughed length. `scores.json` has the
    part that is scored."""
    passes: int = 1
    """How often the field is crossed, up and down, with turns on the headlands between."""
    headland: str = "loop"
    """How the machine turns between passes: loop, always ahead, or backing, with ways backwards
    between parts of a half turn."""
    backings: int = 1
    """Number of ways backwards in a turn with backing."""
    road_m: float = 0.0
    """Length of the road to the field, before the approach, and back, after the last pass [m]; 0
    for a run that begins and ends in the field."""
    heading_deg: float = 0.0
    """Direction of the line, counter-clockwise from east [deg]."""
    start_left_m: float = 0.0
    """Distance of the rear axle's start from the line, to the left [m]."""
    hold_line: bool = True
    """Steer along the line; if not, the wheels point straight ahead and the heading is free."""
    edge_m: float | None = None
    """The run ends when a corner of the machine is so far beside the line [m]; None for a field."""
    calibration_m: float = 0.0
    """Length of a drive out and back on level ground before the run [m]; 0 for none. Estimators see
    it and can calibrate themselves on it; it is not scored."""

    def __post_init__(self) -> None:
        check_range("course.approach_m", self.approach_m, 0.0, 500.0)
        check_range("course.start_left_m", self.start_left_m, -50.0, 50.0)
        if self.edge_m is not None:
            check_range("course.edge_m", self.edge_m, 0.5, 100.0)
        check_range("course.length_m", self.length_m, 1.0, 5000.0)
        check_range("course.passes", self.passes, 1, 1000)
        if self.headland not in HEADLANDS:
            raise UnknownName("course.headland", self.headland, HEADLANDS)
        check_range("course.backings", self.backings, 1, 6)
        check_range("course.road_m", self.road_m, 0.0, 20000.0)
        if self.passes > 1 and self.approach_m < LEAST_APPROACH_M:
            raise OutOfRange(
                "course.approach_m", f"{self.approach_m:g}",
                f"[{LEAST_APPROACH_M:g}, 500] with course.passes = {self.passes}: after a turn the "
                "line has to be found",
            )  # fmt: skip
        if self.passes > 1 and (self.edge_m is not None or not self.hold_line):
            raise BadInput(
                f"course.passes = {self.passes} needs a driver who holds the line on a field "
                "without an edge"
            )
        if self.calibration_m:
            check_range("course.calibration_m", self.calibration_m, 5.0, 500.0)
        check_range("course.heading_deg", self.heading_deg, -180.0, 180.0)
