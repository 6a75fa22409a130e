"""Soil seen from close by: brightness as a function of place and seed, made a tile at a time.

Height of the surface = noise of all scales, clods on it, stalks of straw on those. Brightness =
what the surface reflects, times the sun on its slope, times what pits let in. A tile is computed
from hashes of lattice nodes alone, so it is the same whenever and in whatever order it is made.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.camera.chance import keys, mixed, node, uniform
from twin.compute.compiled import array_law

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float32]

TEXEL_M = 0.25e-3
"""Finest texel [m]: 1.5 per pixel of a 53-degree lens at 0.5 m."""
TILE = 128
"""Texels along the side of a tile."""
OCTAVES = 10
"""Noise of lattices 2, 4, ... 1024 texels wide: 0.5 mm to 0.26 m."""
ROUGHNESS = 0.065
"""Height sd of an octave over its lattice width; assumed, a seed bed after harrowing."""
CLODS_M = (0.045, 0.020, 0.009, 0.004)
"""Width of the cells that may hold a clod of each class [m]; assumed."""
CLOD_CHANCE = (0.3, 0.5, 0.5, 0.5)
STALK_CELL_M = 0.055
STALK_CHANCE = 0.25
"""A stalk in every fourth cell: 80 per square metre."""
KEYS = 32
"""Number of hash keys a texture needs."""
_RAGGED = 0.7
"""How far bumps move the rim of a clod, of its radius squared."""
_SUN = (0.58, 0.42, 0.70)
"""Towards the sun: 45 degrees high; shadows lie towards negative x and y."""


def texture_keys(seed: int) -> NDArray[np.uint32]:
    """The hash keys of a seed's ground, shape (KEYS,)."""
    return keys(seed, "ground", 0, KEYS)


@array_law
def tile(key: NDArray[np.uint32], ix: int, iy: int, level: int) -> Bytes:
    """Brightness of tile (ix, iy) and of the first texels beyond it, shape (TILE + 1, TILE + 1).

    Row is y, column is x.

    Args:
        key: `texture_keys`.
        ix: texels ix TILE to (ix + 1) TILE along x.
        iy: the same along y.
        level: texels are TEXEL_M 2^level wide, and what is finer than two of them is left out.
    """
    n = TILE + 3  # a margin of one texel, for slopes
    x0, y0 = ix * TILE - 1, iy * TILE - 1
    texel_mm = np.float32(TEXEL_M * 1e3 * 2.0**level)
    coarse = np.zeros((n, n), np.float32)
    fine = np.zeros((n, n), np.float32)
    for octave in range(OCTAVES - 1, level - 1, -1):
        width_mm = np.float32(TEXEL_M * 1e3 * 2.0 ** (octave + 1))
        target = coarse if octave > 6 else fine
        add_noise(target, key[octave], x0, y0, octave + 1 - level, np.float32(ROUGHNESS) * width_mm)
    height = coarse + fine
    reflects = np.full((n, n), np.float32(0.36))
    _add_clods(height, fine, reflects, key, x0, y0, texel_mm)
    _add_stalks(height, reflects, key, x0, y0, texel_mm)
    grain = np.zeros((n, n), np.float32)
    add_noise(grain, key[20], x0, y0, max(1, 1 - level), np.float32(0.05))
    add_noise(grain, key[21], x0, y0, max(1, 5 - level), np.float32(0.04))
    add_noise(grain, key[22], x0, y0, max(1, 8 - level), np.float32(0.05))
    return _lit(height, coarse, reflects, grain, texel_mm)


@array_law
def add_noise(out: Floats, key: np.uint32, x0: int, y0: int, shift: int, sd: np.float32) -> None:
    """Add smooth noise of a lattice 2^shift texels wide: cubic B-splines of uniform numbers.

        f(x, y) = sd sum_ij b(x - i) b(y - j) u_ij / norm

    `norm` makes the mean variance over a cell 1 times sd^2 (u has variance 1/12, the mean of the
    sum of b^2 along an axis is 0.4794).
    """
    n = out.shape[0]
    mask = (1 << shift) - 1
    step = np.float32(1.0 / (1 << shift))
    i0, j0 = (x0 >> shift) - 1, (y0 >> shift) - 1
    columns = ((x0 + n - 1) >> shift) - i0 + 3
    rows = ((y0 + n - 1) >> shift) - j0 + 3
    scale = np.float32(sd * math.sqrt(12.0) / 0.4794)
    across = np.empty((rows, n), np.float32)
    nodes = np.empty(columns, np.float32)
    first, weights = np.empty(n, np.int32), np.empty((4, n), np.float32)
    for c in range(n):
        x = x0 + c
        first[c] = (x >> shift) - 1 - i0
        weights[0, c], weights[1, c], weights[2, c], weights[3, c] = _spline(
            np.float32(x & mask) * step
        )
    w0, w1, w2, w3 = weights[0], weights[1], weights[2], weights[3]
    for j in range(rows):
        for i in range(columns):
            nodes[i] = (uniform(node(key, i0 + i, j0 + j)) - np.float32(0.5)) * scale
        line = across[j]
        for c in range(n):
            i = first[c]
            line[c] = (
                w0[c] * nodes[i]
                + w1[c] * nodes[i + 1]
                + w2[c] * nodes[i + 2]
                + w3[c] * nodes[i + 3]
            )
    for r in range(n):
        y = y0 + r
        j = (y >> shift) - 1 - j0
        a, b, d, e = _spline(np.float32(y & mask) * step)
        r0, r1, r2, r3, row = across[j], across[j + 1], across[j + 2], across[j + 3], out[r]
        for c in range(n):
            row[c] += a * r0[c] + b * r1[c] + d * r2[c] + e * r3[c]


@array_law
def _spline(f: np.float32) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Weights of the uniform cubic B-spline at fraction f."""
    one, sixth = np.float32(1.0), np.float32(1.0 / 6.0)
    g = one - f
    return (
        g * g * g * sixth,
        (np.float32(4.0) + np.float32(3.0) * f * f * (f - np.float32(2.0))) * sixth,
        (np.float32(4.0) + np.float32(3.0) * g * g * (g - np.float32(2.0))) * sixth,
        f * f * f * sixth,
    )


@array_law
def _add_clods(
    height: Floats,
    bumps: Floats,
    reflects: Floats,
    key: NDArray[np.uint32],
    x0: int,
    y0: int,
    texel_mm: np.float32,
) -> None:
    """Lay clods of every class on the ground, the large ones first."""
    n = height.shape[0]
    for kind in range(len(CLODS_M)):
        cell = round(CLODS_M[kind] * 1e3 / texel_mm)
        if cell < 8:
            continue
        reach = cell  # a clod never reaches farther from its centre
        for j in range((y0 - reach) // cell, (y0 + n + reach) // cell + 1):
            for i in range((x0 - reach) // cell, (x0 + n + reach) // cell + 1):
                h = node(key[10 + kind], i, j)
                if uniform(h) < CLOD_CHANCE[kind]:
                    _add_clod(height, bumps, reflects, h, i, j, cell, x0, y0, texel_mm)


@array_law
def _add_clod(
    height: Floats,
    bumps: Floats,
    reflects: Floats,
    h: np.uint32,
    i: int,
    j: int,
    cell: int,
    x0: int,
    y0: int,
    texel_mm: np.float32,
) -> None:
    """One clod: an ellipsoid whose outline the bumps of the ground make ragged."""
    n = height.shape[0]
    h1 = mixed(np.uint32(h + np.uint32(1)))
    h2 = mixed(np.uint32(h + np.uint32(2)))
    h3 = mixed(np.uint32(h + np.uint32(3)))
    h4 = mixed(np.uint32(h + np.uint32(4)))
    cx, cy = (i + uniform(h1)) * cell - x0, (j + uniform(h2)) * cell - y0
    size = uniform(h3)
    radius = np.float32(cell * (0.18 + 0.35 * size * size))
    angle = 2.0 * math.pi * uniform(h4)
    long = 1.0 + 0.5 * uniform(mixed(h4))
    cos, sin = np.float32(math.cos(angle) / radius), np.float32(math.sin(angle) / radius)
    long = np.float32(long)
    rise_mm = np.float32((0.35 + 0.35 * uniform(h2 ^ h4)) * radius * texel_mm)
    ragged = np.float32(1.7 / rise_mm)
    shade = np.float32(0.05 * (uniform(h1 ^ h2) - 0.5))
    reach = math.ceil(math.sqrt(1.0 + _RAGGED) * radius)
    none, most = np.float32(0.0), np.float32(_RAGGED)
    first, last = max(0, int(cx) - reach), min(n, int(cx) + reach + 1)
    for r in range(max(0, int(cy) - reach), min(n, int(cy) + reach + 1)):
        dy = np.float32(r - cy)
        heights, shades, bump = height[r, first:last], reflects[r, first:last], bumps[r, first:last]
        for c in range(last - first):  # without a branch, so that it becomes vector code
            dx = np.float32(np.int32(first + c) - cx)
            along, aside = (cos * dx + sin * dy), (cos * dy - sin * dx) * long
            rim = min(max(ragged * bump[c], -most), most)
            room = np.float32(1.0) - along * along - aside * aside + rim
            dome = min(np.float32(1.6) * room, np.float32(0.4) + np.float32(0.6) * room)
            heights[c] += rise_mm * dome if room > none else none
            shades[c] += shade if room > none else none


@array_law
def _add_stalks(
    height: Floats,
    reflects: Floats,
    key: NDArray[np.uint32],
    x0: int,
    y0: int,
    texel_mm: np.float32,
) -> None:
    """Lay stalks of straw on top."""
    n = height.shape[0]
    cell = round(STALK_CELL_M * 1e3 / texel_mm)
    for j in range((y0 - cell) // cell, (y0 + n + cell) // cell + 1):
        for i in range((x0 - cell) // cell, (x0 + n + cell) // cell + 1):
            h = node(key[15], i, j)
            if uniform(h) < STALK_CHANCE:
                _add_stalk(height, reflects, h, i, j, cell, x0, y0, texel_mm)


@array_law
def _add_stalk(
    height: Floats,
    reflects: Floats,
    h: np.uint32,
    i: int,
    j: int,
    cell: int,
    x0: int,
    y0: int,
    texel_mm: np.float32,
) -> None:
    """One stalk: a slightly bent half cylinder with blunt ends, lighter than the soil."""
    n = height.shape[0]
    h1 = mixed(np.uint32(h + np.uint32(1)))
    h2 = mixed(np.uint32(h + np.uint32(2)))
    h3 = mixed(np.uint32(h + np.uint32(3)))
    h4 = mixed(np.uint32(h + np.uint32(4)))
    cx, cy = (i + uniform(h1)) * cell - x0, (j + uniform(h2)) * cell - y0
    angle = 2.0 * math.pi * uniform(h3)
    cos, sin = np.float32(math.cos(angle)), np.float32(math.sin(angle))
    share = uniform(h4)
    half_length = np.float32((4.0 + 30.0 * share * share) / texel_mm)
    half_width = np.float32((0.5 + 1.0 * uniform(mixed(h4))) / texel_mm)
    bend = np.float32(0.25 * (uniform(h1 ^ h3) - 0.5)) / half_length
    straw = np.float32(0.5 + 0.25 * uniform(h2 ^ h3))
    reach_x = int(abs(cos) * half_length + half_width * 4) + 1
    reach_y = int(abs(sin) * half_length + half_width * 4) + 1
    for r in range(max(0, int(cy) - reach_y), min(n, int(cy) + reach_y + 1)):
        for c in range(max(0, int(cx) - reach_x), min(n, int(cx) + reach_x + 1)):
            dx, dy = np.float32(c - cx), np.float32(r - cy)
            along = cos * dx + sin * dy
            aside = abs(cos * dy - sin * dx + bend * along * along)
            inside = min(half_width - aside, half_length - abs(along))
            cover = min(max(inside + np.float32(0.5), np.float32(0.0)), np.float32(1.0))
            if cover > np.float32(0.0):
                ratio = min(aside / half_width, np.float32(1.0))
                bulge = np.float32(math.sqrt(np.float32(1.0) - ratio * ratio))
                height[r, c] += cover * half_width * np.float32(texel_mm) * bulge
                reflects[r, c] += cover * (straw - reflects[r, c])


@array_law
def _lit(
    height: Floats, coarse: Floats, reflects: Floats, grain: Floats, texel_mm: np.float32
) -> Bytes:
    """Brightness: reflectance, Lambert's law on the slope, less light in pits.

    B = 255 (rho + grain) (sky pit + sun max(0, n . s))
    """
    side = height.shape[0] - 2
    out = np.empty((side, side), np.uint8)
    half = np.float32(0.5 / texel_mm)
    sx, sy, sz = np.float32(_SUN[0]), np.float32(_SUN[1]), np.float32(_SUN[2])
    for r in range(side):
        for c in range(side):
            zx = (height[r + 1, c + 2] - height[r + 1, c]) * half
            zy = (height[r + 2, c + 1] - height[r, c + 1]) * half
            facing = (sz - sx * zx - sy * zy) / np.float32(math.sqrt(1.0 + zx * zx + zy * zy))
            above = height[r + 1, c + 1] - coarse[r + 1, c + 1]
            pit = np.float32(0.5) + np.float32(0.5) * above / (np.float32(3.0) + abs(above))
            sun = max(facing, np.float32(0.0))
            light = np.float32(0.25) + np.float32(0.55) * pit + np.float32(0.85) * sun
            bright = np.float32(255.0) * (reflects[r + 1, c + 1] + grain[r + 1, c + 1]) * light
            out[r, c] = np.uint8(min(max(bright, np.float32(0.0)), np.float32(255.0)))
    return out
