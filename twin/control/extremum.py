"""Extremum seeking: the depth at which the tractor pulls most for its power, found by trying."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from twin.control.controllers import MOST_RELIEF_M, Array, Gain, Seen, actions, draft_n

REFERENCE_NM = 600.0
"""Engine torque that the bus shows as a load of 1; a factor on the efficiency alone."""
LEAST_W = 5e3
"""Crank power below which the efficiency counts as 0 [W]."""
WASHOUT = 0.4
"""Corner of the high-pass over the frequency of the dither."""


def overall_efficiency(seen: Seen) -> Array:
    """Drawbar power over crank power [-], (count,): draft speed / (torque engine speed)."""
    if "engine_torque_nm" in seen:
        torque_nm = seen["engine_torque_nm"]
    else:
        torque_nm = REFERENCE_NM * seen["engine_load"]
    crank_w = torque_nm * seen["engine_radps"]
    drawbar_w = draft_n(seen) * seen["speed_mps"]
    ratio = drawbar_w / np.maximum(crank_w, LEAST_W)
    return np.asarray(np.where(crank_w > LEAST_W, np.clip(ratio, 0.0, 1.0), 0.0))


class Seeking(NamedTuple):
    """What the search remembers."""

    time_s: float
    relief_m: Array
    """Middle of the trial (count,)."""
    slow: Array
    """Efficiency through the low-pass whose rest is the high-pass (count,)."""


@dataclass(frozen=True, kw_only=True)
class ExtremumSeeking:
    """Perturbation-based extremum seeking of the relief for efficiency.

        relief = r + a sin(w t)        dr/dt = k sin(w t) (eta - slow eta)

    eta is the efficiency from draft, speed and engine. The slip target is not used. The dither
    begins when the plough is in. Source: Krstic and Wang 2000, Automatica 36:595, equations 1-5.
    """

    throttle: Gain
    trim_m: Gain
    dither_m: Gain
    """a."""
    dither_radps: Gain
    """w."""
    seek_mps: Gain
    """k: relief per second and efficiency [m/s]."""

    def init(self, count: int) -> Seeking:
        """No relief, nothing tried."""
        return Seeking(0.0, np.zeros(count), np.zeros(count))

    def act(self, state: Seeking, seen: Seen, period_s: float) -> tuple[Seeking, Array]:
        """One period."""
        efficiency = overall_efficiency(seen)
        wave = np.sin(self.dither_radps * state.time_s)
        share = np.minimum(1.0, WASHOUT * self.dither_radps * period_s)
        slow = state.slow + share * (efficiency - state.slow)
        working = seen["depth_m"] > 0.5 * seen["depth_target_m"]
        change = np.where(working, self.seek_mps * wave * (efficiency - slow) * period_s, 0.0)
        middle = np.clip(state.relief_m + change, 0.0, MOST_RELIEF_M)
        relief_m = np.where(working, middle + self.dither_m * wave, middle)
        set_m = seen["depth_target_m"] + self.trim_m - relief_m
        new = Seeking(state.time_s + period_s, middle, slow)
        return new, actions(self.throttle, set_m)
