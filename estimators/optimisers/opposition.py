"""Lens-imaging opposition: a position seen in a lens at the middle, its scale driven by chaos."""

from __future__ import annotations

import numpy as np

from estimators.optimisers.population import Array
from twin.compute.compiled import compiled

ETA_MIN, ETA_MAX = 0.5, 2.0
"""Range of the scale; the paper prints none. 1 mirrors, 2 halves the distance to the middle."""
CHAOS = 4.0
"""r of the logistic map."""


@compiled
def lens_image(u: Array, eta: float) -> Array:
    """Image of a position of the unit cube, (n,).

    x* = 1/2 + 1 / (2 eta) - x / eta,   clipped to the cube (eta < 1 leaves it)

    Source: IMA-PKF paper (INMATEH 77-13), eq. (14), with lb = 0 and ub = 1.
    """
    image = np.empty(len(u))
    for k in range(len(u)):
        image[k] = min(max(0.5 + 0.5 / eta - u[k] / eta, 0.0), 1.0)
    return image


@compiled
def scale(chaos: float) -> float:
    """eta = eta_min + (eta_max - eta_min) c.  Source: the same, eq. (15)."""
    return ETA_MIN + (ETA_MAX - ETA_MIN) * chaos


@compiled
def next_chaos(chaos: float) -> float:
    """c <- r c (1 - c), the logistic map."""
    return CHAOS * chaos * (1.0 - chaos)
