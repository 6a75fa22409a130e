"""The ground: random fields of unit variance by place and seed, roughness, furrow, patches."""

import math

import numpy as np
import pytest
from numba import njit
from scipy.signal import welch

from tests.physics.blocks import furrowed, level, soil
from twin.physics.block import Field, Soil
from twin.physics.ground import furrow, node_value, random_field, roughness, soil_at, surface


@njit
def along(seed, x, y, length_m):
    out = np.empty(len(x))
    for i in range(len(x)):
        out[i] = random_field(seed, x[i], y[i], length_m)
    return out


@njit
def over_seeds(n, x, y, length_m):
    out = np.empty(n)
    for seed in range(n):
        out[seed] = random_field(float(seed), x, y, length_m)
    return out


@pytest.mark.parametrize("place", [(0.0, 0.0), (2.0, 2.0), (1.0, -3.3), (-517.9, 3.7)])
def test_mean_zero_and_variance_one_at_every_place(place):
    """On the nodes, between them and behind the origin; over 40 000 seeds."""
    values = over_seeds(40_000, *place, 4.0)
    assert values.mean() == pytest.approx(0.0, abs=4.0 / 200.0)  # 4 standard errors
    assert values.var() == pytest.approx(1.0, abs=0.04)


def test_the_same_place_is_the_same_and_another_seed_is_not():
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-300.0, 300.0, (2, 500))
    first = along(7.0, x, y, 4.0)
    shuffled = rng.permutation(500)
    assert np.array_equal(along(7.0, x[shuffled], y[shuffled], 4.0), first[shuffled])
    assert abs(np.corrcoef(first, along(8.0, x, y, 4.0))[0, 1]) < 0.15


def test_it_is_continuous_across_lattice_lines():
    for x in (0.0, 4.0, -8.0, 1.234):
        for y in (0.0, -4.0, 2.5):
            here = random_field(3.0, x, y, 4.0)
            for dx, dy in [(1e-6, 0.0), (-1e-6, 0.0), (0.0, 1e-6), (0.0, -1e-6)]:
                assert random_field(3.0, x + dx, y + dy, 4.0) == pytest.approx(here, abs=1e-5)


@pytest.mark.parametrize("length_m", [1.0, 4.0])
def test_values_are_independent_beyond_twice_the_length_and_alike_within_a_quarter(length_m):
    x = np.arange(0.0, 6000.0 * length_m, 0.25 * length_m)
    for axis in (0, 1):
        places = (x, np.full_like(x, 0.3)) if axis == 0 else (np.full_like(x, 0.3), x)
        f = along(11.0, *places, length_m)
        assert np.mean(f[1:] * f[:-1]) > 0.85
        assert abs(np.mean(f[8:] * f[:-8])) < 0.05
        half = np.mean(f[2:] * f[:-2]), np.mean(f[4:] * f[:-4])
        assert half[0] > 0.5 > half[1]  # correlation falls through one half within a length


def test_neighbouring_nodes_and_seeds_share_nothing():
    nodes = np.array([[node_value(2.0, i, j) for i in range(-150, 150)] for j in range(-150, 150)])
    other = np.array([[node_value(3.0, i, j) for i in range(-150, 150)] for j in range(-150, 150)])
    for a, b in [(nodes[:, 1:], nodes[:, :-1]), (nodes[1:], nodes[:-1]), (nodes, other)]:
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4.0 / 300.0
    assert np.abs(nodes).max() <= np.sqrt(3.0)


@njit
def heights(field, s, t):
    out = np.empty((len(s), 3))
    for i in range(len(s)):
        out[i] = roughness(field, s[i], t[i])
    return out


def rough(density_m3=1024e-6, **own):
    """Ground of ISO 8608's class D unless told: G_d at 0.1 cycles/m."""
    return level(roughness_m=0.1 * math.sqrt(density_m3), **own)


@pytest.mark.parametrize("along", [True, False], ids=["along", "across"])
def test_roughness_has_iso_8608s_spectrum(along):
    """G_d(n) = G_d(0.1) (n / 0.1)**-2 on a line of 40 km, a fifth off at most per third octave.

    ISO's classes are a factor of 2 to either side of their means.
    """
    step_m = 0.1
    line = np.arange(0.0, 40e3, step_m)
    density = 0.0
    for offset in np.arange(8) * 37.3:
        aside = np.full_like(line, offset)
        places = (line, aside) if along else (aside, line)
        n, one = welch(heights(rough(), *places)[:, 0], 1.0 / step_m, nperseg=4096, detrend=False)
        density = density + one / 8.0
    for low in 0.08 * 2.0 ** (np.arange(10) / 3.0):
        band = (n >= low) & (n < low * 2.0 ** (1.0 / 3.0))
        wanted = 1024e-6 * (n[band] / 0.1) ** -2.0
        assert density[band].mean() == pytest.approx(wanted.mean(), rel=0.2), low
    assert density[n > 3.0].max() < 0.1 * 1024e-6 * 30.0**-2.0  # nothing under the contact


def test_a_class_is_four_times_the_one_below_and_smooth_is_flat():
    s, t = np.random.default_rng(6).uniform(-200.0, 200.0, (2, 300))
    assert heights(rough(4096e-6), s, t) == pytest.approx(2.0 * heights(rough(), s, t))
    assert np.all(heights(level(), s, t) == 0.0)


def test_slopes_of_the_rough_ground_are_those_of_its_heights():
    s, t = np.random.default_rng(7).uniform(-200.0, 200.0, (2, 300))
    step = 1e-5
    field = rough()
    found = heights(field, s, t)
    for axis, (ds, dt) in enumerate([(step, 0.0), (0.0, step)], start=1):
        difference = heights(field, s + ds, t + dt)[:, 0] - heights(field, s - ds, t - dt)[:, 0]
        assert found[:, axis] == pytest.approx(difference / (2.0 * step), abs=1e-7)
    assert found[:, 1].std() > 0.01


def test_the_rough_ground_is_a_function_of_place_on_the_field():
    s, t = np.random.default_rng(8).uniform(-50.0, 50.0, (2, 50))
    moved = heights(rough(origin_s_m=30.0, origin_t_m=-7.0), s, t)
    assert moved == pytest.approx(heights(rough(), s + 30.0, t - 7.0), abs=1e-12)
    assert not np.allclose(heights(rough(seed=2.0), s, t), heights(rough(), s, t))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_furrow_lies_beyond_its_edge_and_gets_its_depth_on_a_ramp(side):
    field = furrowed(side)
    assert furrow(field, 20.0, side * 0.65) == (0.0, 0.0)
    assert furrow(field, 20.0, -side * 0.9) == (0.0, 0.0)  # the land
    assert furrow(field, 20.0, side * 0.9) == (-0.25, 0.0)
    assert furrow(field, 20.0, side * 0.70) == pytest.approx((-0.125, 0.0))  # on the wall
    assert furrow(field, 9.99, side * 0.9) == (0.0, 0.0)
    assert furrow(field, 11.5, side * 0.9) == pytest.approx((-0.125, -0.25 * 1.5 / 3.0))
    depths = [-furrow(field, s, side * 0.9)[0] for s in np.linspace(9.0, 14.0, 501)]
    assert np.all(np.diff(depths) >= 0.0)
    assert np.abs(np.diff(depths, 2)).max() < 2e-5 + 0.25 * 6.0 / 9.0 * 0.01**2  # no kink
    assert furrow(level(), 20.0, 0.9) == (0.0, 0.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_surface_is_the_sum_and_so_are_its_slopes(side):
    """Finite differences over roughness and furrow ramp, off the wall and its foot."""
    shape = furrowed(side, roughness_m=0.1 * math.sqrt(1024e-6))
    rng = np.random.default_rng(9)
    step = 1e-6
    places = [*zip(rng.uniform(9.0, 15.0, 200), side * rng.uniform(0.76, 1.4, 200), strict=True)]
    places += [*zip(rng.uniform(9.0, 15.0, 50), side * rng.uniform(-2.0, 0.64, 50), strict=True)]
    for s, t in places:
        height, slope_s, slope_t = surface(shape, s, t)
        assert height == roughness(shape, s, t)[0] + furrow(shape, s, t)[0]
        for slope, (ds, dt) in ((slope_s, (step, 0.0)), (slope_t, (0.0, step))):
            ahead, behind = surface(shape, s + ds, t + dt)[0], surface(shape, s - ds, t - dt)[0]
            assert slope == pytest.approx((ahead - behind) / (2.0 * step), abs=2e-6)


def patched(*patches):
    """Ground with patches of start, end, friction and cone-index factor."""
    field = level(patch_count=len(patches))
    for i, patch in enumerate(patches):
        field[Field.PATCHES + 4 * i : Field.PATCHES + 4 * i + 4] = patch
    return field


def there(field, ground, s, t=0.0):
    """Friction and cone index at a place; the rest of the soil must be as it was."""
    out = np.full(Soil.SIZE, np.nan)
    soil_at(field, ground, s, t, out)
    others = [i for i in range(Soil.SIZE) if i not in (Soil.FRICTION, Soil.CONE_INDEX_KPA)]
    assert np.array_equal(out[others], ground[others])
    return out[Soil.FRICTION], out[Soil.CONE_INDEX_KPA]


def test_patches_multiply_the_soil_inside_and_blend_over_half_a_metre():
    field = patched((10.0, 20.0, 0.5, 2.0), (15.0, 30.0, 0.8, 1.0))
    at = {s: there(field, soil(), s) for s in (9.7, 9.9, 10.0, 10.2, 12.0, 17.0, 25.0, 30.3)}
    assert at[9.7] == at[30.3] == (0.88, 1000.0)
    assert at[12.0] == pytest.approx((0.44, 2000.0))
    assert at[17.0] == pytest.approx((0.88 * 0.4, 2000.0))  # overlapping ones multiply
    assert at[25.0] == pytest.approx((0.88 * 0.8, 1000.0))
    assert at[10.0] == pytest.approx((0.88 * 0.75, 1500.0))  # half way at the border
    assert at[9.9] == pytest.approx((0.88 * (1.0 - 0.3 * 0.5), 1300.0))
    assert at[10.2] == pytest.approx((0.88 * (1.0 - 0.9 * 0.5), 1900.0))
    assert there(level(), soil(), 12.0) == (0.88, 1000.0)


def test_the_strength_varies_by_its_coefficient_with_place():
    """Friction and cone index by one factor: mean 1, sd 0.05, alike within a contact's length."""
    ground, field = soil(strength_cv=0.05), level(seed=12.0)
    s = np.arange(0.0, 12e3, 1.0)
    found = np.array([there(field, ground, x) for x in s])
    factor = found[:, 0] / 0.88
    assert found[:, 1] / 1000.0 == pytest.approx(factor)
    assert factor.mean() == pytest.approx(1.0, abs=4.0 * 0.05 / math.sqrt(12e3 / 4.0))
    assert factor.std() == pytest.approx(0.05, rel=0.05)
    close = np.array([there(field, ground, x + 0.3)[0] for x in s[:2000]]) / 0.88
    assert np.corrcoef(close, factor[:2000])[0, 1] > 0.95
    assert abs(np.corrcoef(factor[9:], factor[:-9])[0, 1]) < 0.06
    shifted = level(seed=12.0, origin_s_m=100.0)
    assert there(shifted, ground, 5.0) == there(field, ground, 105.0)
