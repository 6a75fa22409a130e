"""The friction element: a spring below its capacity, sliding at it."""

import numpy as np
import pytest

from tests.physics.blocks import element
from twin.physics.coupling import twist

DT_S, CAPACITY_NM, TWIST_RAD = 0.002, 15e3, 0.01


def turn(rates_radps, *, applied=1.0, u=0.0):
    """Torques while the two sides turn against each other."""
    torques = []
    for rate in rates_radps:
        torque, change = twist(element(), applied, u, rate, DT_S)
        u += DT_S * change
        torques.append(torque)
    return np.array(torques), u


def test_below_capacity_it_is_a_spring():
    torques, u = turn([*[0.5 * TWIST_RAD / 0.1] * 50, 0.0])  # half the twist in 0.1 s, then still
    assert u == pytest.approx(0.5)
    assert torques[-1] == pytest.approx(0.5 * CAPACITY_NM)


def test_at_capacity_it_slides_and_holds_its_torque():
    torques, u = turn([1.0] * 500)
    assert u == pytest.approx(1.0)
    assert np.all(torques[20:] == CAPACITY_NM)
    back, _ = turn([-1.0] * 500, u=u)
    assert back[-1] == -CAPACITY_NM
    assert np.all(np.abs(back) <= CAPACITY_NM)


def test_it_holds_without_creeping():
    """A wheel of 95 kg m2 under half the capacity comes to rest and stays for a minute."""
    rate, angle, u, angles = 0.0, 0.0, 0.0, []
    for _ in range(round(65.0 / DT_S)):
        torque, change = twist(element(), 1.0, u, rate, DT_S)
        rate += DT_S * (0.5 * CAPACITY_NM - torque) / 95.0
        angle += DT_S * rate
        u += DT_S * change
        angles.append(angle)
    settled = np.array(angles[round(5.0 / DT_S) :])
    assert np.ptp(settled) < 1e-9
    assert settled[-1] == pytest.approx(0.5 * TWIST_RAD, rel=1e-3)


def test_released_it_passes_nothing_and_forgets():
    torques, u = turn([1.0] * 500, applied=0.0, u=1.0)
    assert np.all(torques == 0.0)
    assert abs(u) < 1e-4  # 1 s of a release in 0.1 s


def test_half_applied_it_carries_half():
    torques, _ = turn([1.0] * 200, applied=0.5)
    assert torques[-1] == 0.5 * CAPACITY_NM


def test_turning_to_and_fro_loses_energy():
    rates = 0.3 * np.cos(np.linspace(0.0, 8.0 * np.pi, 4000))
    torques, _ = turn(rates)
    assert torques @ rates > 0.0
