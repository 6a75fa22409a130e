"""The baselines of WheelSlip-v1: a torque for each rear wheel, by its slip and by the line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.control.controllers import Array, Controller, Gain, Seen
from twin.control.torques import ConstantTorque, TorquePI


@dataclass(frozen=True, kw_only=True)
class TractionPI(TorquePI):
    """PI on the slip of each wheel, and a difference of torques against the way off the line.

    torque = feed + kp e + integral of ki e +- g y        e = slip_set - slip of the wheel

    The left wheel pulls more by g y where the tractor is y to the left of its line, the right one
    less.
    """

    slip_set: Gain
    line_pm: Gain
    """g: action per distance from the line [1/m]."""

    def act(self, state: Array, seen: Seen, period_s: float) -> tuple[Array, Array]:
        """One period."""
        target = np.broadcast_to(np.asarray(self.slip_set), seen["slip_rl"].shape)
        integral, torques = super().act(state, {**seen, "slip_target": target}, period_s)
        turn = self.line_pm * seen["line_left_m"]
        turned = torques + np.stack([turn, -turn], axis=-1)
        return integral, np.asarray(np.clip(turned, -1.0, 1.0))


TRACTION_BASELINES: dict[str, Controller] = {
    "constant": ConstantTorque(feed=0.5),
    "pi": TractionPI(feed=0.68, kp=1.11, ki_ps=3.42, slip_set=0.107, line_pm=0.998),
}
"""Gains of `pi` come from a random search like that of `twin.control.tune`, with fewer grounds;
those of `constant` are chosen."""
