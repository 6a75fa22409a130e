"""The reward: a sum of named terms, of which a stalled tractor gets none more.

Those of v0 are never negative, and of v1 only fuel and energy are; so a stall does not pay.
"""

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

WORKING = {"work": 1.0, "fuel": 0.02, "depth": 0.5, "slip": 0.5, "lugging": 0.5}
"""Prices of Plough-v1: of the reference area rate; of a litre, in hectares; of each limit kept.
65 EUR for the hour of machine and driver in which it works about a hectare, and
1.3 EUR/L for diesel, assumed; the limits' are assumed."""
FUEL_HA_PER_L, LIMIT_PRICE = WORKING["fuel"], WORKING["depth"]
REFERENCE_MPS = 7.0 / 3.6
"""Speed at which the reference area rate is worked over the whole width, ASABE D497's typical."""
MOST_MPS = 10.0 / 3.6
"""Speed beyond which nothing more counts: the end of D497's range for mould-board ploughs."""
DEPTH_LIMIT_M, DEPTH_OVER_M = 0.02, 0.05
SLIP_LIMIT, SLIP_OVER = 0.15, 0.10
LUGGING_OVER = 0.10
"""Limits of depth error and slip, and how far beyond them a cost is whole; lugging begins at the
speed of the greatest torque, and its cost is whole at 0.9 of it."""


@law
def excess(value: float, limit: float, over: float) -> float:
    """clip((value - limit) / over, 0, 1): the cost of a value beyond its limit."""
    return min(max((value - limit) / over, 0.0), 1.0)


@law
def working_costs(
    depth_error_m: float, slip: float, engine_rpm: float, peak_rpm: float, load: float
) -> tuple[float, float, float]:
    """The costs of Plough-v1, each in [0, 1], 0 within its limit.

    depth   = clip((|depth - target| - 0.02 m) / 0.05 m, 0, 1)
    slip    = clip((slip - 0.15) / 0.10, 0, 1)                          of the driven axle
    lugging = clip((1 - n / n_peak) / 0.10, 0, 1) clip(T / T_full(n), 0, 1)
    """
    below = excess(1.0 - engine_rpm / peak_rpm, 0.0, LUGGING_OVER)
    return (
        excess(abs(depth_error_m), DEPTH_LIMIT_M, DEPTH_OVER_M),
        excess(slip, SLIP_LIMIT, SLIP_OVER),
        below * min(max(load, 0.0), 1.0),
    )


@law
def kept(cost: float) -> float:
    """0.5 (1 - cost): what is earned at a limit, whole within it.

    What a limit costs is not taken off instead: a stalled engine would then earn more, nothing,
    than a tractor that works beyond its limits.
    """
    return LIMIT_PRICE * (1.0 - cost)


TRACTION = {"work": 1.0, "energy": 0.001, "line": 0.5, "slip": 0.5}
"""Prices of WheelSlip-v1: of the reference speed; of a watt; of each limit kept; assumed."""
ENERGY_PER_W = TRACTION["energy"]
TRACTION_MPS = 1.2
"""Speed that is worth 1 [m/s]."""
LINE_LIMIT_M, LINE_OVER_M = 0.10, 0.20
TRACTION_SLIP_LIMIT, TRACTION_SLIP_OVER = 0.20, 0.20
"""Limits of the distance from the line and of each wheel's slip, and how far beyond them a cost is
whole."""


@law
def traction_costs(left_m: float, slip_rl: float, slip_rr: float) -> tuple[float, float]:
    """The costs of WheelSlip-v1, each in [0, 1], 0 within its limit.

    line = clip((|y| - 0.10 m) / 0.20 m, 0, 1)              of the rear axle, from its line
    slip = mean of clip((s - 0.20) / 0.20, 0, 1)            of both rear wheels
    """
    left = excess(slip_rl, TRACTION_SLIP_LIMIT, TRACTION_SLIP_OVER)
    right = excess(slip_rr, TRACTION_SLIP_LIMIT, TRACTION_SLIP_OVER)
    return excess(abs(left_m), LINE_LIMIT_M, LINE_OVER_M), 0.5 * (left + right)


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
