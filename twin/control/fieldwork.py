"""The baselines of Plough-v1: throttle, gear, depth and draft mix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.control.controllers import Array, Controller, Gain, Seen, actions, relieved


def field_actions(throttle: Gain, gear: Gain, depth_set_m: Array, mix: Gain) -> Array:
    """Actions of `Plough-v1`, shape (count, 4), clipped to [-1, 1].

    Args:
        throttle, gear: actions, in [-1, 1]; numbers or arrays (count,).
        depth_set_m: depth set point, (count,).
        mix: share of the draft, from 0 to 1.
    """
    first, hitch = actions(throttle, depth_set_m).T
    gears, mixes = (
        np.broadcast_to(np.clip(value, -1.0, 1.0), hitch.shape)
        for value in (gear, 2.0 * np.asarray(mix) - 1.0)
    )
    return np.stack([first, gears, hitch, mixes], axis=-1)


@dataclass(frozen=True, kw_only=True)
class FieldPI:
    """PI on slip by the hitch; throttle, gear and draft mix as they were tuned.

    depth set = target + trim - relief        relief = kp e + integral of ki e, e = slip - set
    """

    throttle: Gain
    gear: Gain
    mix: Gain
    slip_set: Gain
    trim_m: Gain
    kp_m: Gain
    ki_mps: Gain

    def init(self, count: int) -> Array:
        """The integral part of the relief [m], (count,)."""
        return np.zeros(count)

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period."""
        error = seen["slip"] - self.slip_set
        integral, relief_m = relieved(state, error, self.kp_m, self.ki_mps, period_s)
        depth_m = seen["depth_target_m"] + self.trim_m - relief_m
        return integral, field_actions(self.throttle, self.gear, depth_m, self.mix)


@dataclass(frozen=True, kw_only=True)
class FieldConstant:
    """Constant throttle, gear, depth and draft mix."""

    throttle: Gain
    gear: Gain
    mix: Gain
    trim_m: Gain

    def init(self, count: int) -> None:
        """No state."""

    def act(self, state: None, seen: Seen, period_s: float) -> tuple[None, Array]:
        """Depth set = target + trim."""
        depth_m = seen["depth_target_m"] + self.trim_m
        return state, field_actions(self.throttle, self.gear, depth_m, self.mix)


FIELD_BASELINES: dict[str, Controller] = {
    "constant": FieldConstant(throttle=0.742, gear=0.66, mix=0.604, trim_m=-0.054),
    "pi": FieldPI(
        throttle=0.493, gear=0.67, mix=0.151, slip_set=0.136, trim_m=-0.027, kp_m=1.38,
        ki_mps=0.00524,
    ),
}  # fmt: skip
"""Gains found by `python -m twin.control.tune Plough-v1`; their mean rewards on its grounds are
1.7971, 1.8686 in this order."""
