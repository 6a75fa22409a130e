"""A linear Gaussian model of a motion and its sensors, and the variances that it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators import riccati
from estimators.riccati import System


@dataclass(frozen=True, kw_only=True)
class Model:
    """A system, and what its rows and states are."""

    system: System
    of: list[str]
    """The sensor that each row is of."""
    at: dict[str, int]
    """Index of the states whose bounds are wanted."""


def variances(
    model: Model, hidden: NDArray[np.bool_], wanted: NDArray[np.bool_], state: int
) -> tuple[float, float]:
    """Mean variance of a state over the wanted steps, by filter and by smoother."""
    seen = np.empty((len(hidden), len(model.of)), bool)
    for row, sensor in enumerate(model.of):
        seen[:, row] = (sensor != "gnss") | ~hidden
    causal, offline = riccati.through(model.system, seen, state)
    return float(np.mean(causal[wanted])), float(np.mean(offline[wanted]))
