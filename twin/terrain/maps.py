"""The maps that a scenario's ground needs."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.scenario import Scenario
from twin.scenario.route import extent_m
from twin.terrain import random
from twin.terrain.files import read_nodes
from twin.terrain.grid import GridMap

Array = NDArray[np.float64]

MOST_HEIGHT_M = 10.0
STEEPEST = 0.5
"""Steepest slope between two nodes of a user's heights [-]: no machine here stands on it."""
ROUGHNESS_STREAM, MIXTURE_STREAM = 8608, 8609
"""What is put beside the scenario's seed, so that the maps are independent of all other chance."""


def ground_maps(scenario: Scenario) -> dict[str, GridMap]:
    """Map name in the model, "heights" or "mixture" -> map of the scenario's ground.

    Raises:
        BadInput: a user's map cannot be read or is too steep.
    """
    found = {"heights": height_map(scenario), "mixture": mixture_map(scenario)}
    return {name: grid for name, grid in found.items() if grid is not None}


def height_map(scenario: Scenario) -> GridMap | None:
    """Height of the ground above its plane [m]; None for a plane.

    Raises:
        BadInput: the user's map cannot be read or is too steep.
    """
    field = scenario.field
    if field.height_map is not None:
        nodes = read_nodes(field.height_map, -MOST_HEIGHT_M, MOST_HEIGHT_M)
        step_m, most_m = _largest_step(nodes), STEEPEST * field.map_cell_m
        if step_m > most_m:
            raise BadInput(
                f"{field.height_map} has a step of {step_m:.3g} m between nodes "
                f"{field.map_cell_m:g} m apart; {most_m:.3g} m at most would do"
            )
        return _from_file(nodes, field.map_cell_m, field.map_start_m)
    if field.roughness_class == "smooth":
        return None
    start, right, shape = _covering(scenario, random.CELL_M)
    nodes = _rough(field.roughness_class, shape, scenario.seed)
    return GridMap(nodes, random.CELL_M, start, right, repeats=True)


@lru_cache(maxsize=1)
def _rough(roughness_class: str, shape: tuple[int, int], seed: int) -> Array:
    """The last one is kept: a run drives on it and draws it."""
    rng = np.random.default_rng((seed, ROUGHNESS_STREAM))
    nodes = random.rough_heights(roughness_class, shape, rng)
    nodes.flags.writeable = False
    return nodes


def mixture_map(scenario: Scenario) -> GridMap | None:
    """Share of the other soil [-]; None where there is but one.

    Raises:
        BadInput: the user's map cannot be read.
    """
    field = scenario.field
    if field.soil_map is not None:
        nodes = read_nodes(field.soil_map, 0.0, 1.0)
        return _from_file(nodes, field.map_cell_m, field.map_start_m)
    if field.other_share == 0.0:
        return None
    rng = np.random.default_rng((scenario.seed, MIXTURE_STREAM))
    cell_m = min(0.25, 0.1 * field.other_length_m)
    start, right, shape = _covering(scenario, cell_m)
    nodes = random.mixture(field.other_share, field.other_length_m, shape, cell_m, rng)
    return GridMap(nodes, cell_m, start, right, repeats=True)


def _largest_step(nodes: Array) -> float:
    return max(float(np.abs(np.diff(nodes, axis=axis)).max()) for axis in (0, 1))


def _from_file(nodes: Array, cell_m: float, start_m: float) -> GridMap:
    """A user's map: its first column at `start_m`, its middle on the course's line."""
    return GridMap(nodes, cell_m, start_m, -0.5 * cell_m * (len(nodes) - 1), repeats=False)


def _covering(scenario: Scenario, cell_m: float) -> tuple[float, float, tuple[int, int]]:
    """First column's s, first row's t, and shape of a grid that covers the course."""
    (start, end), (right, left) = extent_m(scenario)
    rows = _fast(round((left - right) / cell_m))
    columns = _fast(round((end - start) / cell_m))
    return start, right, (rows, columns)


def _fast(count: int) -> int:
    """The least size from a count on whose Fourier transform is fast: of the factors 2, 3, 5."""
    left = count
    for factor in (2, 3, 5):
        while left % factor == 0:
            left //= factor
    return count if left == 1 else _fast(count + 1)
