"""The plough's draft against ASABE D497, and the senses of its forces."""

import numpy as np
import pytest

from tests.physics.blocks import level, plough, soil
from twin.physics.block import Plough
from twin.physics.plough import depth_wheel_force, draft_n, share_force

UP, LEFT = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("scale", "depth_m", "kmh", "kn"),
    [
        (1.00, 0.15, 6.48, 18.2), (1.00, 0.30, 5.04, 32.8),
        (0.70, 0.20, 5.83, 16.2), (0.70, 0.25, 5.44, 19.7), (0.45, 0.15, 6.48, 8.2),
    ],
)  # fmt: skip
def test_draft_of_the_four_bodies_at_the_published_depths_and_speeds(scale, depth_m, kmh, kn):
    one = draft_n(plough(), soil(draft_scale=scale), depth_m, kmh / 3.6)
    assert 4.0 * one / 1e3 == pytest.approx(kn, abs=0.06)


def test_draft_is_the_closed_form():
    d = draft_n(plough(), soil(), 0.25, 1.5)
    assert d == pytest.approx(0.85 * (652.0 + 5.1 * (3.6 * 1.5) ** 2) * 0.35 * 25.0)


def test_a_share_is_pulled_back_and_down_by_the_ratios():
    force, depth = share_force(
        level(), soil(), plough(), (3.0, 1.0, -0.25), (1.5, 0.0, 0.0), UP, LEFT
    )
    draft = draft_n(plough(), soil(), 0.25, 1.5)
    assert depth == 0.25
    assert force == pytest.approx((-draft, 0.0, -0.2 * draft), rel=1e-3)


def test_a_share_above_ground_feels_nothing():
    force, depth = share_force(
        level(), soil(), plough(), (0.0, 0.0, 0.01), (1.5, 0.3, -1.0), UP, LEFT
    )
    assert force == (0.0, 0.0, 0.0)
    assert depth == 0.0


def test_soil_forces_oppose_motion_in_every_direction():
    rng = np.random.default_rng(0)
    for _ in range(200):
        velocity = np.append(rng.normal(size=2), 0.0)
        force, _ = share_force(
            level(), soil(), plough(), (0.0, 0.0, -0.2), tuple(velocity), UP, LEFT
        )
        assert np.dot(force, velocity) < 0.0


def test_the_landside_bears_up_to_its_ratio_against_drift():
    draft = draft_n(plough(), soil(), 0.25, 1.5)
    for drift in (0.05, -0.05, 0.3):
        velocity = (1.5 * np.cos(drift), 1.5 * np.sin(drift), 0.0)
        force, _ = share_force(level(), soil(), plough(), (0.0, 0.0, -0.25), velocity, UP, LEFT)
        landside = force[1] + draft * np.sin(drift)
        assert landside * drift < 0.0
        assert abs(landside) <= 0.3 * draft


def test_draft_varies_with_place_and_not_with_time():
    varied = soil(draft_cv=0.12)
    at = [
        share_force(level(), varied, plough(), (x, 0.0, -0.25), (1.5, 0.0, 0.0), UP, LEFT)[0][0]
        for x in np.arange(0.0, 4000.0, 0.5)
    ]
    steady = draft_n(plough(), soil(), 0.25, 1.5)
    assert -np.mean(at) == pytest.approx(steady, rel=0.02)
    assert np.std(at) / steady == pytest.approx(0.12, rel=0.06)
    again = share_force(level(), varied, plough(), (7.0, 0.0, -0.25), (1.5, 0.0, 0.0), UP, LEFT)
    assert again[0][0] == at[14]


def test_the_depth_wheel_is_a_spring_and_drags_a_tenth_of_its_load():
    p = plough()
    force, load = depth_wheel_force(p, (0.0, 0.0, 0.25), (1.5, 0.0, 0.0), UP)
    assert load == pytest.approx(0.05 * p[Plough.WHEEL_STIFFNESS_NPM])
    assert force == pytest.approx((-0.1 * load, 0.0, load), rel=1e-3)
    lifted = depth_wheel_force(p, (0.0, 0.0, 0.31), (1.5, 0.0, 0.0), UP)
    leaving = depth_wheel_force(p, (0.0, 0.0, 0.29), (1.5, 0.0, 1.0), UP)
    assert lifted == ((0.0, 0.0, 0.0), 0.0) == leaving
