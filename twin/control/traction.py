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
    "pi": TractionPI(feed=0.87, kp=1.23, ki_ps=11.4, slip_set=0.106, line_pm=1.28),
}
"""The gains of `pi` were found by `python -m twin.control.tune WheelSlip-v1`, with a mean reward of
1.4760 on its grounds; that of `constant` is chosen."""
