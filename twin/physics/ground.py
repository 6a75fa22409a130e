"""The ground as a function of place.

Random fields made by hashing, so a run can be repeated over it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from twin.physics.compiled import law

_MIX_X, _MIX_Y, _MIX_SEED = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xC2B2AE3D27D4EB4F),
    np.uint64(0x165667B19E3779F9),
)
_MIX_A, _MIX_B = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


@law
def node_value(seed: float, ix: Any, iy: Any) -> float:
    """Uniform random number at a lattice node, mean 0, variance 1.

    SplitMix64's finaliser (Steele, Lea, Flood 2014) over the node's coordinates and the seed.
    """
    h = np.uint64(ix) * _MIX_X + np.uint64(iy) * _MIX_Y + np.uint64(seed) * _MIX_SEED
    h = (h ^ (h >> np.uint64(30))) * _MIX_A
    h = (h ^ (h >> np.uint64(27))) * _MIX_B
    h = h ^ (h >> np.uint64(31))
    unit = float(h >> np.uint64(11)) * (1.0 / 9007199254740992.0)
    return (2.0 * unit - 1.0) * math.sqrt(3.0)


@law
def random_field(seed: float, x_m: float, y_m: float, length_m: float) -> float:
    """Smooth random field, mean 0, variance 1 everywhere, nodes `length_m` apart.

        f = sum_i w_i g_i / sqrt(sum_i w_i**2)

    over the four surrounding nodes, w from smoothstep weights. The division keeps the variance the
    same between nodes as on them.
    """
    u, v = x_m / length_m, y_m / length_m
    iu, iv = math.floor(u), math.floor(v)
    a, b = u - iu, v - iv
    a, b = a * a * (3.0 - 2.0 * a), b * b * (3.0 - 2.0 * b)
    jx, jy = np.int64(iu), np.int64(iv)
    w00, w10, w01, w11 = (1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b
    total = (
        w00 * node_value(seed, jx, jy)
        + w10 * node_value(seed, jx + 1, jy)
        + w01 * node_value(seed, jx, jy + 1)
        + w11 * node_value(seed, jx + 1, jy + 1)
    )
    return total / math.sqrt(w00 * w00 + w10 * w10 + w01 * w01 + w11 * w11)
