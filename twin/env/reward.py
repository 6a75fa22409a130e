"""The reward: a sum of four named terms, none of them negative, so that ending early never pays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WEIGHTS = {"work": 0.3, "efficiency": 0.2, "slip": 0.25, "depth": 0.25}
"""Share of each term; they add up to 1."""
WORK_RATE_M2PS = 1e4 / 3600.0
"""Work rate that is worth a term's whole share: 1 ha/h."""
SLIP_TOLERANCE = 0.05
"""Slip error at which half the term is left."""
DEPTH_TOLERANCE_M = 0.03
"""Depth error at which half the term is left [m]."""


def work_rate_m2ps(true: Mapping[str, Array], width_m: float, depth_target_m: float) -> Array:
    """Area ploughed per second [m2/s]: width v min(1, depth / target)."""
    share = np.minimum(1.0, np.maximum(0.0, true["depth_m"] / depth_target_m))
    rate: Array = width_m * np.maximum(0.0, true["speed_mps"]) * share
    return rate


def closeness(error: Array, tolerance: float) -> Array:
    """1 / (1 + (e / tolerance)**2): 1 on the target, 1/2 a tolerance away, never flat."""
    ratio = error / tolerance
    return 1.0 / (1.0 + ratio * ratio)


def terms(
    true: Mapping[str, Array], width_m: float, depth_target_m: float, slip_target: float
) -> dict[str, Array]:
    """The terms of the reward for one control step, each of shape (nsim,).

    work       = 0.30 work rate / (1 ha/h)
    efficiency = 0.20 traction efficiency
    slip       = 0.25 / (1 + ((slip - target) / 0.05)**2)       of the driven axle
    depth      = 0.25 / (1 + ((depth - target) / 0.03 m)**2)
    """
    worth = {
        "work": work_rate_m2ps(true, width_m, depth_target_m) / WORK_RATE_M2PS,
        "efficiency": true["traction_efficiency"],
        "slip": closeness(true["slip"] - slip_target, SLIP_TOLERANCE),
        "depth": closeness(true["depth_m"] - depth_target_m, DEPTH_TOLERANCE_M),
    }
    return {name: WEIGHTS[name] * value for name, value in worth.items()}


PULLING_WEIGHTS = {"slip_left": 0.35, "slip_right": 0.35, "sideslip": 0.3}
"""Share of each term of WheelSlip-v0; they add up to 1."""
SIDESLIP_TOLERANCE_MPS = 0.05
"""Lateral speed of the rear axle at which half the term is left [m/s]."""


def pulling_terms(true: Mapping[str, Array], slip_target: float) -> dict[str, Array]:
    """The terms of WheelSlip-v0's reward for one control step, each of shape (nsim,).

    slip_left  = 0.35 / (1 + ((slip_rl - target) / 0.05)**2)       slip_right the same of slip_rr
    sideslip   = 0.30 / (1 + (v_y / 0.05 m/s)**2)                  of the rear axle
    """
    worth = {
        "slip_left": closeness(true["slip_rl"] - slip_target, SLIP_TOLERANCE),
        "slip_right": closeness(true["slip_rr"] - slip_target, SLIP_TOLERANCE),
        "sideslip": closeness(true["v_y_rear_mps"], SIDESLIP_TOLERANCE_MPS),
    }
    return {name: PULLING_WEIGHTS[name] * value for name, value in worth.items()}
