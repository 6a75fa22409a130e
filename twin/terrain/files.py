"""A user's own map, from a NumPy file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput

Array = NDArray[np.float64]

MOST_NODES = 4_000_000


def read_nodes(path: str, low: float, high: float) -> Array:
    """The two-dimensional array of a .npy file, checked.

    Args:
        path: the file.
        low, high: what its values must lie between.

    Raises:
        BadInput: it cannot be read, or does not hold such an array.
    """
    try:
        nodes = np.load(Path(path), allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise BadInput(f"{path} cannot be read as a .npy array: {error}") from None
    if not isinstance(nodes, np.ndarray) or nodes.ndim != 2 or min(nodes.shape) < 2:
        shape = getattr(nodes, "shape", "several arrays")
        raise BadInput(f"{path} holds {shape}; rows and columns, two at least, would do")
    if nodes.dtype.kind not in "fiu" or nodes.size > MOST_NODES:
        raise BadInput(
            f"{path} holds {nodes.size} values of type {nodes.dtype}; numbers, "
            f"{MOST_NODES} at most, would do"
        )
    values = np.asarray(nodes, dtype=np.float64)
    outside = ~((values >= low) & (values <= high))  # NaN too
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise BadInput(
            f"{path}: {values[row, column]:g} at row {row}, column {column} is outside "
            f"[{low:g}, {high:g}]"
        )
    return values
