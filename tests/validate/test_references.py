"""The references themselves, against figures in print and limits known by other means."""

import numpy as np
import pytest

from twin.scenario.soils import PRESETS
from twin.validate.arc import Arc
from twin.validate.brixius_forms import KINDS, free_wheel, gross, resistance, stiffness
from twin.validate.handling import Bicycle
from twin.validate.instruments import allan_deviation
from twin.validate.traction import NET, SLIPS

BICYCLE = Bicycle(
    mass_kg=5000.0, yaw_inertia_kgm2=6000.0, front_m=1.5, rear_m=1.1, front_npr=9e4, rear_npr=1.6e5,
    front_relaxation_m=0.6, rear_relaxation_m=0.7, front_drag_n=0.0, leaning_drag=0.0,
    cg_height_m=0.95,
)  # fmt: skip


@pytest.mark.parametrize(("kind", "bn"), NET)
def test_the_equations_give_the_published_table(kind, bn):
    tyre = KINDS[kind]
    net = gross(tyre, bn, SLIPS) - resistance(tyre, bn, SLIPS)
    np.testing.assert_allclose(net, NET[kind, bn], atol=0.0006)


def test_a_free_wheel_of_mobility_42_skids_and_drags_as_published():
    assert free_wheel(KINDS["bias"], 42.0) == pytest.approx((-0.006, 0.064), abs=0.0005)


def test_small_slip_stiffness_is_the_slope_of_the_law():
    tyre = KINDS["bias"]
    slope = (gross(tyre, 50.0, 1e-6) - gross(tyre, 50.0, -1e-6)) / 2e-6
    assert stiffness(tyre, 50.0) == pytest.approx(float(slope), rel=1e-5)


def test_the_simulated_bicycle_comes_to_the_textbooks_yaw_rate_and_slip_angle():
    dt_s, speed, steer = 0.001, 6.0, 0.01
    n = 20_000
    yaw = BICYCLE.yaw_rates_radps(np.full(n, speed), np.full(n, steer), dt_s)[-1]
    assert yaw == pytest.approx(BICYCLE.steady_yaw_rate_radps(speed, steer), rel=1e-6)
    # geometry: steer - L r / v is the difference of the slip angles, front less rear
    front = BICYCLE.mass_kg * speed * yaw * 1.1 / 2.6 / 9e4
    rear = BICYCLE.steady_rear_slip_rad(speed, yaw)
    assert steer - 2.6 * yaw / speed == pytest.approx(front - rear, rel=1e-6)


def test_the_arc_carries_its_load_by_bekkers_closed_form():
    """Without shear: R = b k z**(n + 1) / (n + 1), exact on any arc."""
    from dataclasses import replace

    sand = PRESETS["lete-sand"].deformable
    bare = replace(sand, cohesion_kpa=0.0, friction_angle_deg=0.0, stress_peak=0.0,
                   stress_peak_slip=0.0)  # fmt: skip
    z, n = 0.03, sand.sinkage_exponent
    k = 1e3 * (sand.k_c_kn_per_m_n1 / 0.3 + sand.k_phi_kn_per_m_n2)
    resistance_n = 0.3 * k * z ** (n + 1) / (n + 1)
    assert Arc(bare, 0.0, 0.45, 0.30).pull_n(z) == pytest.approx(-resistance_n, rel=1e-6)


def test_white_noise_has_the_allan_deviation_of_its_density():
    noise = np.random.default_rng(3).standard_normal(200_000) * 0.01 * np.sqrt(50.0)
    for tau_s in (0.2, 1.0, 4.0):
        assert allan_deviation(noise, tau_s, 50.0) == pytest.approx(0.01 / tau_s**0.5, rel=0.05)
