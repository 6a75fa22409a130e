"""A rigid wheel's contact arc integrated apart from the twin's own law: adaptive quadrature."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from scipy.integrate import quad
from scipy.optimize import brentq

from twin.scenario.soils import Deformable


@dataclass(frozen=True)
class Arc:
    """Wong & Reece's stresses with Janosi & Hanamoto's shear, straight ahead.

    sigma = k z**n, greatest at theta_m = (c_1 + c_2 |s|) theta_1
    k     = (k_c / b + k_phi) (1 + S |s|)**-(n + 1/2), which a flat arc needs to sink 1 + S |s|
            times as deep under its load
    tau   = (c + sigma tan(phi)) (1 - exp(-j / K))
    """

    soil: Deformable
    slip: float
    radius_m: float
    width_m: float

    def _stresses_pa(self, theta: float, entry: float) -> tuple[float, float]:
        soil, r = self.soil, self.radius_m
        peak = self._peak(entry)
        ahead = theta if theta >= peak else entry - theta / peak * (entry - peak)
        depth = max(0.0, r * (math.cos(ahead) - math.cos(entry)))
        modulus = 1e3 * (soil.k_c_kn_per_m_n1 / self.width_m + soil.k_phi_kn_per_m_n2)
        n, deeper = soil.sinkage_exponent, 1.0 + soil.slip_sinkage * abs(self.slip)
        sigma = modulus * deeper ** -(n + 0.5) * depth**n
        j = r * (entry - theta - (1.0 - self.slip) * (math.sin(entry) - math.sin(theta)))
        strength = 1e3 * soil.cohesion_kpa + sigma * math.tan(math.radians(soil.friction_angle_deg))
        return sigma, math.copysign(strength * -math.expm1(-abs(j) / soil.shear_modulus_m), j)

    def _peak(self, entry: float) -> float:
        return (self.soil.stress_peak + self.soil.stress_peak_slip * abs(self.slip)) * entry

    def _integral(self, z: float, integrand: Callable[[float, float, float], float]) -> float:
        """b r times the integral of integrand(theta, sigma, tau) over the arc."""
        entry = math.acos(1.0 - z / self.radius_m)
        peak = self._peak(entry)
        parts = ((0.0, peak), (peak, entry)) if peak > 1e-3 * entry else ((0.0, entry),)
        total = sum(
            quad(lambda t: integrand(t, *self._stresses_pa(t, entry)), a, b, epsabs=1e-8)[0]
            for a, b in parts
        )
        return self.width_m * self.radius_m * total

    def sinkage_m(self, load_n: float) -> float:
        """Sinkage at which the arc carries the load."""

        def missing_n(z: float) -> float:
            carried = self._integral(z, lambda t, s, tau: s * math.cos(t) + tau * math.sin(t))
            return carried - load_n

        return float(brentq(missing_n, 1e-6, 0.9 * self.radius_m, xtol=1e-9))

    def pull_n(self, z: float) -> float:
        """Net pull."""
        return self._integral(z, lambda t, s, tau: tau * math.cos(t) - s * math.sin(t))

    def torque_n(self, z: float) -> float:
        """Axle torque over the radius."""
        return self._integral(z, lambda t, s, tau: tau)
