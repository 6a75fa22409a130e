"""The ground as a function of place: its maps, the furrow, and the soil that varies over it.

Random fields are made by hashing, so a run can be repeated over them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from twin.compiled import law
from twin.physics.block import Field, Grid, Soil
from twin.physics.shapes import Array, Vector

_MIX_X, _MIX_Y, _MIX_SEED = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xC2B2AE3D27D4EB4F),
    np.uint64(0x165667B19E3779F9),
)
_MIX_A, _MIX_B = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


EDGE_M = 0.1
"""Width over which the wall of the furrow falls to its bottom [m]."""
BLEND_M = 0.5
"""Length over which one patch of soil passes into the next [m]: about that of a contact."""
STRENGTH_LENGTH_M = 3.0
"""Distance between independent values of the soil's strength [m]; assumed."""
STRENGTH, RIPPLE, ROCKS = 101, 202, 303
"""What is added to the seed so that the fields are independent of each other."""


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


@law
def on_ground(field: Array, point: Vector) -> tuple[float, float, float]:
    """A world point in the ground's frame: s along, t left, h above the plane [m]."""
    return (
        field[Field.AHEAD] * point[0]
        + field[Field.AHEAD + 1] * point[1]
        + field[Field.AHEAD + 2] * point[2],
        field[Field.LEFT] * point[0]
        + field[Field.LEFT + 1] * point[1]
        + field[Field.LEFT + 2] * point[2],
        field[Field.NORMAL] * point[0]
        + field[Field.NORMAL + 1] * point[1]
        + field[Field.NORMAL + 2] * point[2],
    )


@law
def field_axis(field: Array, which: int) -> Vector:
    """A unit vector of the ground's frame, by its place in the block (AHEAD, LEFT, NORMAL)."""
    return (field[which], field[which + 1], field[which + 2])


@law
def beside_pass(field: Array, t_m: float) -> float:
    """Distance to the left of the pass's line, as seen by who drives it [m]."""
    return field[Field.PASS_WAY] * (t_m - field[Field.PASS_T_M])


@law
def furrow(field: Array, s_m: float, t_m: float) -> tuple[float, float]:
    """Height of the furrow's bottom below the field, and its slope along the ground.

    The wheel path of the last pass: beyond its wall, from where that pass got its depth. Side and
    start are those of this pass, which may go back against the ground's axes.

    Returns:
        height_m (<= 0), dh/ds.
    """
    side = field[Field.FURROW_SIDE]
    if side == 0.0:
        return 0.0, 0.0
    way, aside_m = field[Field.PASS_WAY], beside_pass(field, t_m)
    beyond = (side * aside_m - field[Field.FURROW_EDGE_M]) / EDGE_M
    if beyond <= 0.0:
        return 0.0, 0.0
    done_m, ramp_m = way * (s_m - field[Field.PASS_S_M]), field[Field.FURROW_RAMP_M]
    along = (done_m - field[Field.FURROW_START_M]) / ramp_m
    left = (field[Field.FURROW_END_M] - done_m) / ramp_m + 1.0
    if left < along:
        along, way = left, -way
    if along <= 0.0:
        return 0.0, 0.0
    depth = field[Field.FURROW_DEPTH_M] * min(1.0, beyond)
    if along >= 1.0:
        return -depth, 0.0
    slope = way * 6.0 * along * (1.0 - along) / ramp_m
    return -depth * along * along * (3.0 - 2.0 * along), -depth * slope


@law
def on_map(
    field: Array, which: int, nodes: Array, s_m: float, t_m: float
) -> tuple[float, float, float]:
    """Value of a map at a place, between its four nodes, and its slopes; 0 without a map.

        f = (1 - b) ((1 - a) f00 + a f10) + b ((1 - a) f01 + a f11)

    Args:
        field: its part of the block.
        which: the map, by its place there (HEIGHTS, MIXTURE).
        nodes: the model's hfield_data.
        s_m, t_m: the place.

    Returns:
        f, df/ds, df/dt.
    """
    columns, rows = int(field[which + Grid.COLUMNS]), int(field[which + Grid.ROWS])
    if rows == 0:
        return 0.0, 0.0, 0.0
    cell_m, first = field[which + Grid.CELL_M], int(field[which + Grid.FIRST])
    along_s = along_t = field[which + Grid.RANGE] / cell_m
    u = (s_m + field[Field.ORIGIN_S_M] - field[which + Grid.START_M]) / cell_m
    v = (t_m + field[Field.ORIGIN_T_M] - field[which + Grid.RIGHT_M]) / cell_m
    if field[which + Grid.REPEATS] != 0.0:
        i, j = math.floor(u), math.floor(v)
        a, b = u - i, v - j
        i, j = int(i) % columns, int(j) % rows
        east, north = (i + 1) % columns, (j + 1) % rows
    else:  # a place beyond the border has the border's value, and no slope across it
        along_s = along_s if 0.0 <= u <= columns - 1.0 else 0.0
        along_t = along_t if 0.0 <= v <= rows - 1.0 else 0.0
        u, v = min(max(u, 0.0), columns - 1.0), min(max(v, 0.0), rows - 1.0)
        i, j = min(int(u), columns - 2), min(int(v), rows - 2)
        a, b = u - i, v - j
        east, north = i + 1, j + 1
    near, far = first + j * columns, first + north * columns
    f00, f10, f01, f11 = nodes[near + i], nodes[near + east], nodes[far + i], nodes[far + east]
    right, left = f00 + a * (f10 - f00), f01 + a * (f11 - f01)
    return (
        field[which + Grid.LOW] + field[which + Grid.RANGE] * (right + b * (left - right)),
        along_s * ((1.0 - b) * (f10 - f00) + b * (f11 - f01)),
        along_t * (left - right),
    )


@law
def surface(field: Array, nodes: Array, s_m: float, t_m: float) -> tuple[float, float, float]:
    """Height of the ground at a place, its map and the furrow together, and its slopes."""
    height, slope_s, slope_t = on_map(field, Field.HEIGHTS, nodes, s_m, t_m)
    bottom, slope = furrow(field, s_m, t_m)
    return height + bottom, slope_s + slope, slope_t


@law
def soil_at(field: Array, soil: Array, nodes: Array, s_m: float, t_m: float, out: Array) -> None:
    """The soil's numbers at a place: the map's other soil, patches, and strength that varies.

    Where the two soils meet their numbers are mixed; the law is that of the larger share.
    """
    out[:] = soil[:]
    if field[Field.MIXTURE + Grid.ROWS] != 0.0:
        share = on_map(field, Field.MIXTURE, nodes, s_m, t_m)[0]
        for i in range(len(soil)):
            out[i] += share * (field[Field.OTHER + i] - soil[i])
        out[Soil.LAW] = field[Field.OTHER + Soil.LAW] if share > 0.5 else soil[Soil.LAW]
    friction = mobility = 1.0
    for i in range(int(field[Field.PATCH_COUNT])):
        at = Field.PATCHES + 4 * i
        inside = min(1.0, max(0.0, min(s_m - field[at], field[at + 1] - s_m) / BLEND_M + 0.5))
        friction *= 1.0 + inside * (field[at + 2] - 1.0)
        mobility *= 1.0 + inside * (field[at + 3] - 1.0)
    cv = soil[Soil.STRENGTH_CV]
    if cv > 0.0:
        s, t = s_m + field[Field.ORIGIN_S_M], t_m + field[Field.ORIGIN_T_M]
        factor = 1.0 + cv * random_field(field[Field.SEED] + STRENGTH, s, t, STRENGTH_LENGTH_M)
        friction, mobility = friction * factor, mobility * factor
    out[Soil.FRICTION] *= friction
    out[Soil.COHESION_PA] *= friction
    out[Soil.TAN_PHI] *= friction
    out[Soil.CONE_INDEX_KPA] *= mobility
    out[Soil.K_C] *= mobility
    out[Soil.K_PHI] *= mobility


@law
def draft_scale(field: Array, soil: Array, nodes: Array, s_m: float, t_m: float) -> float:
    """F of ASABE D497 at a place, between that of the soil and of the map's other soil."""
    share = on_map(field, Field.MIXTURE, nodes, s_m, t_m)[0]
    own = soil[Soil.DRAFT_SCALE]
    return own + share * (field[Field.OTHER + Soil.DRAFT_SCALE] - own)
