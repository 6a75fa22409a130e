"""A map on a grid, against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from twin.terrain.grid import GridMap


@pytest.mark.parametrize("shape", [(37, 91), (1, 5), (8, 8)])
def test_a_map_that_repeats_is_read_as_scipy_reads_it_to_the_bit(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(3)
    nodes = rng.normal(size=shape)
    row, column = rng.uniform(-90.0, 130.0, 5000), rng.uniform(-200.0, 300.0, 5000)
    row[:50], column[:25] = np.round(row[:50]), np.round(column[:25]) + 0.5
    place = np.stack([row, column])
    expected = map_coordinates(nodes, place, order=2, prefilter=False, mode="grid-wrap")
    grid = GridMap(nodes, 1.0, 0.0, 0.0, repeats=True)
    if min(shape) > 1:
        assert np.array_equal(grid.at(column, row), expected)
    else:  # a single row is the same wherever it is read
        assert grid.at(column, row) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("repeats", [True, False])
def test_the_way_back_is_over_the_same_ground(repeats: bool) -> None:
    rng = np.random.default_rng(4)
    grid = GridMap(rng.normal(size=(30, 50)), 0.5, -3.0, -7.0, repeats)
    s, t = rng.uniform(-5.0, 30.0, 200), rng.uniform(-9.0, 9.0, 200)
    assert grid.turned(20.0).at(20.0 - s, -t) == pytest.approx(grid.at(s, t), abs=1e-12)
