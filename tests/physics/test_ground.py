"""The random ground: unit variance everywhere, made by place and seed alone."""

import numpy as np
import pytest
from numba import njit

from twin.physics.ground import node_value, random_field


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
