"""What happens in a drive: when, and what the driver then does.

An event has one time: `at_s`, `at_m` of a pass, a condition `when`, or none, which is after the
event before it.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass

from twin.errors import BadInput, OutOfRange, UnknownName, check_range

Number = float | int | None


@dataclass(frozen=True)
class Action:
    """What an event does, and the fields that say how."""

    about: str
    one_of: tuple[str, ...] = ()
    """Just one of them is given."""
    may: tuple[str, ...] = ()
    """May be given beside it."""


ACTIONS: Mapping[str, Action] = {
    "throttle": Action("set the governor to an engine speed", ("engine_rpm",)),
    "shift": Action("change gear: to one, to a speed, or by so many", ("gear", "kmh", "by")),
    "clutch": Action("hold the clutch pedal so far down", ("pedal",), ("for_s",)),
    "brake": Action("press the brake pedal so far", ("pedal",), ("for_s",)),
    "stop": Action("stop and stand, then set off again", ("for_s",), ("engine_off",)),
    "reverse": Action("stop, back up, stop, and go on ahead", ("distance_m",)),
    "lift": Action("raise the implement"),
    "lower": Action("lower the implement"),
    "depth": Action("set another working depth", ("depth_m",)),
    "front_drive": Action("engage or release the front axle", ("engaged",)),
    "lock": Action("engage or release the differential lock", ("engaged",)),
    "mass": Action("fill a tank, or empty it where below 0", ("mass_kg",), ("tank", "rate_kgps")),
}
"""What an event can do."""
TIMES = ("at_s", "at_m", "when")
QUANTITIES = {
    "engine_rpm": "engine speed",
    "slip": "slip of the driven axle",
    "depth_m": "depth of the implement",
    "speed_kmh": "speed over the ground",
    "draft_kn": "draft of the implement",
    "load": "torque of the engine over its full-load torque",
}
"""What a condition can look at."""
TANKS = ("fuel", "seed", "water")
"""What a mass is."""
RANGES = {
    "at_s": (0.0, 1e5), "at_m": (0.0, 1e4), "engine_rpm": (100.0, 9000.0), "kmh": (0.2, 60.0),
    "pedal": (0.0, 1.0), "for_s": (0.0, 36000.0), "distance_m": (0.5, 100.0),
    "depth_m": (0.01, 0.8), "mass_kg": (-5000.0, 5000.0), "rate_kgps": (0.1, 100.0),
}  # fmt: skip
WHOLE = {"gear": (1, 60), "by": (-20, 20), "in_pass": (1, 100), "times": (1, 1000)}
FLAGS = ("engaged", "engine_off")
CONDITION = re.compile(r"\s*(\w+)\s*([<>])\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*")


@dataclass(frozen=True)
class Condition:
    """A quantity below or above a limit."""

    quantity: str
    above: bool
    limit: float

    def holds(self, value: float) -> bool:
        """Whether a value of the quantity is on that side of the limit."""
        return value > self.limit if self.above else value < self.limit


@dataclass(frozen=True, kw_only=True)
class Event:
    """Something that the driver does at a time, at a place, or on a condition."""

    do: str
    """throttle, shift, clutch, brake, stop, reverse, lift, lower, depth, front_drive, lock or
    mass."""
    at_s: float | None = None
    """Time since the start of the run [s]."""
    at_m: float | None = None
    """Distance along the line of a pass, from where that pass begins [m]."""
    in_pass: int | None = None
    """Number of the pass of `at_m`; None for the first."""
    when: str | None = None
    """Condition, such as `engine_rpm < 1300`, `slip > 0.3` or `depth_m > 0.2`: engine_rpm, slip,
    depth_m, speed_kmh, draft_kn or load."""
    times: int | None = None
    """How often the condition may act; before it acts again it must have ceased. None for once."""
    engine_rpm: float | None = None
    """No-load engine speed that the governor is set to [rpm]."""
    gear: int | None = None
    """Gear, from 1 for the slowest."""
    kmh: float | None = None
    """Speed without slip at the set engine speed, whose nearest ratio is driven [km/h]."""
    by: int | None = None
    """Number of gears up; below 0, down."""
    pedal: float | None = None
    """0 released, 1 pressed down."""
    for_s: float | None = None
    """Duration [s]; None for a pedal holds it until the next event with that pedal."""
    engine_off: bool = False
    """Turn the engine off while the machine stands."""
    distance_m: float | None = None
    """Distance that the machine backs up [m]."""
    depth_m: float | None = None
    """Working depth [m]."""
    engaged: bool | None = None
    """true engages, false releases."""
    tank: str | None = None
    """fuel, seed or water; None for fuel. Seed and water are carried in front."""
    mass_kg: float | None = None
    """Mass that is filled in; below 0, that is taken out [kg]."""
    rate_kgps: float | None = None
    """Mass that is filled in or taken out per second [kg/s]; None for 5."""

    def __post_init__(self) -> None:
        if self.do not in ACTIONS:
            raise UnknownName("event", str(self.do), ACTIONS)
        self._check_numbers()
        self._check_fields(ACTIONS[self.do])
        given = [name for name in TIMES if getattr(self, name) is not None]
        if len(given) > 1:
            raise BadInput(
                f"{self.do}: {given[0]} and {given[1]} are two times of one event; one would do"
            )
        if self.in_pass is not None and self.at_m is None:
            raise BadInput(f"{self.do}: in_pass = {self.in_pass} needs at_m")
        if self.times is not None and self.when is None:
            raise BadInput(f"{self.do}: times = {self.times} needs a condition, when = ...")
        if self.tank is not None and self.tank not in TANKS:
            raise UnknownName("tank", self.tank, TANKS)
        if self.when is not None:
            _ = self.condition

    def _check_numbers(self) -> None:
        for name, (low, high) in RANGES.items():
            if (value := getattr(self, name)) is not None:
                if isinstance(value, bool) or not isinstance(value, (int, float)):
                    raise BadInput(f"{self.do}: {name} = {value!r} is no number")
                check_range(f"{self.do}: {name}", value, low, high)
        for name, (low, high) in WHOLE.items():
            if (value := getattr(self, name)) is not None:
                if isinstance(value, bool) or not isinstance(value, int):
                    raise BadInput(f"{self.do}: {name} = {value!r} is no whole number")
                check_range(f"{self.do}: {name}", value, low, high)
        for name in FLAGS:
            if not isinstance(value := getattr(self, name), (bool, type(None))):
                raise BadInput(f"{self.do}: {name} = {value!r}; true or false would do")

    def _check_fields(self, action: Action) -> None:
        """Just one of what the action needs, and nothing that it does not read."""
        own = {f.name for f in dataclasses.fields(self)} - {"do", "in_pass", "times", *TIMES}
        given = sorted(
            n for n in own if getattr(self, n) is not None and getattr(self, n) is not False
        )
        if self.do in ("front_drive", "lock") and self.engaged is False:
            given.append("engaged")
        known = (*action.one_of, *action.may)
        for name in given:
            if name not in known:
                would = f"; {' and '.join(known)} would do" if known else ""
                raise BadInput(f"{self.do} does not read {name}{would}")
        needed = [name for name in action.one_of if name in given]
        if action.one_of and len(needed) != 1:
            names = ", ".join(action.one_of)
            wanted = f"one of {names}" if len(action.one_of) > 1 else names
            raise BadInput(
                f"{self.do} needs {wanted}; "
                + (f"{needed[0]} and {needed[1]} are given" if needed else "it is not given")
            )

    @property
    def condition(self) -> Condition:
        """The condition of `when`. Raises BadInput, or UnknownName for its quantity."""
        found = CONDITION.fullmatch(str(self.when))
        if found is None:
            raise BadInput(
                f"{self.do}: when = '{self.when}' is no condition; 'engine_rpm < 1300' would do"
            )
        quantity, way, limit = found.groups()
        if quantity not in QUANTITIES:
            raise UnknownName("quantity of a condition", quantity, QUANTITIES)
        try:
            return Condition(quantity, way == ">", float(limit))
        except ValueError:
            raise BadInput(f"{self.do}: when = '{self.when}': {limit} is no number") from None

    @property
    def time(self) -> str:
        """When it happens, in words."""
        if self.at_s is not None:
            return f"at {self.at_s:g} s"
        if self.at_m is not None:
            return f"at {self.at_m:g} m of pass {self.in_pass or 1}"
        return f"when {self.when}" if self.when is not None else "after the event before it"


def most_filled_kg(events: tuple[Event, ...]) -> float:
    """The most that all tanks together take in above what they hold at the start [kg]."""
    return max(itertools.accumulate((event.mass_kg or 0.0 for event in events), initial=0.0))


def check_order(events: tuple[Event, ...]) -> None:
    """Refuse orders that no driver can follow.

    Raises:
        BadInput, OutOfRange: a time or a place before that of an earlier event, or more taken out
            of a tank than was filled in.
    """
    last_s, last_m = -1.0, (0, -1.0)
    filled = dict.fromkeys(TANKS, 0.0)
    for i, event in enumerate(events):
        if event.at_s is not None:
            if event.at_s < last_s:
                raise BadInput(
                    f"events.{i}: {event.do} {event.time} stands after one at {last_s:g} s; events "
                    "by rising time would do"
                )
            last_s = event.at_s
        if event.at_m is not None:
            place = (event.in_pass or 1, event.at_m)
            if place < last_m:
                raise BadInput(
                    f"events.{i}: {event.do} {event.time} stands after one at {last_m[1]:g} m of "
                    f"pass {last_m[0]}; events in the order of the way would do"
                )
            last_m = place
        if event.do == "mass" and event.mass_kg is not None:
            tank = event.tank or TANKS[0]
            filled[tank] += event.mass_kg
            if tank != "fuel" and filled[tank] < 0.0:
                raise OutOfRange(
                    f"events.{i}: mass_kg", f"{event.mass_kg:g}",
                    f"what is in the tank of {tank}: {filled[tank] - event.mass_kg:g} kg",
                )  # fmt: skip
