"""The ground as a function of place.

Random fields made by hashing, so a run can be repeated over it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from twin.physics.block import Field, Soil
from twin.physics.compiled import law
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
SPREAD = 2.2
"""Variance of an octave of lattice waves over that of the spectrum it is to give along a line."""
STRENGTH, RIPPLE, ROCKS, WAVES = 101, 202, 303, 404
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
def furrow(field: Array, s_m: float, t_m: float) -> tuple[float, float]:
    """Height of the furrow's bottom below the field, and its slope along the course.

    The wheel path of the last pass: beyond its wall, from where that pass got its depth.

    Returns:
        height_m (<= 0), dh/ds.
    """
    side = field[Field.FURROW_SIDE]
    if side == 0.0:
        return 0.0, 0.0
    beyond = (side * t_m - field[Field.FURROW_EDGE_M]) / EDGE_M
    along = (s_m - field[Field.FURROW_START_M]) / field[Field.FURROW_RAMP_M]
    if beyond <= 0.0 or along <= 0.0:
        return 0.0, 0.0
    depth = field[Field.FURROW_DEPTH_M] * min(1.0, beyond)
    if along >= 1.0:
        return -depth, 0.0
    slope = 6.0 * along * (1.0 - along) / field[Field.FURROW_RAMP_M]
    return -depth * along * along * (3.0 - 2.0 * along), -depth * slope


@law
def wave(seed: float, s_m: float, t_m: float, length_m: float) -> tuple[float, float, float]:
    """Smooth random surface of unit mean square, nodes `length_m` apart, and its slopes.

    h = k sum_i w_i g_i with smoothstep weights; k makes its variance, averaged over place, one.

    Returns:
        h, dh/ds, dh/dt.
    """
    u, v = s_m / length_m, t_m / length_m
    iu, iv = math.floor(u), math.floor(v)
    a, b = u - iu, v - iv
    da, db = 6.0 * a * (1.0 - a), 6.0 * b * (1.0 - b)
    a, b = a * a * (3.0 - 2.0 * a), b * b * (3.0 - 2.0 * b)
    jx, jy = np.int64(iu), np.int64(iv)
    g00, g10 = node_value(seed, jx, jy), node_value(seed, jx + 1, jy)
    g01, g11 = node_value(seed, jx, jy + 1), node_value(seed, jx + 1, jy + 1)
    near, far = g00 + a * (g10 - g00), g01 + a * (g11 - g01)
    along = (1.0 - b) * (g10 - g00) + b * (g11 - g01)
    k = 35.0 / 26.0  # the mean of (w**2 + (1 - w)**2) over smoothstep is 26/35, in each direction
    return (
        k * (near + b * (far - near)),
        k * da * along / length_m,
        k * db * (far - near) / length_m,
    )


@law
def roughness(field: Array, s_m: float, t_m: float) -> tuple[float, float, float]:
    """Height of a rough ground above its plane, and its slopes, at a place.

    Octaves of random waves whose variances go as ISO 8608 gives them:

        G_d(n) = G_d(n0) (n / n0)**-2        var[n, 2 n] = G_d(n0) n0**2 / (2 n)

    times 2.2, because waves on a lattice spread to longer ones as well. Along any line their sum
    has G_d within a fifth from 0.08 to 0.8 cycles per metre and fades at both ends: there are no
    hills, and shorter waves vanish under the tyre's contact.

    Returns:
        h, dh/ds, dh/dt.
    """
    scale = field[Field.ROUGHNESS_M]
    if scale == 0.0:
        return 0.0, 0.0, 0.0
    s, t = s_m + field[Field.ORIGIN_S_M], t_m + field[Field.ORIGIN_T_M]
    height = slope_s = slope_t = 0.0
    cycles = 0.0625
    for octave in range(5):
        sd = scale * math.sqrt(SPREAD / (2.0 * cycles))
        length_m = 0.5 / (math.sqrt(2.0) * cycles)
        h, h_s, h_t = wave(field[Field.SEED] + WAVES + octave, s, t, length_m)
        height, slope_s, slope_t = height + sd * h, slope_s + sd * h_s, slope_t + sd * h_t
        cycles *= 2.0
    return height, slope_s, slope_t


@law
def surface(field: Array, s_m: float, t_m: float) -> tuple[float, float, float]:
    """Height of the ground at a place, furrow and roughness together, and its slopes."""
    height, slope_s, slope_t = roughness(field, s_m, t_m)
    bottom, slope = furrow(field, s_m, t_m)
    return height + bottom, slope_s + slope, slope_t


@law
def soil_at(field: Array, soil: Array, s_m: float, t_m: float, out: Array) -> None:
    """The soil's numbers at a place: patches, and strength that varies from place to place."""
    out[:] = soil[:]
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
