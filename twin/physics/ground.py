"""The ground as a function of place: its maps, the furrow, and the soil that varies over it.

Random fields are hashes of place and seed, so the same seed gives the same ground.
"""

from __future__ import annotations

import math

import numpy as np

from twin.compute.compiled import inlined_law, law
from twin.physics.block import Field, Grid, Soil
from twin.physics.shapes import Array, Vector
from twin.scenario.soils import BLEND_M

_MIX_X, _MIX_Y, _MIX_SEED = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xC2B2AE3D27D4EB4F),
    np.uint64(0x165667B19E3779F9),
)
_MIX_A, _MIX_B = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


EDGE_M = 0.1
"""Width over which the wall of the furrow falls to its bottom [m]."""
SLICE_SIDE_M = 0.3
"""Width over which the turned slice rises from the furrow's bottom [m]; assumed."""
STRENGTH_LENGTH_M = 3.0
"""Distance between independent values of the soil's strength [m]; assumed."""
STRENGTH, RIPPLE, ROCKS = 101, 202, 303
"""Numbers added to the seed, one per random field, so that the fields are independent."""


@law
def node_value(seed: float, ix: int | np.int64, iy: int | np.int64) -> float:
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

    over the four surrounding nodes, with g by `node_value` and smoothstep weights w. The division
    keeps the variance between nodes the same as on them.
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


@inlined_law
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


@inlined_law
def field_axis(field: Array, which: int) -> Vector:
    """A unit vector of the ground's frame, in world axes.

    `which` is the index of its first component: Field.AHEAD, Field.LEFT or Field.NORMAL.
    """
    return (field[which], field[which + 1], field[which + 2])


@inlined_law
def beside_pass(field: Array, t_m: float) -> float:
    """Distance from the pass's line to the left of its direction of travel, of a point at t [m]."""
    return field[Field.PASS_WAY] * (t_m - field[Field.PASS_T_M])


@inlined_law
def furrow(field: Array, s_m: float, t_m: float) -> tuple[float, float, float]:
    """Height of the last furrow's bottom below the field at a place, and its slopes.

        h = -depth q(along) q(beyond) (1 - q(over))        q(x) = x**2 (3 - 2 x) between 0 and 1

    `along` grows from 0 to 1 over the length in which the furrow gets its depth, and falls again at
    its end; `beyond` grows at the furrow's wall; `over` grows where the turned slice begins, which
    lies as high as the field. They refer to this pass's start, line and direction of travel.

    Returns:
        height_m (<= 0), dh/ds, dh/dt on the ground's axes.
    """
    side = field[Field.FURROW_SIDE]
    if side == 0.0:
        return 0.0, 0.0, 0.0
    way, aside_m = field[Field.PASS_WAY], beside_pass(field, t_m)
    done_m, ramp_m = way * (s_m - field[Field.PASS_S_M]), field[Field.FURROW_RAMP_M]
    begun = (done_m - field[Field.FURROW_START_M]) / ramp_m
    left = (field[Field.FURROW_END_M] - done_m) / ramp_m + 1.0
    along, along_slope = smooth_step(min(begun, left))
    past_m = side * aside_m - field[Field.FURROW_EDGE_M]
    beyond, beyond_slope = smooth_step(past_m / EDGE_M)
    over, over_slope = smooth_step((past_m - field[Field.FURROW_WIDTH_M]) / SLICE_SIDE_M)
    across = beyond_slope * (1.0 - over) / EDGE_M - beyond * over_slope / SLICE_SIDE_M
    depth = field[Field.FURROW_DEPTH_M]
    ahead = way if begun <= left else -way
    return (
        -depth * along * beyond * (1.0 - over),
        -depth * beyond * (1.0 - over) * along_slope * ahead / ramp_m,
        -depth * along * across * side * way,
    )


@inlined_law
def smooth_step(x: float) -> tuple[float, float]:
    """x**2 (3 - 2 x) between 0 and 1, and its derivative."""
    if x <= 0.0:
        return 0.0, 0.0
    if x >= 1.0:
        return 1.0, 0.0
    return x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)


@inlined_law
def node(i: int, count: int, repeats: bool) -> int:
    """Index in [0, count) of node i: modulo `count` where the map repeats, else clipped."""
    if 0 <= i < count:
        return i
    return i % count if repeats else min(max(i, 0), count - 1)


@law
def on_map(
    field: Array, which: int, nodes: Array, s_m: float, t_m: float
) -> tuple[float, float, float]:
    """Value of a map at a place and its slopes; 0 without a map.

    Args:
        field: the ground's part of the block.
        which: index of the map's first number: Field.HEIGHTS or Field.MIXTURE.
        nodes: the model's hfield_data.
        s_m, t_m: the place, ground axes.

    Returns:
        f, df/ds, df/dt.
    """
    if field[which + Grid.ROWS] == 0.0:
        return 0.0, 0.0, 0.0
    return on_nodes(field, which, int(field[which + Grid.FIRST]), nodes, s_m, t_m)


@inlined_law
def on_nodes(
    field: Array, which: int, first: int, nodes: Array, s_m: float, t_m: float
) -> tuple[float, float, float]:
    """Value and slopes at a place, of nodes in hfield_data that have the layout of a map.

        f = sum over the 3 x 3 nearest nodes of B_k(v) B_m(u) f_km
        B_0 = 3/4 - a**2        B_-1 = (1/2 - a)**2 / 2        B_1 = (1/2 + a)**2 / 2

    This is the quadratic B-spline over the nodes f_km; u and v are the distances to the nearest
    node along s and t in cells, a either of them. It is the mean over one cell of the surface that
    is linear between nodes. Its slopes are continuous, so no force that follows them jumps; a plane
    stays a plane, and no value leaves the range of the nodes.

    Args:
        field, which, nodes, s_m, t_m: as for `on_map`.
        first: index of the first node in hfield_data.

    Returns:
        f, df/ds, df/dt, in the unit of the map.
    """
    columns, rows = int(field[which + Grid.COLUMNS]), int(field[which + Grid.ROWS])
    per_cell, repeats = 1.0 / field[which + Grid.CELL_M], field[which + Grid.REPEATS] != 0.0
    u = (s_m + field[Field.ORIGIN_S_M] - field[which + Grid.START_M]) * per_cell
    v = (t_m + field[Field.ORIGIN_T_M] - field[which + Grid.RIGHT_M]) * per_cell
    if not repeats:  # far beyond the border all is as at it
        u, v = min(max(u, -2.0), columns + 1.0), min(max(v, -2.0), rows + 1.0)
    nearest_u, nearest_v = math.floor(u + 0.5), math.floor(v + 0.5)
    a, b = u - nearest_u, v - nearest_v
    i, j = int(nearest_u), int(nearest_v)
    west, east = node(i - 1, columns, repeats), node(i + 1, columns, repeats)
    i = node(i, columns, repeats)
    w_m, w_0, w_p = 0.5 * (0.5 - a) * (0.5 - a), 0.75 - a * a, 0.5 * (0.5 + a) * (0.5 + a)
    d_m, d_0, d_p = a - 0.5, -2.0 * a, a + 0.5
    value = along_s = along_t = 0.0
    for k in range(-1, 2):
        row = first + node(j + k, rows, repeats) * columns
        f_m, f_0, f_p = nodes[row + west], nodes[row + i], nodes[row + east]
        line = w_m * f_m + w_0 * f_0 + w_p * f_p
        reach = 0.5 + k * b
        weight = 0.5 * reach * reach if k != 0 else 0.75 - b * b
        value += weight * line
        along_s += weight * (d_m * f_m + d_0 * f_0 + d_p * f_p)
        along_t += (k * reach if k != 0 else -2.0 * b) * line
    scale = field[which + Grid.RANGE]
    slope = scale * per_cell
    return field[which + Grid.LOW] + scale * value, slope * along_s, slope * along_t


@inlined_law
def soil_at(field: Array, soil: Array, nodes: Array, s_m: float, t_m: float, out: Array) -> None:
    """Write the parameters of the soil at a place to `out`.

        out = (1 - m) soil + m other        m the other soil's share by the map; 0 without a map

    The law is that of the soil with the larger share. Then two factors apply: one to friction,
    cohesion and tan(phi), one to cone index, k_c and k_phi. Each is the product of the factors of
    the patches (stretches of s) at the place and of 1 + cv f(s, t), f a random field.

    Args:
        field: part of the parameter block (`Field`): maps, patches, the other soil, seed.
        soil: part of the parameter block (`Soil`): the main soil.
        nodes: the model's hfield_data.
        s_m, t_m: the place, ground axes: along the course and to its left.
        out: written, laid out as `soil`.
    """
    for i in range(len(soil)):
        out[i] = soil[i]
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
    """Soil factor F of ASABE D497 at a place [-], mixed of both soils by the map's share.

    The arguments are as for `soil_at`.
    """
    share = on_map(field, Field.MIXTURE, nodes, s_m, t_m)[0]
    own = soil[Soil.DRAFT_SCALE]
    return own + share * (field[Field.OTHER + Soil.DRAFT_SCALE] - own)
