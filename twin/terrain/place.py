"""Maps in a model: MuJoCo height fields, which the laws read and the viewer shows."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.physics.block import Grid
from twin.terrain.envelope import AXES, envelope
from twin.terrain.grid import GridMap

Array = NDArray[np.float64]

ENVELOPES = "envelopes"
"""The height field that holds what wheels feel of the heights."""
LEAST_RANGE = 1e-9
"""Range of a map that is the same everywhere: MuJoCo wants one."""


def add_map(spec: mujoco.MjSpec, name: str, grid: GridMap) -> None:
    """Add a map's place to a model's specification; whoever wants to see it adds a geom.

    Args:
        spec: mujoco.MjSpec.
        name: of the height field, flat until `fill`.
        grid: the map.
    """
    rows, columns = grid.nodes.shape
    half_m = [0.5 * (columns - 1) * grid.cell_m, 0.5 * (rows - 1) * grid.cell_m]
    _add_flat(spec, name, rows, columns, [*half_m, _range(grid)[1], 0.1])


def _add_flat(spec: mujoco.MjSpec, name: str, rows: int, columns: int, size: list[float]) -> None:
    """A height field of zeros, as a file in MuJoCo's own format: read at once, not node by node."""
    file = f"{name}.hfield"
    shape = np.array([rows, columns], np.int32).tobytes()
    spec.assets = {**spec.assets, file: shape + bytes(4 * rows * columns)}
    spec.add_hfield(name=name, file=file, size=size)


def fill(model: mujoco.MjModel, maps: dict[str, GridMap], radii_m: tuple[float, ...]) -> None:
    """Write maps, and the envelopes of their heights, into a compiled model."""
    for name, grid in maps.items():
        _write(_nodes(model, name), grid.nodes, *_range(grid))
    if "heights" in maps:
        kinds, span = [(r, axis) for r in radii_m for axis in AXES], _range(maps["heights"])
        parts = np.split(_nodes(model, ENVELOPES), len(kinds))
        for part, (radius_m, axis) in zip(parts, kinds, strict=True):
            _write(part, envelope(maps["heights"], radius_m, axis), *span)


def _nodes(model: mujoco.MjModel, name: str) -> NDArray[np.float32]:
    """Those of a model's height field."""
    field = model.hfield(name).id
    first, count = model.hfield_adr[field], model.hfield_nrow[field] * model.hfield_ncol[field]
    return np.asarray(model.hfield_data[first : first + count])


def _write(places: NDArray[np.float32], values: Array, low: float, span: float) -> None:
    """Write values as shares of their span."""
    shares = values - low
    shares /= span
    places[:] = shares.ravel()


def grid_part(model: mujoco.MjModel, name: str, grid: GridMap, at: int) -> dict[int, float]:
    """A map's numbers for the parameter block, from `at` on."""
    low, span = _range(grid)
    rows, columns = grid.nodes.shape
    values = {
        Grid.FIRST: int(model.hfield_adr[model.hfield(name).id]),
        Grid.ROWS: rows,
        Grid.COLUMNS: columns,
        Grid.CELL_M: grid.cell_m,
        Grid.START_M: grid.start_m,
        Grid.RIGHT_M: grid.right_m,
        Grid.LOW: low,
        Grid.RANGE: span if np.ptp(grid.nodes) > 0.0 else 0.0,
        Grid.REPEATS: float(grid.repeats),
    }
    return {at + name: value for name, value in values.items()}


def add_envelopes(spec: mujoco.MjSpec, heights: GridMap, radii_m: tuple[float, ...]) -> None:
    """Add the place of the heights as wheels feel them; `fill` writes them.

    They stand one below another, along and across for each radius, scaled as the heights
    themselves, whose range they keep to.
    """
    rows, columns = heights.nodes.shape
    rows *= len(radii_m) * len(AXES)
    _add_flat(spec, ENVELOPES, rows, columns, [1.0, 1.0, _range(heights)[1], 0.1])


def first_envelope(model: mujoco.MjModel) -> int:
    """Number of the first node of the envelopes in hfield_data."""
    return int(model.hfield_adr[model.hfield(ENVELOPES).id])


def _range(grid: GridMap) -> tuple[float, float]:
    return float(grid.nodes.min()), max(float(np.ptp(grid.nodes)), LEAST_RANGE)


def show_heights(
    spec: mujoco.MjSpec, grid: GridMap, rotation: np.ndarray, quaternion: Array
) -> None:
    """A geom that shows the heights where they are; nothing touches it.

    Args:
        spec: mujoco.MjSpec with the height field "heights".
        grid: the map.
        rotation, quaternion: of the ground's frame in the world.
    """
    rows, columns = grid.nodes.shape
    middle = np.array(
        [
            grid.start_m + 0.5 * (columns - 1) * grid.cell_m,
            grid.right_m + 0.5 * (rows - 1) * grid.cell_m,
            _range(grid)[0],
        ]
    )
    spec.worldbody.add_geom(
        name="terrain",
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="heights",
        pos=rotation @ middle,
        quat=quaternion,
        contype=0,
        conaffinity=0,
        rgba=[0.48, 0.40, 0.27, 1.0],
    )
