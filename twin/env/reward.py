"""The reward: a sum of named terms, none of them negative, so that ending early never pays."""

from __future__ import annotations

import numpy as np

from twin.compute.compiled import law

PLOUGHING = {"work": 0.3, "efficiency": 0.2, "slip": 0.25, "depth": 0.25}
"""Share of each term of Plough-v0; they add up to 1."""
WORK, EFFICIENCY, SLIP, DEPTH = PLOUGHING.values()
WORK_RATE_M2PS = 1e4 / 3600.0
"""Work rate that is worth a term's whole share: 1 ha/h."""
SLIP_TOLERANCE = 0.05
"""Slip error at which half the term is left."""
DEPTH_TOLERANCE_M = 0.03
"""Depth error at which half the term is left [m]."""

PULLING = {"slip_left": 0.35, "slip_right": 0.35, "sideslip": 0.3}
"""Share of each term of WheelSlip-v0; they add up to 1."""
SLIP_LEFT, SLIP_RIGHT, SIDESLIP = PULLING.values()
SIDESLIP_TOLERANCE_MPS = 0.05
"""Lateral speed of the rear axle at which half the term is left [m/s]."""


@law
def work_rate_m2ps(speed_mps: float, depth_m: float, width_m: float, target_m: float) -> float:
    """Area ploughed per second [m2/s]: width v min(1, depth / target)."""
    share = np.minimum(1.0, np.maximum(0.0, depth_m / target_m))
    return width_m * np.maximum(0.0, speed_mps) * share  # type: ignore[no-any-return]


@law
def closeness(error: float, tolerance: float) -> float:
    """1 / (1 + (e / tolerance)**2): 1 on the target, 1/2 a tolerance away, never flat."""
    ratio = error / tolerance
    return 1.0 / (1.0 + ratio * ratio)


@law
def ploughing(
    work_m2ps: float,
    efficiency: float,
    slip: float,
    depth_m: float,
    slip_target: float,
    depth_target_m: float,
) -> tuple[float, float, float, float]:
    """The terms of Plough-v0 for one control step of one tractor, in the order of PLOUGHING.

    work       = 0.30 work rate / (1 ha/h)
    efficiency = 0.20 traction efficiency
    slip       = 0.25 / (1 + ((slip - target) / 0.05)**2)       of the driven axle
    depth      = 0.25 / (1 + ((depth - target) / 0.03 m)**2)
    """
    return (
        WORK * (work_m2ps / WORK_RATE_M2PS),
        EFFICIENCY * efficiency,
        SLIP * closeness(slip - slip_target, SLIP_TOLERANCE),
        DEPTH * closeness(depth_m - depth_target_m, DEPTH_TOLERANCE_M),
    )


@law
def pulling(
    slip_rl: float, slip_rr: float, v_y_mps: float, slip_target: float
) -> tuple[float, float, float]:
    """The terms of WheelSlip-v0 for one control step of one tractor, in the order of PULLING.

    slip_left  = 0.35 / (1 + ((slip_rl - target) / 0.05)**2)       slip_right the same of slip_rr
    sideslip   = 0.30 / (1 + (v_y / 0.05 m/s)**2)                  of the rear axle
    """
    return (
        SLIP_LEFT * closeness(slip_rl - slip_target, SLIP_TOLERANCE),
        SLIP_RIGHT * closeness(slip_rr - slip_target, SLIP_TOLERANCE),
        SIDESLIP * closeness(v_y_mps, SIDESLIP_TOLERANCE_MPS),
    )
