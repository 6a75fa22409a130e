"""The window of ground texture around the camera, kept in a buffer that wraps around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.camera.soil_texture import TEXEL_M, TILE, texture_keys, tile
from twin.compute.compiled import array_law
from twin.errors import OutOfRange

Array = NDArray[np.float64]

SIDE = 4096
"""Texels along the side of the window: 1.02 m of the finest."""
_SLOTS = SIDE // TILE
_BLOCK = np.uint32(TILE - 4)
_SHIFT = TILE.bit_length() - 1


@dataclass(frozen=True)
class Ground:
    """Texture of a seed's ground; a cache, so its contents never depend on what was asked before.

    The centre of texel (i, j) is at (i, j) + 1/2 texels.
    """

    key: NDArray[np.uint32]
    level: int
    quads: NDArray[np.uint32]
    """The window, a slot for each tile, shape (SIDE / TILE, SIDE / TILE, TILE^2). A quad is a texel
    and its neighbours at x + 1, y + 1 and both, a byte each from the lowest, so that a bilinear
    reading loads one number. In a tile they are stored in blocks of 4 by 4, a cache line each, so
    that no heading reads slower than another."""
    owner: NDArray[np.int64]
    """Which tile (x, y) each slot of the window holds, shape (SIDE / TILE, SIDE / TILE, 2)."""

    @property
    def texel_m(self) -> float:
        """Width of a texel [m]."""
        return float(TEXEL_M * 2.0**self.level)


def ground(seed: int, finest_m: float = TEXEL_M) -> Ground:
    """The ground of a seed, in texels no wider than `finest_m` where TEXEL_M allows."""
    level = max(0, int(np.floor(np.log2(max(finest_m, TEXEL_M) / TEXEL_M) + 1e-9)))
    nowhere = np.iinfo(np.int64).min
    return Ground(
        key=texture_keys(seed),
        level=level,
        quads=np.zeros((_SLOTS, _SLOTS, TILE * TILE), np.uint32),
        owner=np.full((_SLOTS, _SLOTS, 2), nowhere, np.int64),
    )


def cover(soil: Ground, low_m: Array, high_m: Array) -> None:
    """Make sure the window holds the rectangle low..high (x, y).

    Raises:
        OutOfRange: the rectangle is larger than the window.
    """
    first = np.floor(low_m / soil.texel_m / TILE - 0.02).astype(np.int64)
    last = np.floor(high_m / soil.texel_m / TILE + 0.02).astype(np.int64)
    if np.any(last - first >= _SLOTS):
        seen_m = float(np.max(high_m - low_m))
        limit_m = SIDE * soil.texel_m
        raise OutOfRange("ground in view", f"{seen_m:.2f} m", f"the {limit_m:.2f} m kept at once")
    _fill(soil.key, soil.level, soil.quads, soil.owner, first, last)


def patch(soil: Ground, x: int, y: int, side: int) -> NDArray[np.uint8]:
    """Texels x..x+side, y..y+side as one array, shape (side, side); all multiples of TILE."""
    blocks = [
        [
            tile(soil.key, i, j, soil.level)[:TILE, :TILE]
            for i in range(x // TILE, (x + side) // TILE)
        ]
        for j in range(y // TILE, (y + side) // TILE)
    ]
    return np.block(blocks)


@array_law
def _fill(
    key: NDArray[np.uint32],
    level: int,
    quads: NDArray[np.uint32],
    owner: NDArray[np.int64],
    first: NDArray[np.int64],
    last: NDArray[np.int64],
) -> None:
    slots = owner.shape[0]
    for j in range(first[1], last[1] + 1):
        for i in range(first[0], last[0] + 1):
            slot = owner[j % slots, i % slots]
            if slot[0] != i or slot[1] != j:
                _pack(tile(key, i, j, level), quads[j % slots, i % slots])
                slot[0], slot[1] = i, j


@array_law
def _pack(texels: NDArray[np.uint8], quads: NDArray[np.uint32]) -> None:
    for r in range(TILE):
        for c in range(TILE):
            low = np.uint32(texels[r, c]) | (np.uint32(texels[r, c + 1]) << np.uint32(8))
            high = np.uint32(texels[r + 1, c]) | (np.uint32(texels[r + 1, c + 1]) << np.uint32(8))
            quads[place(np.uint32(r), np.uint32(c))] = np.uint32(low | (high << np.uint32(16)))


@array_law
def place(row: np.uint32, column: np.uint32) -> np.uint32:
    """Where a quad is stored in its tile: blocks of 4 by 4, row by row."""
    block = np.uint32((row & _BLOCK) << np.uint32(_SHIFT)) | ((column & _BLOCK) << np.uint32(2))
    inner = np.uint32((row & np.uint32(3)) << np.uint32(2)) | (column & np.uint32(3))
    return np.uint32(block | inner)
