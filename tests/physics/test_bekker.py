"""Bekker-Wong's law against the arc integrated anew, closed forms, and what shear may not do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import beta

from tests.physics.arcs import SOILS, Arc, rigid_wheel, sinking
from tests.physics.blocks import wheel
from twin.physics.bekker import bekker, bulldozing_n, circle, drift, sine_cosine
from twin.physics.block import Soil, Wheel
from twin.physics.laws import law_number
from twin.physics.tyre import relaxed_shear

LAW = law_number("bekker")
"""Of no other use here: the law is compiled where it is asked for by its number."""
LOADS_N = (2e3, 5e3, 10e3)


def pull_torque_sinkage(ground, tyre, load_n, slip):
    """Net pull and axle torque over the radius, as shares of the load, and the sinkage."""
    x, _, resistance, rolling, z = bekker(ground, tyre, load_n, slip, 0.0)
    return (x - resistance) / load_n, (x + rolling) / load_n, z


@pytest.mark.parametrize("name", SOILS)
@pytest.mark.parametrize("load_n", LOADS_N)
@pytest.mark.parametrize("slip", [-0.3, -0.05, 0.0, 0.05, 0.2, 0.5, 0.9])
@pytest.mark.parametrize("slip_sinkage", [0.0, 1.0])
def test_pull_torque_and_sinkage_are_those_of_the_arc(name, load_n, slip, slip_sinkage):
    """Few points and iterations against adaptive quadrature and a bracketed root."""
    ground = sinking(*SOILS[name], slip_sinkage=slip_sinkage)
    arc = Arc(ground, slip)
    z = arc.sinkage_m(load_n)
    exact = arc.pull_n(z) / load_n, arc.torque_n(z) / load_n, z
    near = 2e-4 if slip >= 0.0 else 2e-3
    found = pull_torque_sinkage(ground, rigid_wheel(), load_n, slip)
    assert found[:2] == pytest.approx(exact[:2], abs=near)
    assert found[2] == pytest.approx(exact[2], rel=near)


@pytest.mark.parametrize("slip", [0.0, 0.2])
def test_bekkers_own_stress_without_a_shifted_peak(slip):
    ground = sinking(*SOILS["C"], peak=0.0, peak_slip=0.0)
    arc = Arc(ground, slip)
    z = arc.sinkage_m(5e3)
    exact = arc.pull_n(z) / 5e3, arc.torque_n(z) / 5e3, z
    assert pull_torque_sinkage(ground, rigid_wheel(), 5e3, slip) == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("n", [0.2, 0.5, 1.0, 1.3])
def test_a_wheel_without_shear_sinks_and_drags_as_bekker_says(n):
    """z = (W / (b k C sqrt(D)))**(2 / (2 n + 1)) and R = b k z**(n + 1) / (n + 1).

    On a flat arc C is the integral of (1 - x**2)**n over [0, 1], a beta function; Bekker's
    (3 - n) / 3 is its first-order form. The resistance is exact at whatever sinkage there is.
    """
    ground = sinking(0.0, 40e3, n, 0.0, 0.0, 0.02, peak=0.0, peak_slip=0.0)
    _, _, resistance, rolling, z = bekker(ground, rigid_wheel(), 1e3, 0.0, 0.0)
    assert z == pytest.approx(Arc(ground, 0.0).sinkage_m(1e3), rel=2e-4)
    for mean, near in ((0.5 * beta(0.5, n + 1.0), 0.01), ((3.0 - n) / 3.0, 0.08)):
        flat = (1e3 / (0.3 * 40e6 * mean * math.sqrt(0.9))) ** (2.0 / (2.0 * n + 1.0))
        assert z == pytest.approx(flat, rel=near)
    assert rolling == pytest.approx(0.0, abs=1e-9)
    assert resistance == pytest.approx(0.3 * 40e6 * z ** (n + 1.0) / (n + 1.0), rel=1e-3)


@pytest.mark.parametrize("name", SOILS)
@pytest.mark.parametrize("load_n", LOADS_N)
def test_a_towed_wheel_skids_and_drags_as_the_arc_says(name, load_n):
    ground = sinking(*SOILS[name])

    def arc_torque(slip):
        arc = Arc(ground, slip)
        return arc.torque_n(arc.sinkage_m(load_n))

    skid = brentq(arc_torque, -0.5, 0.0, xtol=1e-6)
    arc = Arc(ground, skid)
    pull, torque, z = pull_torque_sinkage(ground, rigid_wheel(), load_n, skid)
    assert torque == pytest.approx(0.0, abs=5e-4)
    assert z == pytest.approx(arc.sinkage_m(load_n), rel=1e-3)
    assert pull * load_n == pytest.approx(arc.pull_n(arc.sinkage_m(load_n)), rel=5e-3)


@pytest.mark.parametrize("name", SOILS)
def test_gross_shear_tends_to_the_soils_strength(name):
    """c A + tan(phi) times the normal stress' integral, which is N while the arc is short."""
    k_c, k_phi, n, c, phi, _ = SOILS[name]
    stiff = sinking(k_c, 100.0 * k_phi, n, c, phi, 1e-5)
    x, _, _, rolling, z = bekker(stiff, rigid_wheel(), 2e3, 1.0, 0.0)
    area = 0.3 * 0.45 * math.acos(1.0 - z / 0.45)
    strength = 1e3 * c * area + 2e3 * math.tan(math.radians(phi))
    assert x + rolling == pytest.approx(strength, rel=0.02)
    soft = sinking(k_c, k_phi, n, c, phi, 1e-5)
    x, _, _, rolling, z = bekker(soft, rigid_wheel(), 5e3, 1.0, 0.0)
    assert x + rolling == pytest.approx(Arc(soft, 1.0).strength_n(z), rel=2e-3)


@st.composite
def grounds(draw):
    """Soils over the permitted range, stiff enough to carry the load."""
    n = draw(st.floats(0.1, 1.6))
    at_10_cm_kpa = draw(st.floats(100.0, 3000.0))
    return sinking(
        draw(st.floats(0.0, 100.0)),
        at_10_cm_kpa / 0.1**n,
        n,
        draw(st.floats(0.0, 150.0)),
        draw(st.floats(0.0, 50.0)),
        draw(st.floats(0.002, 0.2)),
        shear_lat_m=draw(st.floats(0.002, 0.2)),
        unit_weight_npm3=draw(st.floats(0.0, 25e3)),
        peak=draw(st.one_of(st.just(0.0), st.floats(0.05, 0.8))),
        peak_slip=draw(st.one_of(st.just(0.0), st.floats(0.05, 0.5))),
        slip_sinkage=draw(st.one_of(st.just(0.0), st.floats(0.1, 5.0))),
    )


SLIP = st.floats(-1.5, 1.5)
WHEELS = st.sampled_from([rigid_wheel(), wheel()])


@settings(max_examples=400, deadline=None)
@given(grounds(), WHEELS, st.floats(100.0, 20e3), SLIP, SLIP)
def test_the_shear_dissipates_is_odd_and_mirrors_left_and_right(ground, tyre, load, slip, side):
    x, y, *rest = bekker(ground, tyre, load, slip, side)
    assert np.all(np.isfinite([x, y, *rest]))
    assert x * slip >= 0.0
    assert y * side >= 0.0
    assert rest[2] >= 0.0
    if abs(slip) <= 0.99:
        assert bekker(ground, tyre, load, -slip, -side)[:2] == (-x, -y)
    assert bekker(ground, tyre, load, slip, -side)[:2] == (x, -y)


@settings(max_examples=400, deadline=None)
@given(grounds(), WHEELS, st.floats(100.0, 20e3), st.floats(-1.0, 1.0), SLIP)
def test_no_wheel_gets_power_from_the_soil(ground, tyre, load, slip, side):
    """T w - P v - F_y v_y >= 0, over the faster of w R and v."""
    x, y, resistance, rolling, _ = bekker(ground, tyre, load, slip, side)
    spin, roll = min(1.0, 1.0 + slip), min(1.0, 1.0 - slip)
    assert x * slip + y * side + rolling * spin + resistance * roll >= -1e-9 * load


@settings(max_examples=200, deadline=None)
@given(grounds(), st.floats(100.0, 20e3), st.floats(0.0, 1.0), SLIP)
def test_the_shear_stays_within_the_strength_of_the_soil(ground, load, slip, side):
    """c A + tan(phi) times the integral of sigma at the law's own sinkage; bulldozing on top."""
    ground[Soil.PEAK_SLIP] = min(ground[Soil.PEAK_SLIP], 0.9 - ground[Soil.PEAK])
    x, y, *_, z = bekker(ground, rigid_wheel(), load, slip, side)
    y -= bulldozing_n(ground, rigid_wheel(), 0.0, z, drift(slip, side))
    if z < 0.85 * 0.45:  # below that the wheel is bogged, and what it lacks is added in proportion
        strength = Arc(ground, slip, side_slip=side).strength_n(z)
        assert math.hypot(x, y) <= 1.005 * strength + 1e-4 * load


@settings(max_examples=200, deadline=None)
@given(grounds(), WHEELS, st.floats(100.0, 20e3), SLIP)
def test_forces_pass_through_zero_slip_without_a_step(ground, tyre, load, side):
    """From a skid of 1e-9 to as much slip: 2e-9 of the longest contact, 2 m, over its modulus."""
    behind, ahead = (np.array(bekker(ground, tyre, load, s, side)) for s in (-1e-9, 1e-9))
    strength = 2.0 * load + ground[Soil.COHESION_PA]
    assert np.abs(ahead - behind)[:4].max() <= strength * 2e-9 * 2.0 / 0.002 + 1e-6 * load
    assert bekker(ground, tyre, load, 0.0, 0.0)[:2] == (0.0, 0.0)


@settings(deadline=None)
@given(grounds(), *(st.floats(-2.0, 2.0),) * 2, st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_a_wheel_rolling_backwards_is_one_rolling_forwards_seen_from_behind(
    ground, spin, roll, u_x, u_y
):
    once = relaxed_shear(ground, wheel(), 10e3, spin, roll, 0.0, (u_x, u_y, u_x, u_y), 0.002)
    back = relaxed_shear(ground, wheel(), 10e3, -spin, -roll, 0.0, (-u_x, -u_y, -u_x, -u_y), 0.002)
    if spin + roll != 0.0:
        assert back[:2] == pytest.approx([-f for f in once[:2]], abs=1e-9)
        assert back[2:5] == pytest.approx(once[2:5])


@settings(deadline=None)
@given(st.floats(-0.05, 0.05), st.floats(-0.1, 0.1))
def test_shear_is_continuous_through_standstill(u_x, u_y):
    """The spring of a parked tyre does not feel which way it is about to roll."""
    ground = sinking(*SOILS["C"])
    ahead, back = (
        relaxed_shear(ground, wheel(), 20e3, v, v, 0.0, (u_x, u_y, u_x, u_y), 0.002)
        for v in (1e-9, -1e-9)
    )
    assert ahead[:2] == pytest.approx(back[:2], abs=1e-3)


def test_the_lateral_force_of_a_rolling_wheel_is_janosis_integral():
    """Without slip: b r integral of strength (1 - exp(-r tan(alpha) (theta_1 - theta) / K))."""
    ground = sinking(102.0, 530.1e3, 0.793, 0.0, 31.1, 0.012, unit_weight_npm3=0.0)
    _, y, *_, z = bekker(ground, rigid_wheel(), 2e3, 0.0, 0.2)
    entry, arc = math.acos(1.0 - z / 0.45), Arc(ground, 0.0)
    exact = arc.integral(
        z, lambda t, _s, _t, strength: strength * -math.expm1(-0.45 * 0.2 * (entry - t) / 0.012)
    )
    assert y == pytest.approx(exact, rel=2e-3)


def test_bulldozing_is_rankines_pressure_on_the_sunk_side():
    """45 + phi/2 by its tangent, over the parabola z (1 - (x / X)**2), all of it called up."""
    ground, z = sinking(0.0, 1000.0, 1.0, 2.0, 30.0, 1e-6), 0.05
    q = math.tan(math.radians(60.0))
    reach = 0.45 * math.sin(math.acos(1.0 - z / 0.45))
    x = np.linspace(0.0, reach, 20001)
    depth = z * (1.0 - (x / reach) ** 2)
    line = 2.0 * 2e3 * depth * q + 0.5 * 15e3 * depth**2 * q**2
    exact = np.trapezoid(line, x)
    assert bulldozing_n(ground, rigid_wheel(), 0.0, z, 0.5) == pytest.approx(exact, rel=1e-4)
    assert bulldozing_n(ground, rigid_wheel(), 0.0, z, -0.5) == pytest.approx(-exact, rel=1e-4)


@pytest.mark.parametrize("tyre", [rigid_wheel(), wheel()])
@pytest.mark.parametrize(("slip", "side"), [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.5, 0.5)])
def test_a_slipping_wheel_sinks_as_much_deeper_as_lyasko_says(tyre, slip, side):
    """z = z_0 (1 + S s), s the size of the slip, where shear carries nothing."""
    ground = sinking(0.0, 1000.0, 0.9, 0.0, 0.0, 0.02, slip_sinkage=0.8, peak_slip=0.0)
    still, slipping = (
        bekker(ground, tyre, 2e3, s, s_y)[4] for s, s_y in ((0.0, 0.0), (slip, side))
    )
    assert slipping / still == pytest.approx(1.0 + 0.8 * math.hypot(slip, side), rel=0.02)


@pytest.mark.parametrize("slip", [0.0, 0.5, 0.9])
def test_a_wheel_bulldozes_by_its_path_however_fast_its_rim_turns(slip):
    """Soil without strength shears nothing; its weight resists as the slip angle alone says."""
    ground = sinking(0.0, 1000.0, 1.0, 0.0, 0.0, 0.02, peak_slip=0.0)
    _, y, *_, z = bekker(ground, rigid_wheel(), 5e3, slip, 0.3 * (1.0 - slip))
    assert drift(slip, 0.3 * (1.0 - slip)) == pytest.approx(0.3)
    assert y == pytest.approx(bulldozing_n(ground, rigid_wheel(), 0.0, z, 0.3), rel=1e-3)
    assert y > 0.0


@pytest.mark.parametrize("z", [0.001, 0.02, 0.1])
def test_the_larger_circle_has_the_flexible_tyres_contact_length(z):
    radius, entry = circle(wheel(), 0.05, z)
    length = math.sqrt(1.755 * (z + 0.05)) + math.sqrt(1.755 * 0.05)
    assert 2.0 * math.sqrt(2.0 * radius * z) / 2.0 == pytest.approx(length)
    assert radius * (1.0 - math.cos(entry)) == pytest.approx(z)
    assert circle(wheel(), 0.0, z) == pytest.approx((0.8775, math.acos(1.0 - z / 0.8775)))


def test_a_flexible_tyre_sinks_less_and_pulls_more_than_a_rigid_wheel_of_its_size():
    ground, tyre = sinking(*SOILS["A"]), wheel()
    stiff = tyre.copy()
    stiff[Wheel.STIFFNESS_NPM] = 1e9
    soft_pull, _, soft_z = pull_torque_sinkage(ground, tyre, 20e3, 0.2)
    hard_pull, _, hard_z = pull_torque_sinkage(ground, stiff, 20e3, 0.2)
    assert soft_z < hard_z
    assert soft_pull > hard_pull


def test_the_series_of_sine_and_cosine():
    angles = np.linspace(0.0, 1.5, 301)
    found = np.array([sine_cosine(a) for a in angles])
    assert found[:, 0] == pytest.approx(np.sin(angles), abs=1e-7)
    assert found[:, 1] == pytest.approx(np.cos(angles), abs=1e-7)
