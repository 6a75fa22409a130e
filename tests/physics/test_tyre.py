"""The relaxing tyre: its steady state is the law, its deflection a spring at rest."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.physics.blocks import soil, wheel
from twin.physics.brixius import brixius
from twin.physics.tyre import relaxed_shear

W, DT_S = 21.7e3, 0.002


def settle(spin, roll, side, *, u=(0.0, 0.0), duration_s=20.0):
    """Forces over time of a tyre at constant speeds, deflections integrated as MuJoCo does."""
    forces = []
    for _ in range(round(duration_s / DT_S)):
        x, y, *_, rate_x, rate_y = relaxed_shear(
            soil(), wheel(), W, spin, roll, side, u[0], u[1], DT_S
        )
        u = (u[0] + DT_S * rate_x, u[1] + DT_S * rate_y)
        forces.append((x, y))
    return np.array(forces), u


@pytest.mark.parametrize(
    ("spin", "roll", "side"),
    [(1.7, 1.5, 0.0), (1.5, 1.5, 0.1), (1.8, 1.5, -0.2), (1.2, 1.5, 0.0), (-1.0, -0.8, 0.05)],
)
def test_steady_rolling_is_the_law_at_the_defined_slip(spin, roll, side):
    largest = max(abs(spin), abs(roll))
    law = brixius(soil(), wheel(), W, (spin - roll) / largest, -side / largest)
    forces, _ = settle(spin, roll, side)
    assert forces[-1] == pytest.approx(law[:2], rel=1e-6)


def test_the_force_builds_up_over_the_relaxation_length():
    """63 % of the steady slip after the wheel has rolled one relaxation length, 0.2 m."""
    slip = 1e-4
    forces, _ = settle(1.0, 1.0 - slip, 0.0)
    at = round(0.2 / DT_S)
    # 1 - 1/e of the law's force, and of the damper, 0.2 s of load, what is still to come: 1/e
    stiffness = 7.5 * 0.88 * (1.0 - math.exp(-0.1 * 42.0))
    built = 1.0 - math.exp(-1.0) + 0.2 / stiffness / 0.2 * math.exp(-1.0)
    assert forces[at, 0] / forces[-1, 0] == pytest.approx(built, rel=0.01)


def test_a_standing_wheel_is_a_spring():
    """It keeps its force for ever, as a pushed parked wheel does."""
    u = (0.003, -0.004)
    forces, after = settle(0.0, 0.0, 0.0, u=u, duration_s=60.0)
    assert after == u
    assert np.all(forces == forces[0])
    assert forces[0, 0] > 0.0 > forces[0, 1]


@given(*(st.floats(-3.0, 3.0),) * 3, st.floats(-0.2, 0.2), st.floats(-0.7, 0.7))
def test_no_motion_and_no_deflection_exceeds_the_friction(spin, roll, side, u_x, u_y):
    x, y, *_ = relaxed_shear(soil(), wheel(), W, spin, roll, side, u_x, u_y, DT_S)
    assert math.hypot(x, y) <= 0.88 * W * (1.0 + 1e-12)


@given(st.floats(0.5, 3.0), st.floats(0.5, 3.0), st.floats(-0.5, 0.5))
def test_steady_shear_takes_energy_out_of_the_motion(spin, roll, side):
    forces, _ = settle(spin, roll, side, duration_s=3.0)
    sliding_x, sliding_y = roll - spin, side
    assert forces[-1] @ [sliding_x, sliding_y] <= 0.0


def test_pushing_a_standing_wheel_to_and_fro_creates_no_energy():
    """Work of the shear over closed cycles of displacement, small to sliding, is a loss."""
    for amplitude_m in (1e-4, 0.01, 0.3):
        u, work = (0.0, 0.0), 0.0
        for k in range(4000):
            side = amplitude_m * math.pi * math.cos(math.pi * k * DT_S)  # of 2 s, twice and twice
            _, y, *_, rate_x, rate_y = relaxed_shear(
                soil(), wheel(), W, 0.0, 0.0, side, u[0], u[1], DT_S
            )
            u = (u[0] + DT_S * rate_x, u[1] + DT_S * rate_y)
            work += y * side * DT_S
        assert work < 0.0
