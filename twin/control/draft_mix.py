"""Position, draft and their mix, as the hitch of a tractor has it: slip is not measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from twin.control.controllers import MOST_RELIEF_M, Array, Gain, Seen, actions, draft_n
from twin.simulation.driver import DRAFT_FILTER_S, VALVE_GAIN_PER_S


class MixState(NamedTuple):
    """What the valve remembers of each tractor (count,)."""

    relief_m: Array
    """How far the plough is lifted from its depth."""
    felt_n: Array
    """Draft as the pins feel it."""


@dataclass(frozen=True, kw_only=True)
class DraftMix:
    """Electronic hitch that follows a mix of position and draft.

        d relief/dt = g [m S (D - D_0) / D_0 - (1 - m) relief],   -S <= relief <= 0.15 m

    D is the draft through a low-pass of 0.1 s, and g the gain of the tractor's own valve. Lifting
    and lowering are alike, so hard ground is ploughed shallower and soft ground deeper. Source of
    the form: Scarlett 2001, Comput. Electron. Agric. 30:167, and `twin.simulation.driver`.
    """

    throttle: Gain
    trim_m: Gain
    mix: Gain
    """m: 0 follows the position alone, 1 the draft alone."""
    held_n: Gain
    """D_0: draft that is held [N]."""
    sensitivity_m: Gain
    """S: error of the depth that a draft of twice what is held counts as [m]."""

    def init(self, count: int) -> MixState:
        """At the lever's depth; the pins feel what is held."""
        return MixState(np.zeros(count), np.zeros(count) + self.held_n)

    def act(self, state: MixState, seen: Seen, period_s: float) -> tuple[MixState, Array]:
        """One period. While the plough enters, its small draft does not lower it further."""
        felt = state.felt_n + period_s / DRAFT_FILTER_S * (draft_n(seen) - state.felt_n)
        error = self.mix * self.sensitivity_m * (felt - self.held_n) / self.held_n
        rate = VALVE_GAIN_PER_S * (error - (1.0 - self.mix) * state.relief_m)
        entering = seen["depth_m"] < 0.5 * seen["depth_target_m"]
        deepest = np.where(entering, 0.0, -np.asarray(self.sensitivity_m))
        relief_m = np.clip(state.relief_m + rate * period_s, deepest, MOST_RELIEF_M)
        set_m = seen["depth_target_m"] + self.trim_m - relief_m
        return MixState(relief_m, felt), actions(self.throttle, set_m)
