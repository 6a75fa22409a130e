"""Maps in a model: MuJoCo height fields, which the laws read and the viewer shows."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.physics.block import Grid
from twin.terrain.envelope import envelope
from twin.terrain.grid import GridMap

Array = NDArray[np.float64]

ENVELOPES = "envelopes"
"""The height field that holds what wheels feel of the heights."""
LEAST_RANGE = 1e-9
"""Range of a map that is the same everywhere: MuJoCo wants one."""


def add_map(spec: mujoco.MjSpec, name: str, grid: GridMap) -> None:
    """Add a map to a model's specification as a height field; whoever wants to see it adds a geom.

    Args:
        spec: mujoco.MjSpec.
        name: of the height field.
        grid: the map.
    """
    rows, columns = grid.nodes.shape
    low, span = _range(grid)
    spec.add_hfield(
        name=name,
        nrow=rows,
        ncol=columns,
        size=[0.5 * (columns - 1) * grid.cell_m, 0.5 * (rows - 1) * grid.cell_m, span, 0.1],
        userdata=((grid.nodes - low) / span).ravel(),
    )


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
    """Add the heights as wheels feel them, one below another: along and across for each radius.

    Scaled as the heights themselves, whose range they keep to.
    """
    low, span = _range(heights)
    felt = [envelope(heights, r, axis) for r in radii_m for axis in ("along", "across")]
    nodes = np.concatenate(felt)
    rows, columns = nodes.shape
    spec.add_hfield(
        name=ENVELOPES,
        nrow=rows,
        ncol=columns,
        size=[1.0, 1.0, span, 0.1],
        userdata=((nodes - low) / span).ravel(),
    )


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
