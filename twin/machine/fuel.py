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
"""Greatest reduction of the engine speed that the law uses [-]."""


def fuel_lph(
    numbers: Mapping[str, float], crank_power_w: ArrayLike, rate_radps: ArrayLike
) -> Array:
    """Fuel rate from power and speed of the engine, elementwise for arrays of any shape [L/h].

        Q = (0.22 X + 0.096) (1 + 0.0045 X N - 0.00877 N) P

    with the rated power P = eta_pto T_r w_r in kW at the power take-off (PTO), the share X of it in
    use and the reduction N of the engine speed from the rated speed in %:

        X = crank power / (T_r w_r)        N = 100 clip(1 - w / w_r, 0, 0.5)

    The PTO's drive loses the share 1 - eta_pto of any power, so X is the same at the crankshaft.
    Above rated speed N is 0. Below half of it, as at idle, N stays 50, because the law has no data
    there; it then gives more than an idling engine takes.

    Where the fuel of this engine at rated power was measured, Q is scaled to it. Q = 0 for an
    electric motor, and where the engine gives no power (it is dead, or driven with its fuel shut
    off).

    Args:
        numbers: the machine's numbers, with `engine.rated_torque_nm`, `engine.rated_rpm`,
            `engine.kind` and, for a diesel, `engine.pto_efficiency`; `engine.fuel_ratio` scales Q.
        crank_power_w: torque times speed of the engine.
        rate_radps: w, speed of the engine.

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
    """Fuel rate (0.22 X + 0.096) (1 + 0.0045 X N - 0.00877 N) P [L/h], of numbers or arrays.

    `x`, `n` and `pto_kw` are X, N [%] and P of `fuel_lph`.
    """
    return (0.22 * x + 0.096) * (1.0 + 0.0045 * x * n - 0.00877 * n) * pto_kw


inlined_d497_lph = inlined_law(d497_lph)


class Rated(NamedTuple):
    """Rated power and speed of an engine, for `engine_fuel_lph`."""

    power_w: float
    """T_r w_r; 0 for an electric motor, which burns nothing."""
    radps: float
    """w_r."""
    pto_kw: float
    """P, times measured over computed fuel at rated power where it was measured."""


def rated(numbers: Mapping[str, float]) -> Rated:
    """The rated values of a machine's engine; `numbers` as for `fuel_lph`."""
    if numbers["engine.kind"] == ELECTRIC:
        return Rated(0.0, 0.0, 0.0)
    radps = numbers["engine.rated_rpm"] * math.pi / 30.0
    power_w = numbers["engine.rated_torque_nm"] * radps
    pto_kw = 1e-3 * numbers["engine.pto_efficiency"] * power_w
    return Rated(power_w, radps, pto_kw * numbers.get("engine.fuel_ratio", 1.0))


@law
def engine_fuel_lph(engine: Rated, power_w: float, radps: float) -> float:
    """`fuel_lph` of one engine for one crank power and speed, compiled [L/h]."""
    if engine.power_w == 0.0 or not power_w > 0.0:
        return 0.0
    x = max(power_w / engine.power_w, 0.0)
    n = 100.0 * min(max(1.0 - radps / engine.radps, 0.0), MOST_REDUCED)
    return inlined_d497_lph(x, n, engine.pto_kw)
