"""What a controller is, and baselines: constant, PI on slip, gain-scheduled PI, sliding mode.

All hold the throttle and move the hitch: shallower when the wheels slip too much.

    depth set = target + trim - relief,   0 <= relief <= 0.15 m
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from twin.env.levers import DEEPEST_M, RAISED_M, Number

Array = NDArray[np.float64]
Seen = Mapping[str, Array]
Gain = float | Array

State: TypeAlias = Any
"""Whatever a controller keeps from one control step to the next."""

MOST_RELIEF_M = 0.15
"""Most that a slip controller lifts the plough from its depth [m]."""


class Controller(Protocol):
    """A controller of `count` tractors: a state, and actions from observations.

    `seen` maps the name of each entry of the observation to its values (count,).
    """

    def init(self, count: int) -> State:
        """State before the first observation."""

    def act(self, state: State, seen: Seen, period_s: float) -> tuple[State, Array]:
        """New state and actions (count, 2) in [-1, 1]; `period_s` is the control step [s]."""


def hitch_action(depth_set_m: Number, deepest_m: float = DEEPEST_M) -> Number:
    """Hitch action of a depth set point: [-0.10 m, deepest] maps linearly to [-1, 1]."""
    return 2.0 * (depth_set_m - RAISED_M) / (deepest_m - RAISED_M) - 1.0


def actions(throttle: Gain, depth_set_m: Array) -> Array:
    """Actions of `Plough-v0`, shape (count, 2), clipped to [-1, 1].

    Args:
        throttle: throttle action, in [-1, 1] already; a number or an array (count,).
        depth_set_m: depth set point, (count,); [-0.10, 0.35] m maps linearly to [-1, 1].
    """
    hitch = hitch_action(depth_set_m)
    both = np.stack([np.broadcast_to(np.asarray(throttle), hitch.shape), hitch], axis=-1)
    return np.asarray(np.clip(both, -1.0, 1.0), dtype=np.float64)


def slip_error(seen: Seen) -> Array:
    """Slip minus target, signed [-], (count,)."""
    return seen["slip"] - seen["slip_target"]


def relieved(
    integral_m: Array, error: Array, kp_m: Gain, ki_mps: Gain, period_s: float
) -> tuple[Array, Array]:
    """Integral part, and whole relief of a PI on slip [m], both within the relief's range."""
    held = np.clip(integral_m + ki_mps * error * period_s, 0.0, MOST_RELIEF_M)
    return held, np.clip(kp_m * error + held, 0.0, MOST_RELIEF_M)


def draft_n(seen: Seen) -> Array:
    """The draft by the pin in the hitch, or the true one where that is what is seen [N]."""
    return seen["draft_pin_n"] if "draft_pin_n" in seen else seen["draft_n"]


@dataclass(frozen=True, kw_only=True)
class Constant:
    """Constant throttle and depth, without feedback of slip."""

    throttle: Gain
    trim_m: Gain

    def init(self, count: int) -> None:
        """No state."""

    def act(self, state: None, seen: Seen, period_s: float) -> tuple[None, Array]:
        """Depth set = target + trim."""
        return state, actions(self.throttle, seen["depth_target_m"] + self.trim_m)


@dataclass(frozen=True, kw_only=True)
class PI:
    """PI on slip: relief = kp e + integral of ki e, both within the relief's range."""

    throttle: Gain
    trim_m: Gain
    kp_m: Gain
    """Relief per slip error [m]."""
    ki_mps: Gain
    """Relief per slip error and second [m/s]."""

    def init(self, count: int) -> Array:
        """The integral part of the relief [m], (count,)."""
        return np.zeros(count)

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period."""
        gain = self.gain(seen)
        integral, relief_m = relieved(
            state, slip_error(seen), gain * self.kp_m, gain * self.ki_mps, period_s
        )
        return integral, actions(self.throttle, seen["depth_target_m"] + self.trim_m - relief_m)

    def gain(self, seen: Seen) -> Gain:
        """Factor on both gains."""
        return 1.0


@dataclass(frozen=True, kw_only=True)
class ScheduledPI(PI):
    """PI whose gains fall as slip grows, as the plant's own gain rises.

        gain = exp(-k min(s - target, 1 / k))

    since the pull of a tyre is a (1 - exp(-k s)) and so ds/dpull = exp(k s) / (a k);
    beyond 1 / k the relief itself would fall as slip grows.
    Source of the form: Brixius 1987; k is tuned.
    """

    rate: Gain = 7.5

    def gain(self, seen: Seen) -> Gain:
        """Factor on both gains."""
        most = 1.0 / np.maximum(self.rate, 1.0)
        return np.asarray(np.exp(-self.rate * np.clip(slip_error(seen), -0.3, most)))


@dataclass(frozen=True, kw_only=True)
class SlidingMode:
    """Sliding mode with integral surface and boundary layer.

        sigma  = e + integral of lambda e        relief = K (1 + sat(sigma / phi)) / 2

    e is the slip error, and sat clips to [-1, 1].
    """

    throttle: Gain
    trim_m: Gain
    reach_m: Gain
    """K: most relief [m]."""
    surface_radps: Gain
    """lambda: slope of the surface [1/s]."""
    layer: Gain
    """phi: slip error at the edge of the boundary layer [-]."""

    def init(self, count: int) -> Array:
        """The integral part of sigma / phi [-], (count,); -1 is no relief."""
        return np.full(count, -1.0)

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period; the integral stays within the boundary layer."""
        error = slip_error(seen)
        integral = state + self.surface_radps * error * period_s / self.layer
        integral = np.clip(integral, -1.0, 1.0)
        sigma = np.clip(error / self.layer + integral, -1.0, 1.0)
        relief_m = self.reach_m * 0.5 * (1.0 + sigma)
        return integral, actions(self.throttle, seen["depth_target_m"] + self.trim_m - relief_m)
