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

The module is longer than 300 lines because all integrals over the contact arc use the same stresses
and the same quadrature rule.
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
"""Greatest sinkage that the law uses, as a share of the wheel's radius [-]."""
ITERATIONS = 2
"""Corrections of the sinkage before the forces are taken."""
STEEPEST_SKID = -0.99
"""Most negative slip that the law uses [-]: below it the wheel counts as locked."""
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
    """Shear stress as a share of the shear strength [-], along and across the wheel.

        (1 - exp(-J)) (J_x, J_y) / J        J = sqrt(J_x**2 + J_y**2)

    Args:
        along, across: J_x and J_y, each a shear displacement divided by its shear modulus.
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
    """Deflection of the tyre under its load on hard ground [m]; 0 for a rigid wheel."""
    stiffness = wheel[Wheel.STIFFNESS_NPM]
    return load_n / stiffness if 0.0 < stiffness < RIGID_NPM else 0.0


@law
def circle(wheel: Array, deflection_m: float, sinkage_m: float) -> tuple[float, float]:
    """Radius r* of the rigid wheel that replaces a flexible tyre, and its entry angle theta_1.

        2 r* / D = (sqrt(1 + f / z) + sqrt(f / z))**2
        theta_1  = acos(1 - z / r*)

    The larger wheel has the sinkage z and the contact length of the tyre of diameter D. A contact
    is taken as flat against D: the tyre's length is sqrt(D (z + f)) ahead of the hub and
    sqrt(D f) behind it. Bolling 1987. A rigid wheel (f = 0) keeps its radius.

    Args:
        wheel: part of the parameter block (`Wheel`), with the unloaded diameter D.
        deflection_m: f, of the tyre on hard ground.
        sinkage_m: z > 0.

    Returns:
        radius_m, entry angle [rad] from the vertical to where the wheel meets the soil.
    """
    f, z = deflection_m, sinkage_m
    radius = 0.5 * wheel[Wheel.DIAMETER_M]
    if f > 0.0:
        root = math.sqrt(z + f) + math.sqrt(f)
        radius *= root * root / z
    return radius, 2.0 * math.asin(math.sqrt(0.5 * z / radius))


@law
def normal_stress(soil: Array, modulus: float, depth_m: float) -> float:
    """Normal stress at a depth [Pa]: sigma = k z**n, k the modulus by `sinkage_modulus`."""
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
    """Load that stresses and shear carry at a sinkage z [N], by the coarse quadrature rule.

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
    """Forces on a wheel: integrals of the stresses sigma and tau along the contact arc.

        sigma(theta) = k (r (cos(theta) - cos(theta_1)))**n
                       ahead of theta_m = peak theta_1, mirrored from there onto [0, theta_m]
        tau(theta)   = (c + sigma tan(phi)) (1 - exp(-J)) along J = (j_x / K_x, j_y / K_y)
        j_x = r (theta_1 - theta - pace (sin(theta_1) - sin(theta)))
        j_y = r side (theta_1 - theta)

    with the cohesion c, the friction angle phi, and r and theta_1 from `circle`. The shear due to
    slip is the same integral of tau with j_x = r slip (sin(theta_1) - sin(theta)).

    Args:
        soil, wheel: parts of the parameter block (`Soil`, `Wheel`).
        modulus: k, the pressure at a sinkage of 1 m [Pa].
        deflection_m: deflection of the tyre on hard ground.
        z: sinkage [m].
        peak: theta_m / theta_1, where the normal stress is greatest.
        pace: forward speed over rim speed, v / (w r).
        side: sideways speed over rim speed; positive shears the soil to the left.
        slip: (w r - v) / (w r), for the shear due to slip.

    Returns:
        load_n, normal_n (the part of the load that sigma carries), pull_n, torque_n (torque
        divided by r), and the shear due to slip along and across the wheel [N].
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
    """Sinkage z under the normal stress alone, on a flat arc: the start of the iteration [m].

        W = b k C z**n L        L = sqrt(D (z + f)) + sqrt(D f)

    C is the mean of (1 - x)**n (1 + x)**n over x in [peak, 1], the second factor taken at the mean
    of x with the weight (1 - x)**n. W is the load, b and D are the wheel's width and diameter; the
    other arguments are as for `arc_forces`.
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
    """Exponent by which the load W that a flat arc carries grows with the sinkage z.

    d ln(W) / d ln(z) = n + z / (2 (z + f + sqrt(f (z + f)))), f the tyre's deflection.
    """
    f = deflection_m
    return soil[Soil.SINKAGE_EXPONENT] + 0.5 * z / (z + f + math.sqrt(f * (z + f)))


@law
def sunk_deeper(soil: Array, slip: float, side_slip: float) -> float:
    """Ratio of the sinkage with slip to that without: 1 + S min(sqrt(s**2 + s_y**2), 1).

    Lyasko 2010 has z = z_0 (1 + S s) of a wheel that runs straight ahead. Soil sheared sideways is
    taken to yield as soil sheared along the wheel does.
    """
    size = math.sqrt(slip * slip + side_slip * side_slip)
    return 1.0 + soil[Soil.SLIP_SINKAGE] * min(size, 1.0)


@law
def softened(soil: Array, modulus: float, deflection_m: float, z: float, deeper: float) -> float:
    """Modulus k' [Pa] with which a flat arc carries the same load at d z as with k at z.

        k' = k d**-n L(z) / L(d z)        L(z) = sqrt(z + f) + sqrt(f)

    For a rigid wheel k' = k d**-(n + 1/2).

    Args:
        soil: part of the parameter block (`Soil`), with the sinkage exponent n.
        modulus: k [Pa].
        deflection_m: f, of the tyre on hard ground.
        z: sinkage without slip [m].
        deeper: d, the ratio by `sunk_deeper`.
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
    """Sinkage at which the wheel carries its load [m].

        z <- z (W / W(z))**(1 / e)        e = d ln(W) / d ln(z)

    Newton's method in the logarithms, where W(z) is almost straight. It begins at `first_m`, with
    e by `stiffening`; then e is the slope between the last two sinkages. The number of steps is
    fixed, so that forces are smooth. The other arguments are as for `arc_forces`.
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
    """Sideways speed over forward speed: s_y / max(1 - |s|, 0.01).

    For a driven wheel (s >= 0) this is -v_y / v_x, the tangent of the slip angle, positive when the
    wheel slides to its right. A skidding wheel uses the same formula, so that (-s, -s_y) gives the
    opposite force of (s, s_y).
    """
    return side_slip / max(1.0 - abs(slip), LEAST_TRAVEL)


@law
def bulldozing_n(soil: Array, wheel: Array, deflection_m: float, z: float, aside: float) -> float:
    """Force of the soil on the sunk side of a wheel: Rankine's passive earth pressure [N].

        F = X (4/3 c z q + 4/15 g z**2 q**2) (1 - exp(-|a| X / K_y)) sign(a)
        q = tan(45 deg + phi / 2)        X = r sin(theta_1)

    with g the unit weight of the soil; the sunk side has a parabola as its outline. The pressure
    grows as the lateral shear does, with the distance a X by which the wheel moves sideways while
    it travels its contact length X. That distance does not depend on how fast the rim turns.

    Args:
        soil, wheel, deflection_m, z: as for `arc_forces`.
        aside: a, sideways speed over forward speed by `drift`; positive pushes to the left.
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
    """Shear at the contact, motion resistance at the hub, rolling moment on the wheel, sinkage.

        F_x, F_y = shear due to slip (see `arc_forces`); F_y includes the bulldozing force
        M_r = T / R - F_x           M_h = F_x - (net pull)

    so that axle torque, the integral of tau r dA, is (F_x + M_r) R and net pull, the integral of
    (tau cos(theta) - sigma sin(theta)) dA, is F_x - M_h. F_x is zero without slip, odd in the
    slip, and has the slip's sign. The shear that a wheel makes by rolling without slip is in M_r.

    A skidding wheel (s < 0) has minus the F_x of a driven wheel at |s|, and the shear in F_y of
    that driven wheel. Its torque, net pull and sinkage are integrated with w r = (1 + s) v.

    Args:
        soil, wheel: parts of the parameter block (`Soil`, `Wheel`).
        load_n: normal load, positive.
        slip, side_slip: (w R - v_x) / V and -v_y / V with V = max(|w R|, |v_x|), for a wheel that
            rolls forwards.

    Returns:
        shear_x_n, shear_y_n, resistance_n (M_h), rolling_moment_n (M_r, the moment divided by the
        rolling radius R), sinkage_m.
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
