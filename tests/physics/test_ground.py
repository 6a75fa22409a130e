"""The ground: random fields of unit variance by place and seed, maps, furrow, patches."""

import math

import numpy as np
import pytest
from numba import njit

from tests.physics.blocks import NO_NODES, furrowed, level, soil
from twin.physics.block import Field, Grid, Soil
from twin.physics.ground import (
    draft_scale,
    furrow,
    node_value,
    on_map,
    random_field,
    soil_at,
)
from twin.scenario import Patch
from twin.scenario.field import factor_at
from twin.terrain.grid import GridMap


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
def on_maps(field, nodes, s, t):
    out = np.empty((len(s), 3))
    for i in range(len(s)):
        out[i] = on_map(field, Field.HEIGHTS, nodes, s[i], t[i])
    return out


def mapped(grid, base=None):
    """Ground with a map of heights, and the nodes as a model keeps them."""
    low, span = grid.nodes.min(), np.ptp(grid.nodes)
    field = level() if base is None else base
    rows, columns = grid.nodes.shape
    values = (5, rows, columns, grid.cell_m, grid.start_m, grid.right_m, low, span, grid.repeats)
    field[Field.HEIGHTS : Field.HEIGHTS + Grid.SIZE] = values
    nodes = np.concatenate([np.full(5, 9.0), ((grid.nodes - low) / span).ravel()])
    return field, nodes.astype(np.float32)


BUMPS = np.random.default_rng(3).normal(0.0, 0.1, (7, 11))


@pytest.mark.parametrize("repeats", [True, False])
def test_a_map_is_scipys_quadratic_spline_and_its_slopes_are_continuous(repeats):
    """Against SciPy's interpolation, and finite differences everywhere, node lines included."""
    grid = GridMap(BUMPS, 0.4, -1.0, -0.7, repeats)
    field, nodes = mapped(grid)
    s, t = np.random.default_rng(4).uniform(-20.0, 20.0, (2, 2000))
    found = on_maps(field, nodes, s, t)
    assert found[:, 0] == pytest.approx(grid.at(s, t), abs=1e-6)
    assert found[:, 0].min() >= BUMPS.min() - 1e-7
    assert found[:, 0].max() <= BUMPS.max() + 1e-7
    for axis, (ds, dt) in enumerate([(1e-4, 0.0), (0.0, 1e-4)], start=1):
        ahead, behind = on_maps(field, nodes, s + ds, t + dt), on_maps(field, nodes, s - ds, t - dt)
        difference = (ahead[:, 0] - behind[:, 0]) / 2e-4
        assert found[:, axis] == pytest.approx(difference, abs=1e-3)  # of second differences


def test_a_map_that_is_a_plane_stays_a_plane():
    rows, columns = np.mgrid[:9, :12]
    field, nodes = mapped(GridMap(0.3 + 0.02 * columns - 0.05 * rows, 0.4, 0.0, 0.0, False))
    s, t = np.random.default_rng(6).uniform(0.5, 2.5, (2, 100))
    found = on_maps(field, nodes, s, t)
    assert found[:, 0] == pytest.approx(0.3 + (0.02 * s - 0.05 * t) / 0.4, abs=1e-6)
    assert found[:, 1:] == pytest.approx(np.tile([0.05, -0.125], (100, 1)), abs=1e-6)


def test_past_its_border_a_map_goes_on_as_its_border_without_slope_across_it():
    field, nodes = mapped(GridMap(BUMPS, 0.4, 0.0, 0.0, repeats=False))
    beyond = on_maps(field, nodes, np.array([50.0, -3.0]), np.array([0.8, 0.8]))
    edges = BUMPS[1:4][:, [-1, 0]]
    assert beyond[:, 0] == pytest.approx([0.125, 0.75, 0.125] @ edges, abs=1e-6)
    assert np.all(beyond[:, 1] == 0.0)


def test_a_map_moves_with_the_origin_and_no_map_is_flat():
    grid = GridMap(BUMPS, 0.4, -1.0, -0.7, repeats=True)
    field, nodes = mapped(grid)
    moved, _ = mapped(grid, level(origin_s_m=30.0, origin_t_m=-7.0))
    s, t = np.random.default_rng(8).uniform(-50.0, 50.0, (2, 50))
    there = on_maps(field, nodes, s + 30.0, t - 7.0)
    assert on_maps(moved, nodes, s, t) == pytest.approx(there, abs=1e-9)
    assert not on_maps(level(), NO_NODES, s, t).any()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_furrow_lies_beyond_its_edge_and_gets_its_depth_on_a_ramp(side):
    field = furrowed(side)
    none = (0.0, 0.0, 0.0)
    assert furrow(field, 20.0, side * 0.65) == none
    assert furrow(field, 20.0, -side * 0.9) == none  # the land
    assert furrow(field, 20.0, side * 0.9) == pytest.approx((-0.25, 0.0, 0.0))
    on_wall = (-0.125, 0.0, -side * 0.25 * 1.5 / 0.1)
    assert furrow(field, 20.0, side * 0.70) == pytest.approx(on_wall)
    assert furrow(field, 20.0, side * 1.5) == none  # the turned soil
    assert furrow(field, 9.99, side * 0.9) == none
    assert furrow(field, 11.5, side * 0.9) == pytest.approx((-0.125, -0.25 * 1.5 / 3.0, 0.0))
    depths = [-furrow(field, s, side * 0.9)[0] for s in np.linspace(9.0, 14.0, 501)]
    assert np.all(np.diff(depths) >= 0.0)
    assert np.abs(np.diff(depths, 2)).max() < 2e-5 + 0.25 * 6.0 / 9.0 * 0.01**2  # no kink
    assert furrow(level(), 20.0, 0.9) == none


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_furrows_slopes_are_those_of_its_height(side):
    """Also across its wall, or a wheel that climbs it would be lifted for nothing."""
    field = furrowed(side, furrow_end_m=30.0, pass_s_m=2.0, pass_t_m=-0.4)
    for s, t in np.random.default_rng(1).uniform((9.0, -2.0), (38.0, 2.0), (500, 2)):
        _, slope_s, slope_t = furrow(field, s, t)
        along = (furrow(field, s + 1e-5, t)[0] - furrow(field, s - 1e-5, t)[0]) / 2e-5
        across = (furrow(field, s, t + 1e-5)[0] - furrow(field, s, t - 1e-5)[0]) / 2e-5
        assert (slope_s, slope_t) == pytest.approx((along, across), abs=1e-4)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_on_the_way_back_the_furrow_is_the_same_turned_about(side):
    """A pass that begins at (60, 1.4) and goes back: a half turn of the ground about its start."""
    here = furrowed(side, furrow_end_m=30.0)
    back = furrowed(side, furrow_end_m=30.0, pass_s_m=60.0, pass_t_m=1.4, pass_way=-1.0)
    for s, t in np.random.default_rng(2).uniform((8.0, -2.0), (36.0, 2.0), (300, 2)):
        bottom, slope_s, slope_t = furrow(here, s, t)
        found = furrow(back, 60.0 - s, 1.4 - t)
        assert found == pytest.approx((bottom, -slope_s, -slope_t), abs=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_furrow_ends_on_a_ramp_where_the_plough_was_raised(side):
    field = furrowed(side, furrow_end_m=30.0)
    assert furrow(field, 30.0, side * 0.9)[0] == -0.25
    assert furrow(field, 31.5, side * 0.9) == pytest.approx((-0.125, 0.25 * 1.5 / 3.0, 0.0))
    assert furrow(field, 33.01, side * 0.9) == (0.0, 0.0, 0.0)


def patched(*patches):
    """Ground with patches of start, end, friction and cone-index factor."""
    field = level(patch_count=len(patches))
    for i, patch in enumerate(patches):
        field[Field.PATCHES + 4 * i : Field.PATCHES + 4 * i + 4] = patch
    return field


def there(field, ground, s, t=0.0):
    """Friction and cone index at a place; the rest of the soil must be as it was."""
    out = np.full(Soil.SIZE, np.nan)
    soil_at(field, ground, NO_NODES, s, t, out)
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


def test_a_scenario_checks_the_factors_that_the_ground_has():
    rows = ((10.0, 20.0, 0.5, 2.0), (20.0, 30.0, 2.0, 3.0), (15.0, 15.5, 0.8, 0.1))
    patches = tuple(
        Patch(start_m=s, length_m=e - s, friction_factor=f, cone_index_factor=c)
        for s, e, f, c in rows
    )
    for s in np.linspace(9.0, 31.0, 221):
        friction, cone_index = there(patched(*rows), soil(), s)
        assert factor_at(patches, "friction_factor", s) == pytest.approx(friction / 0.88)
        assert factor_at(patches, "cone_index_factor", s) == pytest.approx(cone_index / 1000.0)


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


def test_where_two_soils_meet_their_numbers_are_mixed_and_the_larger_share_has_the_law():
    own, other = soil(), soil(friction=0.5, cone_index_kpa=400.0, draft_scale=0.45, law=1.0)
    field = level()
    field[Field.OTHER : Field.OTHER + Soil.SIZE] = other
    shares = np.array([[0.0, 1.0], [0.0, 1.0]])
    grid = (0, 2, 2, 10.0, 0.0, -5.0, 0.0, 1.0, 0.0)
    field[Field.MIXTURE : Field.MIXTURE + Grid.SIZE] = grid
    nodes = shares.ravel().astype(np.float32)
    # a spline past the border, 0.75**2 / 2 of the farther node at a quarter of the cell, and so on
    for s, share in ((-30.0, 0.0), (2.5, 0.28125), (7.5, 0.71875), (40.0, 1.0)):
        out = np.full(Soil.SIZE, np.nan)
        soil_at(field, own, nodes, s, 0.0, out)
        mixed = own + share * (other - own)
        mixed[Soil.LAW] = 1.0 if share > 0.5 else 0.0
        assert out == pytest.approx(mixed, abs=1e-12)
        assert draft_scale(field, own, nodes, s, 0.0) == pytest.approx(0.85 - 0.4 * share)
