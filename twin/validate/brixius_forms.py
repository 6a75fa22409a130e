"""Brixius' equations and a free wheel's closed form, evaluated apart from the twin's own law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from twin.physics.block import Wheel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Constants:
    """Brixius' numbers for a kind of tyre."""

    slip_rate: float
    rolling_moment: float
    mobility_resistance: float
    ceiling: float = 0.88


KINDS = {"bias": Constants(7.5, 0.04, 1.0), "radial": Constants(9.5, 0.0325, 0.9)}
"""ASABE D497 and Brixius 1987 for bias tyres; Al-Hamed et al. for radials."""


def mobility(sizes: Mapping[Wheel, float], load_n: float, cone_index_kpa: float) -> float:
    """Brixius' mobility number of a tyre on a soil [-].

    Bn = (CI b d / W) (1 + 5 delta/h) / (1 + 3 b/d)

    CI is the cone index, W the load, b the tyre's width, d its diameter, delta/h its deflection
    over the height of its section.

    Args:
        sizes: b, d and delta/h of one tyre, by `Wheel.WIDTH_M`, `DIAMETER_M`, `DEFLECTION_RATIO`.
        load_n: W.
        cone_index_kpa: CI.
    """
    b, d = sizes[Wheel.WIDTH_M], sizes[Wheel.DIAMETER_M]
    bracket = (1.0 + 5.0 * sizes[Wheel.DEFLECTION_RATIO]) / (1.0 + 3.0 * b / d)
    return cone_index_kpa * 1e3 * b * d / load_n * bracket


def gross(tyre: Constants, bn: float, slip: ArrayLike) -> Array:
    """GTR = 0.88 (1 - exp(-0.1 Bn)) (1 - exp(-k |s|)) sgn(s) + c0"""
    s = np.asarray(slip, dtype=np.float64)
    grip = tyre.ceiling * -math.expm1(-0.1 * bn)
    return np.asarray(-np.sign(s) * grip * np.expm1(-tyre.slip_rate * abs(s)) + tyre.rolling_moment)


def resistance(tyre: Constants, bn: float, slip: ArrayLike) -> Array:
    """MRR = m / Bn + c0 + 0.5 |s| / sqrt(Bn)"""
    s = np.abs(np.asarray(slip, dtype=np.float64))
    return np.asarray(tyre.mobility_resistance / bn + tyre.rolling_moment + 0.5 * s / math.sqrt(bn))


def free_wheel(tyre: Constants, bn: float, bearing: float = 0.0) -> tuple[float, float]:
    """Skid and towed force over load of a wheel whose only torque is its bearing's.

        GTR(s) + bearing = 0        towed ratio = MRR(s) + bearing

    Args:
        tyre: its numbers.
        bn: mobility number.
        bearing: torque of its bearing over radius and load.
    """
    skid = brentq(lambda s: float(gross(tyre, bn, s)) + bearing, -0.5, -1e-9)
    return float(skid), float(resistance(tyre, bn, skid)) + bearing


def stiffness(tyre: Constants, bn: float) -> float:
    """Slope of gross traction at zero slip, force over load per slip: 0.88 (1 - exp(-Bn/10)) k."""
    return tyre.ceiling * -math.expm1(-0.1 * bn) * tyre.slip_rate
