"""Named values of many machines: a NamedTuple of numbers for one, a structured array for all.

A compiled function reads `row.steer_rad` of either.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Records: TypeAlias = NDArray[Any]
"""Structured array of shape (nsim,), with the fields of a NamedTuple."""


def records(row: NamedTuple, count: int) -> Records:
    """A structured array of `count` rows, each a copy of `row`. Shape (count,).

    Args:
        row: NamedTuple of floats, integers and booleans; its field names become the array's.
        count: number of rows.
    """
    kinds = [(name, np.asarray(value).dtype) for name, value in row._asdict().items()]
    return np.array([tuple(row)] * count, dtype=np.dtype(kinds, align=True))
