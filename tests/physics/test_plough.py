"""The plough's draft against ASABE D497, and the senses, shares and statistics of its forces."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import welch
from scipy.stats import binom

from tests.physics.blocks import level, plough, soil
from twin.physics.block import Plough
from twin.physics.plough import (
    depth_wheel_force,
    draft_factor,
    draft_n,
    rock_n,
    share_force,
    soil_before,
)

UP = (0.0, 0.0, 1.0)
STIFFNESS_NPM = 500e3
DRAFT_N, SIDE_N = 6e3, 0.25 * 6e3
RATIOS = (0.2, 0.25)
"""Of the vertical and the side force over the draft."""


@pytest.mark.parametrize(
    ("scale", "depth_m", "kmh", "kn"),
    [
        (1.00, 0.15, 6.48, 18.2), (1.00, 0.30, 5.04, 32.8),
        (0.70, 0.20, 5.83, 16.2), (0.70, 0.25, 5.44, 19.7), (0.45, 0.15, 6.48, 8.2),
    ],
)  # fmt: skip
def test_draft_of_the_four_bodies_at_the_published_depths_and_speeds(scale, depth_m, kmh, kn):
    one = draft_n(plough(), scale, depth_m, kmh / 3.6)
    assert 4.0 * one / 1e3 == pytest.approx(kn, abs=0.06)


def test_draft_is_the_closed_form():
    d = draft_n(plough(), 0.85, 0.25, 1.5)
    assert d == pytest.approx(0.85 * (652.0 + 5.1 * (3.6 * 1.5) ** 2) * 0.35 * 25.0)


def steady(velocity, draft=DRAFT_N, dt_s=0.002):
    """How far the soil is pressed after a metre at a velocity ahead and towards the land."""
    pressed = (0.0, 0.0)
    for _ in range(round(1.0 / math.hypot(*velocity) / dt_s)):
        pressed = soil_before(STIFFNESS_NPM, draft, pressed, velocity, dt_s)
    return pressed


def force_of(velocity, draft=DRAFT_N):
    return share_force(plough(), draft, RATIOS, steady(velocity, draft), (*velocity, 0.0))


def test_a_share_is_pulled_back_and_down_by_the_ratios_and_its_side_force_is_borne():
    """Without drift the landside takes all of the mould-board's side force."""
    force, landside = force_of((1.5, 0.0))
    assert force == pytest.approx((-DRAFT_N, 0.0, -0.2 * DRAFT_N), rel=1e-3, abs=1e-9)
    assert landside == pytest.approx(SIDE_N, rel=1e-3)


@pytest.mark.parametrize("dt_s", [0.0005, 0.002])
def test_the_draft_is_reached_over_the_way_in_which_the_soil_fails(dt_s):
    """63 % of it after D / k, 12 mm, at any speed and step; a standing plough keeps its force."""
    for speed in (0.02, 0.2, 1.5):
        steps = round(DRAFT_N / STIFFNESS_NPM / speed / dt_s)
        if steps < 3:
            continue
        pressed = (0.0, 0.0)
        for _ in range(steps):
            pressed = soil_before(STIFFNESS_NPM, DRAFT_N, pressed, (speed, 0.0), dt_s)
        share = STIFFNESS_NPM * pressed[0] / DRAFT_N
        assert share == pytest.approx(1.0 - math.exp(-1.0), rel=2.0 / steps)
        assert soil_before(STIFFNESS_NPM, DRAFT_N, pressed, (0.0, 0.0), dt_s) == pressed


@given(*(st.floats(-3.0, 3.0),) * 2, *(st.floats(-0.03, 0.03),) * 2, st.floats(1e-3, 2e4))
def test_pressed_soil_returns_no_more_than_it_was_given(ahead, aside, x, y, draft):
    """k x . v >= d(k x**2 / 2)/dt at the step's end, whatever it was pressed before."""
    after = soil_before(STIFFNESS_NPM, draft, (x, y), (ahead, aside), 0.002)
    given_j = STIFFNESS_NPM * 0.002 * (after[0] * ahead + after[1] * aside)
    held_j = 0.5 * STIFFNESS_NPM * (np.square(after).sum() - x * x - y * y)
    assert given_j >= held_j - 1e-9 * max(1.0, abs(held_j))


def test_soil_forces_oppose_motion_in_every_direction():
    """Sinking and rising too: the share draws itself down no faster than it goes ahead."""
    rng = np.random.default_rng(0)
    for _ in range(300):
        velocity = rng.normal(size=3) * (1.0, 1.0, 3.0)
        force, _ = share_force(
            plough(), DRAFT_N, RATIOS, steady(tuple(velocity[:2])), tuple(velocity)
        )
        assert np.dot(force, velocity) <= 0.0


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_the_landside_pushes_within_its_range(ahead, aside):
    if math.hypot(ahead, aside) > 0.01:
        _, landside = force_of((ahead, aside))
        assert 0.0 <= landside <= 3.0 * SIDE_N * (1.0 + 1e-9)


def test_the_side_force_is_balanced_by_the_landside_and_restores():
    """Sideways there is S towards the land less N, and draft's own part; N doubles in 0.03 rad."""
    for drift in (-0.1, -0.03, -0.015, 0.0, 0.015, 0.03, 0.06, 0.2):
        force, landside = force_of((1.5 * math.cos(drift), 1.5 * math.sin(drift)))
        side = SIDE_N * math.cos(drift)
        sideways = force[1] + DRAFT_N * math.sin(drift)
        assert sideways == pytest.approx(side - landside, rel=1e-3, abs=4.0)
        expected = side * min(3.0, max(0.0, 1.0 + math.sin(drift) / 0.03))
        assert landside == pytest.approx(expected, rel=1e-3, abs=1e-9)
        assert sideways * drift <= 0.0


def test_a_plough_that_has_not_moved_is_not_pulled_at_all():
    force, landside = share_force(plough(), DRAFT_N, RATIOS, (0.0, 0.0), (0.0, 0.0, 0.0))
    assert np.all(np.array(force) == 0.0)
    assert landside == 0.0


def factors(ground, field, s_m, t_m=0.0, depth_m=0.25):
    return np.array([draft_factor(field, ground, s, t_m, depth_m) for s in s_m])


def test_draft_varies_with_place_and_not_with_time():
    varied = soil(draft_cv=0.12)
    s = np.arange(0.0, 4000.0, 0.5)
    along = factors(varied, level(), s)
    assert along.mean() == pytest.approx(1.0, rel=0.02)
    assert along.std() == pytest.approx(0.12, rel=0.06)
    assert draft_factor(level(), varied, 7.0, 0.0, 0.25) == along[14]
    assert not np.array_equal(along, factors(varied, level(seed=2.0), s))
    # a simulation that stands elsewhere on the same field finds what lies there
    assert np.array_equal(factors(varied, level(origin_s_m=100.0), s[:100]), along[200:300])
    aside = factors(varied, level(origin_t_m=30.0), s)
    assert np.array_equal(aside, factors(varied, level(), s, t_m=30.0))
    assert abs(np.corrcoef(aside, along)[0, 1]) < 0.15


@pytest.mark.parametrize("depth_m", [0.15, 0.25, 0.30])
def test_the_ripple_has_a_wave_of_three_quarters_of_the_depth(depth_m):
    """At 1.5 m/s the peak of its spectrum is at v / (0.75 depth), and its sd is as set."""
    speed_mps, rate_hz = 1.5, 400.0
    s = np.arange(0.0, 1200.0, speed_mps / rate_hz)
    rippled = factors(soil(ripple_cv=0.08), level(), s, depth_m=depth_m)
    assert rippled.mean() == pytest.approx(1.0, abs=1e-3)
    assert rippled.std() == pytest.approx(0.08, rel=0.01)
    frequency, density = welch(rippled, rate_hz, nperseg=8192)
    peak_hz = frequency[np.argmax(density)]
    assert peak_hz == pytest.approx(speed_mps / (0.75 * depth_m), rel=0.1)
    assert 3.0 < peak_hz < 15.0
    narrow = np.abs(frequency - peak_hz) < 0.35 * peak_hz
    assert density[narrow].sum() > 0.8 * density.sum()


def test_neighbouring_soil_never_pushes_the_plough():
    wild = soil(draft_cv=0.5, ripple_cv=0.5)
    along = factors(wild, level(), np.arange(0.0, 500.0, 0.01))
    assert along.min() == pytest.approx(0.1)


def rock_force(ground, field, s_m, share, width_m=0.35):
    return np.array([rock_n(field, ground, s, 0.0, share, width_m) for s in s_m])


def pulses(force):
    """How many separate pulses a force has."""
    return int(np.sum((force[1:] > 0.0) & (force[:-1] == 0.0)))


def test_a_rock_pulls_its_force_for_a_quarter_of_a_metre():
    rocky = soil(rocks_per_m2=0.1, rock_n=15e3)
    s = np.arange(0.0, 400.0, 1e-3)
    force = rock_force(rocky, level(), s, 0)
    starts = np.flatnonzero((force[1:] > 0.0) & (force[:-1] == 0.0))
    assert len(starts) >= 5
    for i in starts[:-1]:
        pulse = force[i : i + 300]
        assert pulse.max() == pytest.approx(15e3, rel=1e-3)
        assert np.count_nonzero(pulse) == pytest.approx(250, abs=1)
        x = np.arange(1, 250) / 250.0
        assert pulse[1:250] == pytest.approx(15e3 * np.sin(np.pi * x) ** 2, abs=250.0)
        assert pulse.sum() * 1e-3 == pytest.approx(0.5 * 15e3 * 0.25, rel=1e-3)
    assert np.array_equal(rock_force(rocky, level(), s[::100], 0), force[::100])
    assert not np.array_equal(rock_force(rocky, level(), s[::10], 1), force[::10])
    assert np.all(rock_force(soil(rock_n=15e3), level(), s[::100], 0) == 0.0)


@pytest.mark.parametrize("width_m", [0.35, 0.5])
def test_rocks_are_as_many_as_their_density_says(width_m):
    """Four shares for 200 m, two in 100 m2: binomial, 80 cells of 10 m times the body's width."""
    rocky = soil(rocks_per_m2=0.02, rock_n=15e3)
    s = np.arange(0.0, 200.0, 0.05)
    counts = []
    for seed in range(60):
        ground = level(seed=float(seed))
        counts.append(
            sum(pulses(rock_force(rocky, ground, s, share, width_m)) for share in range(4))
        )
    expected = binom(80, 0.02 * 10.0 * width_m)
    assert expected.mean() == pytest.approx(0.02 * 4 * 200.0 * width_m)
    error = expected.std() / math.sqrt(len(counts))
    assert np.mean(counts) == pytest.approx(expected.mean(), abs=3.5 * error)
    assert np.var(counts) == pytest.approx(expected.var(), rel=0.6)


def test_the_depth_wheel_damps_its_spring_and_drags_a_tenth_of_its_load():
    p, spring = plough(), (0.0, 0.0, 6e3)
    pressing, drag, load = depth_wheel_force(p, spring, (1.5, 0.0, 0.0), UP)
    assert load == 6e3
    assert pressing == (0.0, 0.0, load)
    assert drag == pytest.approx((-0.1 * load, 0.0, 0.0), rel=1e-3)
    sinking = depth_wheel_force(p, spring, (1.5, 0.0, -0.1), UP)[2]
    assert sinking - load == pytest.approx(0.1 * p[Plough.WHEEL_DAMPING_NSPM])
    lifted = depth_wheel_force(p, (0.0, 0.0, 0.0), (1.5, 0.0, 0.0), UP)
    leaving = depth_wheel_force(p, (0.0, 0.0, 1.2e3), (1.5, 0.0, 1.0), UP)
    assert lifted == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0) == leaving
