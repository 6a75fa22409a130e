"""Early ends: after every decision of the driver, whether the drive goes on."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

from twin.machine.build import Machine
from twin.physics.shapes import Vector
from twin.simulation.driver import LOOKAHEAD_M
from twin.trajectory.end import LOOK_BACK_S, NOW_S, OVERSPEED, STALL_M, STUCK_SLIP, Outcome
from twin.truth.motion import slip_ratio_of

LEFT_M = LOOKAHEAD_M
"""So much further beside the line the driver has lost it [m]: the point of it that he steers for
lies no further ahead."""


@dataclass(frozen=True)
class Stance:
    """Where a tractor stands on its wheels, seen from the middle of its rear axle."""

    ahead_m: float
    """Centre of gravity before the rear axle, the implement left out."""
    height_m: float
    """Its height above the ground."""
    wheelbase_m: float
    half_track_m: float

    def falls(self, up_b: Vector) -> bool:
        """Whether the centre of gravity lies beyond the wheels, so that its weight turns it over.

        The plumb line from it meets the plane of the wheels at
            x = x_cg - h up_x / up_z      y = -h up_y / up_z
        outside 0 <= x <= wheelbase, |y| <= track / 2: the static overturning angle of a rigid body.

        Args:
            up_b: unit vector against gravity, in the body's axes.
        """
        x, y, z = up_b
        if z <= 0.0:
            return True
        foot_m = self.ahead_m - self.height_m * x / z
        aside_m = self.height_m * abs(y) / z
        return not (0.0 <= foot_m <= self.wheelbase_m) or aside_m > self.half_track_m


def stance(machine: Machine) -> Stance:
    """Where the centre of gravity of a machine lies over its wheels, on level ground."""
    model = machine.model
    ahead_m, _, above_axle_m = model.site("cg").pos
    return Stance(
        ahead_m=float(ahead_m),
        height_m=float(above_axle_m + model.body("tractor").pos[2]),
        wheelbase_m=float(model.body("front_axle").pos[0]),
        half_track_m=float(model.body("rl_wheel").pos[1]),
    )


class Progress(NamedTuple):
    """What is looked at after a decision of the driver."""

    along_m: float
    left_m: float
    follows: bool
    """Steered along a line: not on a headland, nor free of it."""
    up_b: Vector
    """Unit vector against gravity in the body's axes."""
    rim_mps: float
    """w R of the driven wheels, their mean."""
    hub_mps: float
    """Speed of their centres along their rolling direction, the mean."""
    engine_rpm: float


class EndMonitor:
    """Looks for an early end after every decision of the driver."""

    def __init__(self, machine: Machine, period_s: float) -> None:
        self.stance, self.period_s = stance(machine), period_s
        count = round(LOOK_BACK_S / period_s)
        self.past: deque[tuple[float, float, float]] = deque([(0.0, 0.0, 0.0)], count + 1)
        self.reached_m, self.standing_s, self.nearest_m = 0.0, 0.0, math.inf
        self.limit_rpm, self.racing_s = OVERSPEED * machine.numbers["engine.no_load_rpm"], 0.0

    def begin_leg(self) -> None:
        """On a new line or arc, distances are counted anew."""
        self.reached_m, self.standing_s, self.nearest_m = -math.inf, 0.0, math.inf

    def look(self, now: Progress) -> tuple[Outcome, float] | None:
        """The early end that has come now, and what was measured; None while it drives on."""
        _, rim_m, hub_m = self.past[-1]
        rim_m, hub_m = rim_m + now.rim_mps * self.period_s, hub_m + now.hub_mps * self.period_s
        self.past.append((now.along_m, rim_m, hub_m))
        self.standing_s += self.period_s
        if now.along_m >= self.reached_m + STALL_M:
            self.reached_m, self.standing_s = now.along_m, 0.0
        self.nearest_m = min(self.nearest_m, abs(now.left_m))
        racing = abs(now.engine_rpm) > self.limit_rpm
        self.racing_s = self.racing_s + self.period_s if racing else 0.0
        if self.stance.falls(now.up_b):
            return Outcome.ROLLED_OVER, math.degrees(math.acos(min(1.0, now.up_b[2])))
        if now.follows and abs(now.left_m) > self.nearest_m + LEFT_M:
            return Outcome.LEFT_LINE, abs(now.left_m)
        slip = self._slip(NOW_S)
        if slip > STUCK_SLIP and self._slip(LOOK_BACK_S) > STUCK_SLIP:
            return Outcome.STUCK, slip
        if slip < -STUCK_SLIP and self._slip(LOOK_BACK_S) < -STUCK_SLIP:
            return Outcome.SLID, slip
        if self.racing_s > NOW_S:
            return Outcome.RAN_AWAY, now.engine_rpm
        if self.standing_s > LOOK_BACK_S:
            return Outcome.STALLED, now.along_m - self.past[0][0]
        return None

    def _slip(self, time_s: float) -> float:
        """Slip of the driven axle's mean speeds over the last seconds; 0 before there are any."""
        count = round(time_s / self.period_s)
        if len(self.past) <= count:
            return 0.0
        (_, rim_m, hub_m), (_, rim_then_m, hub_then_m) = self.past[-1], self.past[-1 - count]
        rim_mps, hub_mps = (rim_m - rim_then_m) / time_s, (hub_m - hub_then_m) / time_s
        return slip_ratio_of(rim_mps, hub_mps)
