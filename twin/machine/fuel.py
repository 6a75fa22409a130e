"""Fuel rate of a machine's engine, from the power it gives and how fast it turns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.compute.compiled import inlined_law, law
from twin.physics.engine import ELECTRIC

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)

MOST_REDUCED = 0.5
"""Reduction of the engine speed beyond which the law is not carried on [-]."""


def fuel_lph(
    numbers: Mapping[str, float], crank_power_w: ArrayLike, rate_radps: ArrayLike
) -> Array:
    """Fuel rate by power and speed of the engine, of any shape, elementwise [L/h].

        Q = (0.22 X + 0.096) (1 + 0.0045 X N - 0.00877 N) P

    with the rated PTO power P = eta_pto T_r w_r in kW, the share X of it in use and the reduction N
    of the engine speed from the rated one in %:

        X = crank power / (T_r w_r)        N = 100 clip(1 - w / w_r, 0, 0.5)

    The PTO's drive takes the same share 1 - eta_pto of all powers, so that X is the crank's too.
    Above rated speed, on the governor's line of full throttle, N is 0. Below half of it, as at
    idle, N stays 50: there the law leaves its data, and fuel falls no further, which is more than
    an idling engine takes.

    Where the fuel of this engine at rated power was measured, Q is scaled to it.

    An engine that gives no power is dead or driven, its fuel shut off: Q = 0. So is a motor's.

    Args:
        numbers: the machine's own, with `engine.rated_torque_nm`, `engine.rated_rpm`,
            `engine.kind` and, of a diesel, `engine.pto_efficiency`.
        crank_power_w: torque times speed of the engine.
        rate_radps: speed of the engine.

    Source: ASABE D497.7 after Grisso, Kocher and Vaughan 2004, Appl. Eng. Agric. 20(5):553. The
    printed page was not seen. The constants are from memory; one transcription of the standard has
    the same, (0.22 X + 0.096) P (1 - (n - 1) (0.45 X - 0.877)) with n = w / w_r in [0.5, 1].
    """
    power_w, radps = np.asarray(crank_power_w, np.float64), np.asarray(rate_radps, np.float64)
    if numbers["engine.kind"] == ELECTRIC:
        return np.zeros(np.broadcast_shapes(power_w.shape, radps.shape))
    engine = rated(numbers)
    x = np.maximum(power_w / engine.power_w, 0.0)
    n = 100.0 * np.clip(1.0 - radps / engine.radps, 0.0, MOST_REDUCED)
    return np.where(power_w > 0.0, d497_lph(x, n, engine.pto_kw), 0.0)


def d497_lph(x: Number, n: Number, pto_kw: float) -> Number:
    """The law itself, (0.22 X + 0.096) (1 + 0.0045 X N - 0.00877 N) P, of numbers or arrays."""
    return (0.22 * x + 0.096) * (1.0 + 0.0045 * x * n - 0.00877 * n) * pto_kw


inlined_d497_lph = inlined_law(d497_lph)


class Rated(NamedTuple):
    """What the law needs to know of an engine."""

    power_w: float
    """T_r w_r; 0 of a motor, which burns nothing."""
    radps: float
    """w_r."""
    pto_kw: float
    """P, and more or less of it where the engine's own fuel at rated power was measured."""


def rated(numbers: Mapping[str, float]) -> Rated:
    """What the law needs, from a machine's own numbers."""
    if numbers["engine.kind"] == ELECTRIC:
        return Rated(0.0, 0.0, 0.0)
    radps = numbers["engine.rated_rpm"] * math.pi / 30.0
    power_w = numbers["engine.rated_torque_nm"] * radps
    pto_kw = 1e-3 * numbers["engine.pto_efficiency"] * power_w
    return Rated(power_w, radps, pto_kw * numbers.get("engine.fuel_ratio", 1.0))


@law
def engine_fuel_lph(engine: Rated, power_w: float, radps: float) -> float:
    """`fuel_lph` of one engine."""
    if engine.power_w == 0.0 or not power_w > 0.0:
        return 0.0
    x = max(power_w / engine.power_w, 0.0)
    n = 100.0 * min(max(1.0 - radps / engine.radps, 0.0), MOST_REDUCED)
    return inlined_d497_lph(x, n, engine.pto_kw)
