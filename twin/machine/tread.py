"""Springs between tread and rim, from the relaxation lengths of a tyre."""

from __future__ import annotations

from collections.abc import Mapping

from twin.physics.block import Wheel

FIRM_STIFFNESS = 6.5
"""Slip stiffness over load on firm soil [-]: 0.88 x 7.5 (1 - exp(-Bn / 10)) at Bn 42, Brixius."""


def tread_part(tyre: Mapping[Wheel, float]) -> dict[Wheel, float]:
    """Springs K and dampers d between tread and rim, the derived numbers of a wheel's `Wheel` part.

        K_x = 6.5 N / L_x        K_y = 6.5 N kappa / L_y        d_x = tau / L_x
                                                                d_y = tau kappa / L_y

    so that on firm soil, under the nominal load N, a small slip builds up over the relaxation
    length L. On other soil and under another load that length is the soil law's stiffness over K.
    tau is the wheel's shear damping, kappa its lateral ratio.
    """
    long_m, lat_m = tyre[Wheel.RELAXATION_LONG_M], tyre[Wheel.RELAXATION_LAT_M]
    stiffness, ratio = FIRM_STIFFNESS * tyre[Wheel.NOMINAL_LOAD_N], tyre[Wheel.LATERAL_RATIO]
    return {
        Wheel.SHEAR_LONG_NPM: stiffness / long_m,
        Wheel.SHEAR_LAT_NPM: stiffness * ratio / lat_m,
        Wheel.SHEAR_DAMPING_LONG_SPM: tyre[Wheel.SHEAR_DAMPING_S] / long_m,
        Wheel.SHEAR_DAMPING_LAT_SPM: tyre[Wheel.SHEAR_DAMPING_S] * ratio / lat_m,
    }
