"""The baselines of WheelSlip-v0: a torque for each rear wheel from its own slip.

torque = feed + law(target - slip), in [-1, 1] of the motor's
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.control.controllers import Array, Controller, Gain, Seen


def wheel_errors(seen: Seen) -> Array:
    """Slip missing to the target at the left and right rear wheel, (2, count)."""
    return np.asarray(seen["slip_target"] - np.stack([seen["slip_rl"], seen["slip_rr"]]))


def both(torque: Array) -> Array:
    """Actions (count, 2) of torques (2, count), within [-1, 1]."""
    return np.ascontiguousarray(np.clip(torque, -1.0, 1.0).T)


@dataclass(frozen=True, kw_only=True)
class ConstantTorque:
    """The same torque whatever the ground."""

    feed: Gain

    def init(self, count: int) -> None:
        """Nothing to remember."""

    def act(self, state: None, seen: Seen, period_s: float) -> tuple[None, Array]:
        """Torque = feed."""
        return state, both(self.feed + np.zeros((2, len(seen["slip_rl"]))))


@dataclass(frozen=True, kw_only=True)
class TorquePI:
    """PI on slip: torque = feed + kp e + integral of ki e, the integral within what is left."""

    feed: Gain
    kp: Gain
    """Action per slip error."""
    ki_ps: Gain
    """Action per slip error and second [1/s]."""

    def init(self, count: int) -> Array:
        """The integral parts."""
        return np.zeros((2, count))

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period."""
        error, gain = wheel_errors(seen), self.gain(seen)
        least, most = -1.0 - self.feed, 1.0 - self.feed
        integral = np.clip(state + gain * self.ki_ps * error * period_s, least, most)
        return integral, both(self.feed + gain * self.kp * error + integral)

    def gain(self, seen: Seen) -> Array | float:
        """Factor on both gains."""
        return 1.0


@dataclass(frozen=True, kw_only=True)
class ScheduledTorquePI(TorquePI):
    """PI whose gains grow as the wheel slips more, as the soil's own stiffness falls.

        gain = exp(k (s - target)), within exp(-2) ... exp(2)

    since thrust is a (1 - exp(-k s)). Source of the form: Brixius 1987; k is tuned.
    """

    rate: Gain

    def gain(self, seen: Seen) -> Array | float:
        """Factor on both gains."""
        return np.exp(np.clip(-self.rate * wheel_errors(seen), -2.0, 2.0))


@dataclass(frozen=True, kw_only=True)
class SlidingTorque:
    """Sliding mode with integral surface and boundary layer.

    sigma = e + integral of lambda e        torque = feed + K sat(sigma / phi)
    """

    feed: Gain
    reach: Gain
    """K."""
    surface_radps: Gain
    """lambda: slope of the surface [1/s]."""
    layer: Gain
    """phi: slip error at the edge of the boundary layer."""

    def init(self, count: int) -> Array:
        """The integral parts of the surface."""
        return np.zeros((2, count))

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period; the integral stays within the boundary layer."""
        error = wheel_errors(seen)
        integral = np.clip(state + self.surface_radps * error * period_s, -self.layer, self.layer)
        sigma = np.clip((error + integral) / self.layer, -1.0, 1.0)
        return integral, both(self.feed + self.reach * sigma)


TORQUE_BASELINES: dict[str, Controller] = {
    "constant": ConstantTorque(feed=0.645),
    "pi": TorquePI(feed=0.487, kp=0.052, ki_ps=19.3),
    "scheduled-pi": ScheduledTorquePI(feed=0.538, kp=0.505, ki_ps=17.8, rate=0.81),
    "sliding-mode": SlidingTorque(feed=0.649, reach=0.245, surface_radps=0.981, layer=0.173),
}
"""Gains found by `python -m twin.control.tune WheelSlip-v0` with an earlier contact law; their mean
rewards on the training grounds are now 0.5068, 0.7110, 0.7110, 0.6420 in this order."""
