"""The ground as a plane, drawn by projecting every pixel onto it: exact, and no graphics driver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.camera.ground import SIDE, Ground, cover, ground, place
from twin.camera.pinhole import Array, Pinhole, View, exposed, ground_points
from twin.camera.soil_texture import TILE
from twin.compute.compiled import array_law

SUBFRAME_PX = 2.5
"""Longest path of the picture between two parts of an exposure [px]; a texel's and a pixel's width
together smooth that over."""
_SHIFT = TILE.bit_length() - 1


@dataclass(frozen=True)
class PlanarRenderer:
    """Rays through the pixels' centres meet the plane, where the texture is read bilinearly."""

    lens: Pinhole
    soil: Ground

    def radiance(self, view: View) -> NDArray[np.float32]:
        """Brightness of every pixel: the mean over the parts of the exposure."""
        parts = exposed(self.lens, view, SUBFRAME_PX)
        corners = self.lens.corners_px()
        seen = np.concatenate([ground_points(h, corners) for h in (parts[0], parts[-1])], axis=1)
        low_m, high_m = seen.min(axis=1), seen.max(axis=1)
        cover(self.soil, low_m, high_m)
        image = np.empty((self.lens.height_px, self.lens.width_px), np.float32)
        _project(self.soil.quads, _texel_from_pixel(parts, low_m, self.soil.texel_m), image)
        return image


def planar(lens: Pinhole, seed: int, height_m: float) -> PlanarRenderer:
    """The renderer for a camera about `height_m` above the ground of a seed."""
    return PlanarRenderer(lens, ground(seed, finest_m=height_m / lens.focal_px))


def _texel_from_pixel(ground_from_pixel: Array, low_m: Array, texel_m: float) -> Array:
    """Homographies from pixels to places in the window, near zero so that float32 is exact enough.

    The origin is moved by whole windows, which changes no place in it, to keep them positive.
    """
    origin = np.floor((low_m / texel_m - 8) / SIDE) * SIDE
    from_ground = np.array(
        [
            [1 / texel_m, 0.0, -origin[0] - 0.5],
            [0.0, 1 / texel_m, -origin[1] - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
    texel_from_pixel: Array = from_ground @ ground_from_pixel
    return texel_from_pixel


@array_law
def _project(quads: NDArray[np.uint32], parts: Array, image: NDArray[np.float32]) -> None:
    """Mean over the parts of the bilinear reading of the texture at each pixel's place.

    Places, reading and interpolation are loops of their own, so that each becomes vector code.
    """
    height, width = image.shape
    flat = quads.reshape(-1)
    share = np.float32(1.0 / len(parts))
    fx, fy = np.empty(width, np.float32), np.empty(width, np.float32)
    at, quad = np.empty(width, np.uint32), np.empty(width, np.uint32)
    for v in range(height):
        row = image[v]
        row[:] = 0.0
        for part in parts:
            _places(part, v, at, fx, fy)
            for u in range(width):
                quad[u] = flat[at[u]]
            for u in range(width):
                q = quad[u]
                a = np.float32(np.int32(q & np.uint32(255)))
                b = np.float32(np.int32((q >> np.uint32(8)) & np.uint32(255)))
                c = np.float32(np.int32((q >> np.uint32(16)) & np.uint32(255)))
                d = np.float32(np.int32(q >> np.uint32(24)))
                top, low = a + fx[u] * (b - a), c + fx[u] * (d - c)
                row[u] += share * (top + fy[u] * (low - top))


@array_law
def _places(
    part: Array,
    v: int,
    at: NDArray[np.uint32],
    fx: NDArray[np.float32],
    fy: NDArray[np.float32],
) -> None:
    """Texel left of and below each pixel's place in row v, and how far beyond it that lies."""
    ax, bx = np.float32(part[0, 0]), np.float32(part[0, 1] * v + part[0, 2])
    ay, by = np.float32(part[1, 0]), np.float32(part[1, 1] * v + part[1, 2])
    aw, bw = np.float32(part[2, 0]), np.float32(part[2, 1] * v + part[2, 2])
    mask, shift, slots = np.uint32(SIDE - 1), np.uint32(_SHIFT), np.uint32(SIDE // TILE)
    for u in range(len(at)):
        f = np.float32(np.int32(u))
        w = np.float32(1.0) / (aw * f + bw)
        x, y = (ax * f + bx) * w, (ay * f + by) * w
        i, j = np.int32(x), np.int32(y)  # never negative
        fx[u], fy[u] = x - np.float32(i), y - np.float32(j)
        r, c = np.uint32(np.uint32(j) & mask), np.uint32(np.uint32(i) & mask)
        slot = np.uint32(np.uint32(r >> shift) * slots + np.uint32(c >> shift))
        at[u] = np.uint32(np.uint32(slot << (shift + shift)) | place(r, c))
