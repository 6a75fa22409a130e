"""The contact arc of a rigid wheel integrated anew: adaptive quadrature, bracketed root."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from tests.physics.blocks import filled, with_tread
from twin.physics.block import Soil, Wheel

SOILS = {  # k_c, k_phi [kN, m], n, c [kPa], phi [deg], K [m]
    "A": (5.27, 1528.43, 0.7, 1.72, 29.0, 0.025),
    "B": (13.19, 692.15, 0.5, 4.14, 13.0, 0.010),
    "C": (102.0, 5301.0, 0.793, 1.3, 31.1, 0.012),
}
PEAK, PEAK_SLIP = 0.40, 0.15


def sinking(k_c, k_phi, n, c_kpa, phi_deg, shear_m, **own):
    """Soil block for Bekker's law."""
    values = {
        Soil.LAW: 1,
        Soil.K_C: 1e3 * k_c,
        Soil.K_PHI: 1e3 * k_phi,
        Soil.SINKAGE_EXPONENT: n,
        Soil.COHESION_PA: 1e3 * c_kpa,
        Soil.TAN_PHI: math.tan(math.radians(phi_deg)),
        Soil.FRICTION: math.tan(math.radians(phi_deg)),
        Soil.SHEAR_LONG_M: shear_m,
        Soil.SHEAR_LAT_M: shear_m,
        Soil.UNIT_WEIGHT_NPM3: 15e3,
        Soil.PEAK: PEAK,
        Soil.PEAK_SLIP: PEAK_SLIP,
    }
    return filled(Soil.SIZE, values | {Soil[name.upper()]: x for name, x in own.items()})


def rigid_wheel(radius_m=0.45, width_m=0.30):
    return with_tread(
        {
            Wheel.WIDTH_M: width_m,
            Wheel.DIAMETER_M: 2.0 * radius_m,
            Wheel.STIFFNESS_NPM: 1e9,
            Wheel.DEFLECTION_RATIO: 0.2,
            Wheel.FREE_ROLLING_RADIUS_M: radius_m,
            Wheel.RELAXATION_LONG_M: 0.2,
            Wheel.RELAXATION_LAT_M: 0.7,
            Wheel.LATERAL_RATIO: 0.85,
            Wheel.SHEAR_DAMPING_S: 0.2,
            Wheel.NOMINAL_LOAD_N: 21.7e3,
            Wheel.INERTIA_KGM2: 95.0,
        },
    )


@dataclass(frozen=True)
class Arc:
    """Wong & Reece 1967 and Janosi & Hanamoto 1961 on a rigid wheel, straight ahead.

    A side slip only sinks it deeper: 1 + S times the slip's size, by a modulus that a flat arc
    would need for it.
    """

    ground: np.ndarray
    slip: float
    radius_m: float = 0.45
    width_m: float = 0.30
    side_slip: float = 0.0

    def stresses(self, theta, entry):
        """sigma, tau at an angle from the vertical, and the strength there [Pa]."""
        g, r = self.ground, self.radius_m
        peak = (g[Soil.PEAK] + g[Soil.PEAK_SLIP] * abs(self.slip)) * entry
        ahead = theta if theta >= peak else entry - theta / peak * (entry - peak)
        depth = max(0.0, r * (math.cos(ahead) - math.cos(entry)))
        modulus = g[Soil.K_C] / self.width_m + g[Soil.K_PHI]
        n, size = g[Soil.SINKAGE_EXPONENT], min(math.hypot(self.slip, self.side_slip), 1.0)
        sigma = modulus * (1.0 + g[Soil.SLIP_SINKAGE] * size) ** -(n + 0.5) * depth**n
        pace = 1.0 - self.slip if self.slip >= 0.0 else 1.0 / (1.0 + self.slip)
        j = r * (entry - theta - pace * (math.sin(entry) - math.sin(theta)))
        strength = g[Soil.COHESION_PA] + sigma * g[Soil.TAN_PHI]
        mobilised = 1.0 - math.exp(-abs(j) / g[Soil.SHEAR_LONG_M])
        return sigma, math.copysign(strength * mobilised, j), strength

    def integral(self, z, integrand):
        """b r times the integral of integrand(theta, sigma, tau, strength) over the arc."""
        entry = math.acos(1.0 - z / self.radius_m)
        peak = (self.ground[Soil.PEAK] + self.ground[Soil.PEAK_SLIP] * abs(self.slip)) * entry
        parts = ((0.0, peak), (peak, entry)) if peak > 1e-3 * entry else ((0.0, entry),)
        total = sum(
            quad(lambda t: integrand(t, *self.stresses(t, entry)), a, b, epsabs=1e-8, limit=200)[0]
            for a, b in parts
        )
        return self.width_m * self.radius_m * total

    def load_n(self, z):
        return self.integral(z, lambda t, s, tau, _: s * math.cos(t) + tau * math.sin(t))

    def sinkage_m(self, load_n):
        return brentq(lambda z: self.load_n(z) - load_n, 1e-6, 0.9 * self.radius_m, xtol=1e-10)

    def pull_n(self, z):
        return self.integral(z, lambda t, s, tau, _: tau * math.cos(t) - s * math.sin(t))

    def torque_n(self, z):
        """Axle torque over the radius."""
        return self.integral(z, lambda t, s, tau, _: tau)

    def strength_n(self, z):
        return self.integral(z, lambda t, s, tau, strength: strength)
