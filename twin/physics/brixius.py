"""The Brixius (1987) / ASABE D497 tyre-soil law, widened to combined slip."""

from __future__ import annotations

import math

from twin.compute.compiled import inlined_law
from twin.physics.block import Soil, Wheel
from twin.physics.shapes import Array


@inlined_law
def mobility(soil: Array, wheel: Array, load_n: float) -> float:
    """Mobility number of a tyre on a soil.

        Bn = (CI b d / W) (1 + 5 delta/h) / (1 + 3 b/d)

    CI in kPa, W in kN. Of a pair each tyre has half of the width and half of the load. Brixius
    1987; ASABE D497.
    """
    tyres = 1.0 + wheel[Wheel.PAIRED]
    b, d = wheel[Wheel.WIDTH_M] / tyres, wheel[Wheel.DIAMETER_M]
    bracket = (1.0 + 5.0 * wheel[Wheel.DEFLECTION_RATIO]) / (1.0 + 3.0 * b / d)
    return soil[Soil.CONE_INDEX_KPA] * 1e3 * b * d / (load_n / tyres) * bracket


@inlined_law
def brixius(
    soil: Array, wheel: Array, load_n: float, slip: float, side_slip: float
) -> tuple[float, float, float, float, float]:
    """Shear at the contact, motion resistance at the hub, rolling moment on the wheel.

        sigma = sqrt(s**2 + (kappa s_y)**2)
        G     = N mu (1 - exp(-0.1 Bn)) (1 - exp(-k sigma))
        F_x   = G s / sigma          F_y = G kappa s_y / sigma
        M_h   = N (m / Bn + 0.5 |s| / sqrt(Bn))
        M_r   = N c0

    so that gross traction is (F_x + M_r) / N, net traction (F_x - M_h) / N: c0 is in both of
    the source's ratios, therefore as a moment on the wheel and not as a pull. k, c0 and m are the
    soil's for a bias tyre. A radial tyre multiplies k by 9.5 / 7.5, c0 by 0.0325 / 0.04, m by 0.9.
    kappa is the tyre's lateral over its longitudinal slip stiffness.

    Args:
        soil, wheel: parts of the parameter block (`Soil`, `Wheel`).
        load_n: normal load N, positive.
        slip, side_slip: (w R - v_x) / V and -v_y / V with V = max(|w R|, |v_x|).

    Returns:
        shear_x_n, shear_y_n, resistance_n (M_h >= 0), rolling_moment_n (M_r, the moment divided by
        the rolling radius), sinkage_m (0: the law has no sinkage).
    """
    bn = mobility(soil, wheel, load_n)
    lateral = wheel[Wheel.LATERAL_RATIO] * side_slip
    sigma = math.sqrt(slip * slip + lateral * lateral)
    ceiling = load_n * soil[Soil.FRICTION] * (1.0 - math.exp(-0.1 * bn))
    k = soil[Soil.SLIP_RATE] * (1.0 + wheel[Wheel.SLIP_RATE_CHANGE])
    # (1 - exp(-k sigma)) / sigma, whose limit at zero is k
    per_slip = ceiling * (-math.expm1(-k * sigma) / sigma if sigma > 1e-9 else k)
    m = soil[Soil.MOBILITY_RESISTANCE] * (1.0 + wheel[Wheel.MOBILITY_RESISTANCE_CHANGE])
    resistance = load_n * (m / bn + 0.5 * abs(slip) / math.sqrt(bn))
    rolling = load_n * (soil[Soil.ROLLING_MOMENT] * (1.0 + wheel[Wheel.ROLLING_MOMENT_CHANGE]))
    return per_slip * slip, per_slip * lateral, resistance, rolling, 0.0
