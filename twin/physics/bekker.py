"""Bekker-Wong pressure-sinkage with Janosi-Hanamoto shear, integrated along the contact arc.

Angles are measured from the vertical under the hub, positive ahead: the wheel meets the soil at
theta_1 and leaves it at 0. Shear displacements are divided by the shear deformation moduli K_x and
K_y [m]; sinkage stays in m.

Sources: Bekker 1969, Introduction to Terrain-Vehicle Systems; Janosi & Hanamoto 1961; Wong & Reece
1967, J. Terramechanics 4(1):81 and 4(2):7; Bolling 1987 for the larger rigid wheel that replaces a
flexible tyre;
Wong 2008, Theory of Ground Vehicles, chapter 2, for all of these. Lyasko 2010, J. Terramechanics
47(1):21 for slip sinkage; Ishigami, Nagatani & Yoshida 2007, J. Field Robotics 24(3):233 for the
side force as shear and bulldozing.

One module, because all integrals over the arc use the same stresses and the same kind of rule.
"""

from __future__ import annotations

import math

import numpy as np

from twin.compute.compiled import law
from twin.physics.block import Soil, Wheel
from twin.physics.shapes import Array

RIGID_NPM = 1e8
"""A wheel stiffer than this is rigid [N/m]; a tractor's tyre has 2e5 to 7e5."""
DEEPEST = 0.9
"""Greatest sinkage over the radius of the wheel."""
ITERATIONS = 2
"""Corrections of the sinkage before the forces are taken."""
STEEPEST_SKID = -0.99
"""Skid beyond which the wheel counts as locked."""
LEAST_TRAVEL = 0.01
"""Travel over what the rim has turned, below which a spinning wheel counts as this slow."""


def _fractions(points: int) -> tuple[Array, Array]:
    """Gauss-Legendre places and weights on [0, 1] after t = u**2.

    Stress begins at the ends of the contact like t**n; u**(2 n + 1) does for few points.
    """
    x, w = np.polynomial.legendre.leggauss(points)
    u = 0.5 * (x + 1.0)
    return u * u, w * u


COARSE_T, COARSE_W = _fractions(3)
FINE_T, FINE_W = _fractions(5)
S1, S3, S5, S7, S9, S11 = ((-1) ** k / math.factorial(2 * k + 1) for k in range(6))
C2, C4, C6, C8, C10, C12 = ((-1) ** k / math.factorial(2 * k) for k in range(1, 7))


@law
def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine by their series, within 1e-7 to 1.5 rad: two library calls saved per point"""
    q = angle * angle
    sine = angle * (S1 + q * (S3 + q * (S5 + q * (S7 + q * (S9 + q * S11)))))
    cosine = S1 + q * (C2 + q * (C4 + q * (C6 + q * (C8 + q * (C10 + q * C12)))))
    return sine, cosine


@law
def mobilised(along: float, across: float) -> tuple[float, float]:
    """Share of the shear strength that a displacement over its modulus calls up, as a vector.

    (1 - exp(-J)) (J_x, J_y) / J        J = sqrt(J_x**2 + J_y**2)
    """
    size = math.sqrt(along * along + across * across)
    share = (1.0 - math.exp(-size)) / size if size > 1e-6 else 1.0 - 0.5 * size
    return share * along, share * across


@law
def sinkage_modulus(soil: Array, wheel: Array) -> float:
    """Pressure at a sinkage of 1 m [Pa]: k_c / b + k_phi."""
    return soil[Soil.K_C] / wheel[Wheel.WIDTH_M] + soil[Soil.K_PHI]


@law
def hard_deflection_m(wheel: Array, load_n: float) -> float:
    """Deflection of the tyre under its load on hard ground; 0 for a rigid wheel."""
    stiffness = wheel[Wheel.STIFFNESS_NPM]
    return load_n / stiffness if 0.0 < stiffness < RIGID_NPM else 0.0


@law
def circle(wheel: Array, deflection_m: float, sinkage_m: float) -> tuple[float, float]:
    """Radius [m] of the rigid wheel that replaces a flexible tyre, and its entry angle [rad].

        D* / D  = (sqrt(1 + f / z) + sqrt(f / z))**2
        theta_1 = acos(1 - z / r*)

    The circle with the tyre's sinkage z and, as chords of a flat arc, the tyre's contact length:
    sqrt(D (z + f)) ahead of the hub and sqrt(D f) behind it. Bolling 1987. A rigid wheel (f = 0)
    keeps its radius.
    """
    f, z = deflection_m, sinkage_m
    radius = 0.5 * wheel[Wheel.DIAMETER_M]
    if f > 0.0:
        root = math.sqrt(z + f) + math.sqrt(f)
        radius *= root * root / z
    return radius, 2.0 * math.asin(math.sqrt(0.5 * z / radius))


@law
def normal_stress(soil: Array, modulus: float, depth_m: float) -> float:
    """sigma = (k_c / b + k_phi) z**n, with the modulus of `sinkage_modulus` [Pa]."""
    return modulus * math.exp(soil[Soil.SINKAGE_EXPONENT] * math.log(max(depth_m, 1e-12)))


@law
def carried_n(
    soil: Array,
    wheel: Array,
    modulus: float,
    deflection_m: float,
    z: float,
    peak: float,
    pace: float,
    side: float,
) -> float:
    """Load that stresses and shear carry at a sinkage z, by the coarse rule.

        W = b r integral of (sigma cos(theta) + tau_x sin(theta)) d theta

    Args:
        soil, wheel, modulus, deflection_m, z, peak, pace, side: as for `arc_forces`.
    """
    radius, entry = circle(wheel, deflection_m, z)
    sine_1, cosine_1 = sine_cosine(entry)
    c, tan_phi = soil[Soil.COHESION_PA], soil[Soil.TAN_PHI]
    x_scale, y_scale = radius / soil[Soil.SHEAR_LONG_M], radius * side / soil[Soil.SHEAR_LAT_M]
    front, rear = entry * (1.0 - peak), entry * peak
    load = 0.0
    for i in range(COARSE_T.size):
        theta, width = entry - front * COARSE_T[i], front
        sine, cosine = sine_cosine(theta)
        sigma = normal_stress(soil, modulus, radius * (cosine - cosine_1))
        for _ in range(2):  # ahead of the peak, then at the mirrored place behind it
            behind = entry - theta
            tau, _y = mobilised(x_scale * (behind - pace * (sine_1 - sine)), y_scale * behind)
            load += COARSE_W[i] * width * (sigma * cosine + (c + sigma * tan_phi) * tau * sine)
            theta, width = rear * COARSE_T[i], rear
            sine, cosine = sine_cosine(theta)
    return wheel[Wheel.WIDTH_M] * radius * load


@law
def arc_forces(
    soil: Array,
    wheel: Array,
    modulus: float,
    deflection_m: float,
    z: float,
    peak: float,
    pace: float,
    side: float,
    slip: float,
) -> tuple[float, float, float, float, float, float]:
    """Stresses along the contact arc, summed to forces.

        sigma(theta) = k (r (cos(theta) - cos(theta_1)))**n
                       ahead of theta_m = peak theta_1, mirrored from there onto [0, theta_m]
        tau(theta)   = (c + sigma tan(phi)) (1 - exp(-J)) along J = (j_x / K_x, j_y / K_y)
        j_x = r (theta_1 - theta - pace (sin(theta_1) - sin(theta)))
        j_y = r side (theta_1 - theta)

    The slip's share of the shear is the same integral with
    j_x = r slip (sin(theta_1) - sin(theta)).

    Args:
        soil, wheel: parts of the block.
        modulus: k, the pressure at a sinkage of 1 m [Pa].
        deflection_m: of the tyre on hard ground.
        z: sinkage [m].
        peak: theta_m / theta_1.
        pace: travel over what the rim has turned, v / (w r).
        side: travel sideways over what the rim has turned; positive shears to the left.
        slip: (w r - v) / (w r) whose share is wanted.

    Returns:
        load_n, normal_n (what sigma alone carries), pull_n, torque_n (over the rolling radius),
        the slip's share of the shear along and across [N].
    """
    radius, entry = circle(wheel, deflection_m, z)
    sine_1, cosine_1 = sine_cosine(entry)
    c, tan_phi = soil[Soil.COHESION_PA], soil[Soil.TAN_PHI]
    x_scale, y_scale = radius / soil[Soil.SHEAR_LONG_M], radius * side / soil[Soil.SHEAR_LAT_M]
    front, rear = entry * (1.0 - peak), entry * peak
    normal = pull = torque = lift = slip_x = slip_y = 0.0
    for i in range(FINE_T.size):
        theta, width = entry - front * FINE_T[i], front
        sine, cosine = sine_cosine(theta)
        sigma = normal_stress(soil, modulus, radius * (cosine - cosine_1))
        for _ in range(2):  # ahead of the peak, then at the mirrored place behind it
            behind, chord = entry - theta, sine_1 - sine
            area = FINE_W[i] * width
            strength = area * (c + sigma * tan_phi)
            tau, _y = mobilised(x_scale * (behind - pace * chord), y_scale * behind)
            x, y = mobilised(x_scale * slip * chord, y_scale * behind)
            normal += area * sigma * cosine
            lift += strength * tau * sine
            pull += strength * tau * cosine - area * sigma * sine
            torque += strength * tau
            slip_x += strength * x
            slip_y += strength * y
            theta, width = rear * FINE_T[i], rear
            sine, cosine = sine_cosine(theta)
    size = wheel[Wheel.WIDTH_M] * radius
    return (
        size * (normal + lift), size * normal, size * pull, size * torque,
        size * slip_x, size * slip_y,
    )  # fmt: skip


@law
def first_sinkage_m(
    soil: Array, wheel: Array, modulus: float, load_n: float, deflection_m: float, peak: float
) -> float:
    """Sinkage under the normal stress alone, on a flat arc: where the iteration begins.

        W = b k C z**n sqrt(D z)

    C is the mean of (1 - x**2)**n over [peak, 1], with x in it at its mean under (1 - x)**n.
    """
    n = soil[Soil.SINKAGE_EXPONENT]
    mean = ((1.0 - peak) * (2.0 - (1.0 - peak) * (n + 1.0) / (n + 2.0))) ** n / (n + 1.0)
    flat = load_n / (wheel[Wheel.WIDTH_M] * modulus * mean)
    diameter = wheel[Wheel.DIAMETER_M]
    z = (flat / math.sqrt(diameter)) ** (1.0 / (n + 0.5))
    if deflection_m > 0.0:
        for _ in range(2):
            length = math.sqrt(diameter * (z + deflection_m)) + math.sqrt(diameter * deflection_m)
            ratio = flat / (z**n * length)
            z *= ratio ** (1.0 / stiffening(soil, deflection_m, z))
    return min(z, DEEPEST * 0.5 * diameter)


@law
def stiffening(soil: Array, deflection_m: float, z: float) -> float:
    """d ln(W) / d ln(z) of a flat arc: n + z / (2 (z + f + sqrt(f (z + f))))."""
    f = deflection_m
    return soil[Soil.SINKAGE_EXPONENT] + 0.5 * z / (z + f + math.sqrt(f * (z + f)))


@law
def sunk_deeper(soil: Array, slip: float, side_slip: float) -> float:
    """Sinkage of a slipping wheel over that without slip: 1 + S min(sqrt(s**2 + s_y**2), 1).

    Lyasko 2010 has z = z_0 (1 + S s) of a wheel that runs straight ahead. Soil sheared sideways is
    taken to yield as soil sheared along the wheel does.
    """
    size = math.sqrt(slip * slip + side_slip * side_slip)
    return 1.0 + soil[Soil.SLIP_SINKAGE] * min(size, 1.0)


@law
def softened(soil: Array, modulus: float, deflection_m: float, z: float, deeper: float) -> float:
    """Modulus with which a flat arc carries at the sinkage d z what it carried at z.

        k' = k d**-n L(z) / L(d z)        L(z) = sqrt(z + f) + sqrt(f)

    A rigid wheel's is k d**-(n + 1/2).
    """
    f = deflection_m
    before, after = math.sqrt(z + f) + math.sqrt(f), math.sqrt(deeper * z + f) + math.sqrt(f)
    return modulus * math.exp(-soil[Soil.SINKAGE_EXPONENT] * math.log(deeper)) * before / after


@law
def sinkage_m(
    soil: Array,
    wheel: Array,
    modulus: float,
    load_n: float,
    deflection_m: float,
    first_m: float,
    peak: float,
    pace: float,
    side: float,
) -> float:
    """Sinkage at which the wheel carries its load.

        z <- z (W / W(z))**(1 / e)        e = d ln(W) / d ln(z)

    Newton's method in the logarithms, where W(z) is almost straight; e is that of a flat arc at
    first, then that of the chord. A fixed number of steps, so that forces are smooth.
    """
    deepest = DEEPEST * 0.5 * wheel[Wheel.DIAMETER_M]
    z, exponent = first_m, stiffening(soil, deflection_m, first_m)
    step = before = 0.0
    for i in range(ITERATIONS):
        carried = carried_n(soil, wheel, modulus, deflection_m, z, peak, pace, side)
        missing = math.log(min(max(load_n / max(carried, 1e-3 * load_n), 0.1), 10.0))
        if i > 0 and abs(step) > 1e-6:
            chord = (before - missing) / step
            exponent = min(max(chord, 0.5 * exponent), 2.0 * exponent)
        step, before = missing / exponent, missing
        z = min(z * math.exp(step), deepest)
    return z


@law
def drift(slip: float, side_slip: float) -> float:
    """Travel sideways over travel ahead: s_y / max(1 - |s|, 0.01).

    For a driven wheel (s >= 0) this is -v_y / v_x, the tangent of the slip angle, positive when the
    wheel slides to its right. A skidding wheel uses the same formula, so that (-s, -s_y) gives the
    opposite force of (s, s_y).
    """
    return side_slip / max(1.0 - abs(slip), LEAST_TRAVEL)


@law
def bulldozing_n(soil: Array, wheel: Array, deflection_m: float, z: float, aside: float) -> float:
    """Rankine's passive earth pressure on the sunk side of a wheel, its sinkage a parabola.

        F = X (4/3 c z q + 4/15 g z**2 q**2) (1 - exp(-|a| X / K_y)) sign(a)
        q = tan(45 deg + phi / 2)        X = r sin(theta_1)

    with g the unit weight of the soil. It is called up as the lateral shear is, over the way the
    wheel moves aside while it travels its contact length, a X: however fast its rim turns, it
    pushes the soil beside it no further.

    Args:
        soil, wheel, deflection_m, z: as for `arc_forces`.
        aside: a, travel sideways over travel ahead, as of `drift`; positive pushes to the left.
    """
    tan_phi = soil[Soil.TAN_PHI]
    q = tan_phi + math.sqrt(1.0 + tan_phi * tan_phi)
    radius, entry = circle(wheel, deflection_m, z)
    reach = radius * sine_cosine(entry)[0]
    cohesion = 4.0 / 3.0 * soil[Soil.COHESION_PA] * z * q
    full = reach * (cohesion + 4.0 / 15.0 * soil[Soil.UNIT_WEIGHT_NPM3] * z * z * q * q)
    return full * mobilised(0.0, aside * reach / soil[Soil.SHEAR_LAT_M])[1]


@law
def bekker(
    soil: Array, wheel: Array, load_n: float, slip: float, side_slip: float
) -> tuple[float, float, float, float, float]:
    """Shear at the patch, motion resistance at the hub, rolling moment on the wheel, sinkage.

        F_x, F_y = shear whose displacement is the slip's alone; F_y has the bulldozing force too
        M_r = T / R - F_x           M_h = F_x - (net pull)

    so that axle torque, the integral of tau r dA, is (F_x + M_r) R and net pull, the integral of
    (tau cos(theta) - sigma sin(theta)) dA, is F_x - M_h. F_x is zero
    without slip, odd in the slip, and has the slip's sign. `arc_forces` integrates that shear. What
    a wheel shears by rolling alone is in M_r.

    A skidding wheel (s < 0) has minus the F_x of a driven wheel at |s|, and the shear in F_y of
    that wheel. Its torque, net pull and sinkage are those of its own arc, where w r = (1 + s) v.

    Args:
        soil, wheel: parameter blocks (Soil, Wheel).
        load_n: normal load, positive.
        slip, side_slip: (w R - v_x) / V and -v_y / V with V = max(|w R|, |v_x|), for a wheel that
            rolls forwards.

    Returns:
        shear_x_n, shear_y_n, resistance_n, rolling_moment_n (times the radius a moment), sinkage_m.
    """
    s = min(max(slip, STEEPEST_SKID), 1.0)
    driven = abs(s)
    peak = min(soil[Soil.PEAK] + soil[Soil.PEAK_SLIP] * driven, 0.9)
    f = hard_deflection_m(wheel, load_n)
    modulus, deeper = sinkage_modulus(soil, wheel), sunk_deeper(soil, s, side_slip)
    first = first_sinkage_m(soil, wheel, modulus, load_n, f, peak)
    modulus = softened(soil, modulus, f, first, deeper)
    first = min(deeper * first, DEEPEST * 0.5 * wheel[Wheel.DIAMETER_M])
    z = sinkage_m(soil, wheel, modulus, load_n, f, first, peak, 1.0 - driven, side_slip)
    load, normal, pull, torque, x, y = arc_forces(
        soil, wheel, modulus, f, z, peak, 1.0 - driven, side_slip, driven
    )
    rest = load_n / load  # of what the iteration left: the load is carried exactly
    x, y = math.copysign(rest * x, s), rest * y
    pushed = bulldozing_n(soil, wheel, f, z, drift(s, side_slip))
    if s < 0.0:
        pace, side = 1.0 / (1.0 + s), side_slip / (1.0 + s)
        z = sinkage_m(soil, wheel, modulus, load_n, f, first, peak, pace, side)
        load, normal, pull, torque, _x, _y = arc_forces(
            soil, wheel, modulus, f, z, peak, pace, side, 0.0
        )
        rest = load_n / max(load, 0.5 * normal)
    pull, torque = rest * pull, rest * torque
    z = min(z * rest ** (1.0 / stiffening(soil, f, z)), DEEPEST * 0.5 * wheel[Wheel.DIAMETER_M])
    return x, y + pushed, x - pull, torque - x, z
