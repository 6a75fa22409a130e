"""The Pareto front: which controllers no other one beats in everything that is asked for."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from twin.env.fieldwork import COSTS
from twin.io.result_rows import Row, Rows, row

Array = NDArray[np.float64]

OBJECTIVES: dict[str, dict[str, float]] = {
    "Plough-v1": {"work_rate": 1.0, "fuel": -1.0, **dict.fromkeys(COSTS, -1.0)},
    "WheelSlip-v1": {"speed": 1.0, "energy": -1.0, "cost_line": -1.0, "cost_slip": -1.0},
}
"""What is asked for, by environment: 1 for much of it, -1 for little."""
ON_FRONT = "on the Pareto front of area or speed, fuel or energy, and costs"


def undominated(values: Array) -> NDArray[np.bool_]:
    """Which rows no other row beats.

    One beats another if it is nowhere less and somewhere more.

    Args:
        values: (rows, objectives), more is better.
    """
    less = (values[:, None] <= values[None]).all(axis=-1)
    differs = (values[:, None] != values[None]).any(axis=-1)
    return np.asarray(~(less & differs).any(axis=1))


def front_rows(environment: str, measured: Mapping[str, Mapping[str, Array]]) -> Rows:
    """1 for each controller on the front of the means, 0 for the others; none without objectives.

    Args:
        environment: by its id.
        measured: by controller, then by quantity, arrays (grounds,).
    """
    asked = OBJECTIVES.get(environment, {})
    if not asked or not measured:
        return []
    means = [[sign * each[n].mean() for n, sign in asked.items()] for each in measured.values()]
    found = zip(measured, undominated(np.array(means)), strict=True)
    return [_row(name, float(on)) for name, on in found]


def _row(case: str, on: float) -> Row:
    return dict(row(case, ON_FRONT, on, "1"))
