"""What the driver has set himself to do: events as their time comes, habits in between."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from twin.scenario import Event, Scenario
from twin.simulation.cab import HALT_MPS2, STILL_MPS, Gears, Orders

DEAD_S = 20.0
"""Longest time that an event which waits for a stand, or for a way backed up, may take [s]; then it
is given up: the machine cannot do it."""
BACK_KMH = 5.0
"""Speed at which a driver backs up if `headland_kmh` gives none [km/h]; assumed."""
DECISION_S = 0.02
"""Time between two decisions."""
FOOT, FOOT_TAU_S = 25, 3.0
"""Number of the foot's random stream of a seed, and the time constant of its motion [s];
assumed."""
FOOT_S = 0.3
"""Time that a driver allows for his foot to reach the brake [s]; assumed."""
SLOWEST = 1.15
"""Slowest set speed over idle that a driver slows down to before he shifts down [-]; assumed."""


@dataclass(frozen=True, kw_only=True)
class Now:
    """What events look at."""

    time_s: float
    along_m: float
    count: int
    """Which pass."""
    turning: bool
    backing: bool
    """Whether the way leads backwards here."""
    on_road: bool
    speed_mps: float
    way_m: float
    """Driven so far, less where backwards."""
    quantities: Mapping[str, float]
    """By the names of `twin.scenario.events.QUANTITIES`."""


@dataclass
class Waiting:
    """An event on a condition with those that follow it, and what is known of it."""

    chain: list[Event]
    left: int
    held_s: float = 0.0
    armed: bool = True


def _chains(events: tuple[Event, ...]) -> Iterator[list[Event]]:
    """Each event that has a time, with those without one that follow it."""
    chain: list[Event] = []
    for event in events:
        if chain and (event.at_s, event.at_m, event.when) != (None, None, None):
            yield chain
            chain = []
        chain.append(event)
    if chain:
        yield chain


@dataclass
class Agenda:
    """Events that are still to come, and what those that came have changed."""

    scenario: Scenario
    gears: Gears
    ratio: float
    throttle: float
    raised: bool = False
    """Whether an event keeps the implement up."""
    depth_m: float | None = None
    """Depth that an event has set."""
    lowered: bool = False
    """Whether an event has lowered the implement before its place."""
    front_drive: bool | None = None
    lock: bool | None = None
    filling_kg: dict[str, float] = field(default_factory=dict)
    """What is still to be filled into each tank, below 0 taken out."""
    rate_kgps: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.box = self.scenario.gearbox
        self.rng, self.foot_rpm = np.random.default_rng([self.scenario.seed, FOOT]), 0.0
        chains = list(_chains(self.scenario.events))
        self.coming = [chain for chain in chains if chain[0].when is None]
        self.waiting = [Waiting(c, c[0].times or 1) for c in chains if c[0].when is not None]
        self.clutch, self.brake = (0.0, math.inf), (0.0, math.inf)
        self.stop: Event | None = None
        self.left_s, self.since_s = 0.0, 0.0
        self.back: Event | None = None
        self.from_m = 0.0

    @property
    def standing(self) -> bool:
        """Whether an event makes the machine stand."""
        return self.stop is not None

    def orders(self, now: Now, dt_s: float) -> Orders:
        """What is wanted for the next interval."""
        self._begin(now, dt_s)
        self._go_on(now, dt_s)
        ratio, throttle = self._pace(now)
        pedals = [p if now.time_s < until else 0.0 for p, until in (self.clutch, self.brake)]
        way = -1 if (self.back is not None) != now.backing else 1
        return Orders(
            ratio=ratio, throttle=throttle, way=way, stands=self.standing,
            off=self.stop is not None and self.stop.engine_off,
            clutch_pedal=pedals[0], brake_pedal=pedals[1],
        )  # fmt: skip

    def _begin(self, now: Now, dt_s: float) -> None:
        """Begin what is due; events without a time wait for the one before them to end."""
        for chain in self.coming:
            while chain and self._due(chain[0], now):
                self._do(chain.pop(0), now)
        self.coming = [chain for chain in self.coming if chain]
        for waiting in self.waiting:
            condition = waiting.chain[0].condition
            holds = condition.holds(now.quantities[condition.quantity])
            waiting.held_s = waiting.held_s + dt_s if holds else 0.0
            waiting.armed |= not holds
            due = waiting.armed and waiting.held_s > self.gears.reaction_s
            if due and waiting.left > 0 and not self._busy:
                waiting.armed, waiting.left = False, waiting.left - 1
                self._do(waiting.chain[0], now)
                self.coming.append(waiting.chain[1:])

    @property
    def _busy(self) -> bool:
        return self.stop is not None or self.back is not None

    def _due(self, event: Event, now: Now) -> bool:
        if self._busy and event.do in ("stop", "reverse"):
            return False
        if event.at_s is not None:
            return now.time_s >= event.at_s
        if event.at_m is not None:
            place = event.in_pass or 1
            return now.count > place or (
                now.count == place and not now.turning and now.along_m >= event.at_m
            )
        return not (self._busy or any(self.filling_kg.values()))

    def _do(self, event: Event, now: Now) -> None:
        until_s = math.inf if event.for_s is None else now.time_s + event.for_s
        match event.do:
            case "throttle":
                self.throttle = self.gears.throttle(event.engine_rpm or self.gears.idle_rpm)
            case "shift":
                self.ratio = self._ratio_of(event)
            case "clutch":
                self.clutch = (event.pedal or 0.0, until_s)
            case "brake":
                self.brake = (event.pedal or 0.0, until_s)
            case "stop":
                self.stop, self.left_s, self.since_s = event, event.for_s or 0.0, now.time_s
            case "reverse":
                self.back, self.from_m, self.since_s = event, now.way_m, now.time_s
            case "lift":
                self.raised, self.lowered = True, False
            case "lower":
                self.raised, self.lowered = False, True
            case "depth":
                self.depth_m = event.depth_m
            case "front_drive":
                self.front_drive = event.engaged
            case "lock":
                self.lock = event.engaged
            case "mass":
                tank = event.tank or "fuel"
                self.filling_kg[tank] = self.filling_kg.get(tank, 0.0) + (event.mass_kg or 0.0)
                self.rate_kgps[tank] = event.rate_kgps or 5.0

    def _ratio_of(self, event: Event) -> float:
        box = self.box
        if event.gear is not None:
            return box.of_gear(event.gear, self.scenario.machine)
        if event.kmh is not None:
            return box.of_speed(event.kmh, self.gears.set_rpm(self.throttle), self.gears.rim_m)
        at = box.ratios.index(self.ratio) + (event.by or 0)
        return box.ratios[min(max(at, 0), len(box.ratios) - 1)]

    def _go_on(self, now: Now, dt_s: float) -> None:
        """A stand that is over, a way that has been backed up."""
        if self.stop is not None:
            self.left_s -= dt_s if abs(now.speed_mps) < STILL_MPS else 0.0
            given_up = now.time_s - self.since_s > (self.stop.for_s or 0.0) + DEAD_S
            if self.left_s <= 0.0 or given_up:
                self.stop = None
        if self.back is not None:
            self.from_m = max(self.from_m, now.way_m)  # it goes on ahead while it is stopped
            back_mps = max(0.0, -now.speed_mps)
            soon_m = (0.5 * back_mps / HALT_MPS2 + FOOT_S) * back_mps
            backed_m = self.from_m - now.way_m + soon_m
            waited_s = now.time_s - self.since_s
            slow = waited_s > DEAD_S + 10.0 * (self.back.distance_m or 0.0)
            if backed_m >= (self.back.distance_m or 0.0) or slow:
                self.back = None

    def _pace(self, now: Now) -> tuple[float, float]:
        """Ratio and throttle: those of work, or of the headland or the road."""
        driver = self.scenario.driver
        kmh = driver.road_kmh if now.on_road else None
        rpm = driver.road_rpm if now.on_road else None
        if now.turning or self.back is not None:
            kmh = driver.headland_kmh
            if self.back is not None and kmh is None and driver.headland_rpm is None:
                kmh = BACK_KMH
            rpm = driver.headland_rpm
            if rpm is not None and driver.headland_rpm_sd > 0.0:
                rpm = max(rpm + self._foot_rpm(), self.gears.idle_rpm)
        throttle = self.throttle if rpm is None else self.gears.throttle(rpm)
        if kmh is None:
            return self.ratio, throttle
        if rpm is not None:
            return self.box.of_speed(kmh, rpm, self.gears.rim_m), throttle
        return self._paced(kmh, throttle)

    def _foot_rpm(self) -> float:
        """What the foot adds to the engine speed: a Gauss-Markov process.

        x' = a x + sigma sqrt(1 - a**2) N(0, 1)        a = exp(-dt / 3 s)
        """
        kept = math.exp(-DECISION_S / FOOT_TAU_S)
        noise = self.scenario.driver.headland_rpm_sd * math.sqrt(1.0 - kept * kept)
        self.foot_rpm = kept * self.foot_rpm + noise * float(self.rng.standard_normal())
        return self.foot_rpm

    def _paced(self, kmh: float, throttle: float) -> tuple[float, float]:
        """Ratio and throttle for a speed without slip: by the engine, else by the gear."""
        gears = self.gears
        per_rpm = math.pi / 30.0 * gears.rim_m * 3.6 / self.ratio
        least, most = SLOWEST * gears.idle_rpm, gears.set_rpm(throttle)
        if least * per_rpm <= kmh <= most * per_rpm:
            return self.ratio, gears.throttle(kmh / per_rpm)
        set_rpm = most if kmh > most * per_rpm else least
        return self.box.of_speed(kmh, set_rpm, gears.rim_m), gears.throttle(set_rpm)
