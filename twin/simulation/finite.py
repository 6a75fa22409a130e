"""Whether a simulation's numbers are all finite."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law

Array = NDArray[np.float64]

UNSHARED = 8192
"""Numbers that a BLAS sums without sharing the work among threads, for which it would wait."""


def all_finite(values: Array) -> bool:
    """Whether all are finite, and none so large that its square is not."""
    flat = values.reshape(-1)
    if len(flat) <= UNSHARED:
        return math.isfinite(np.vdot(flat, flat))
    parts = (flat[k : k + UNSHARED] for k in range(0, len(flat), UNSHARED))
    return all(math.isfinite(np.vdot(part, part)) for part in parts)


@law
def well(state: Array, warned: NDArray[np.int64]) -> bool:
    """Whether MuJoCo has not warned, and no number of the states is one that `all_finite` denies.

    Args:
        state: of the machines (nsim, nstate).
        warned: how often MuJoCo warned (nsim, kinds).
    """
    squares, warnings = 0.0, 0
    for i in range(state.shape[0]):
        for k in range(state.shape[1]):
            squares += state[i, k] * state[i, k]
        for k in range(warned.shape[1]):
            warnings += warned[i, k]
    return warnings == 0 and math.isfinite(squares)


@law
def all_well(state: Array, warned: NDArray[np.int64], slots: Array) -> bool:
    """The same of the states and of the slots recorded after each step (nsim, steps, nuserdata)."""
    squares = 0.0
    for i in range(slots.shape[0]):
        for j in range(slots.shape[1]):
            for k in range(slots.shape[2]):
                squares += slots[i, j, k] * slots[i, j, k]
    return well(state, warned) and math.isfinite(squares)
