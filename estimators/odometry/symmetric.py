"""The affine map between two pictures to a few ten-thousandths of a pixel: symmetric ECC.

The enhanced correlation coefficient is the correlation of two pictures once brightness and
contrast are taken out; Gauss-Newton steps make it greatest. Moving one picture alone, as is usual,
blurs that one by as much as its displacement is off a whole pixel, and pulls every displacement
towards whole ones, the same way in every frame of a steady drive. So each picture is moved by half,
one forwards and the other backwards: both are blurred alike and that pull is gone. What remains
comes from detail finer than the pixels, which the smoothing takes out.

Source: Evangelidis and Psarakis 2008 (ECC); Lucas and Kanade 1981.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from estimators.odometry.lens import Array, Picture, centre_px
from twin.compute.compiled import compiled

Vector = NDArray[np.float32]

SMOOTHED_PX = 2.0
"""sd of the Gaussian that both pictures are smoothed with."""
EDGE_PX = 16
"""Pixels along the edges that are left out: their brightness is evened by what lies on one side."""
EVERY_PX = 2
"""Step between the smoothed pixels that are used, along each axis [px]."""
COARSE_PX, NEAR_PX = 4, 0.1
"""Coarser step [px] that is used until an iteration moves by less than the second number [px]."""
STEPS, CONVERGED_PX = 10, 0.02
"""A step leaves less than a hundredth of what it was."""
UNKNOWNS = 8


@dataclass(frozen=True, kw_only=True)
class Found:
    """A map and how well the pictures agree under it."""

    previous_from_current: Array
    """Shape (2, 3)."""
    correlation: float
    variance_px2: float
    """Of the displacement of the principal point, each axis, if what the pictures differ by were
    independent from point to point."""


def smoothed(picture: Picture) -> Picture:
    """Spline coefficients of the smoothed picture, shape as it."""
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), SMOOTHED_PX), np.float32)


def find(previous: Picture, current: Picture, start: Array) -> Found | None:
    """The affine map of greatest correlation near `start`; None where the pictures do not overlap.

    About points x of a picture halfway between the two, with centre c and half width s,

        u(x) = (u, v) + [[p, q], [r, t]] (x - c) / s
        P(x + u / 2) = (1 + gain) C(x - u / 2) + offset

    P and C are cubic B-splines whose coefficients are the smoothed pictures, so their slopes are
    exact. One step solves the least squares of C - P on the eight unknowns.

    Args:
        previous: `smoothed`.
        current: `smoothed`, of the same shape.
        start: previous from current, shape (2, 3).
    """
    height, width = current.shape
    unknown = np.zeros(UNKNOWNS)
    unknown[:6] = halves(start, current.shape)
    edge = edge_px(current.shape)
    every = COARSE_PX
    for _ in range(STEPS):
        sums = _sums(previous, current, unknown[:6].astype(np.float32), edge, every)
        count = sums[7, 7]
        if count < 10 * UNKNOWNS:
            return None
        try:
            inverse = np.linalg.inv(sums[:8, :8])
        except np.linalg.LinAlgError:
            return None
        change = inverse @ sums[:8, 8]
        unknown[:6] += change[:6]
        if not np.all(np.abs(unknown[:2]) < (width, height)):
            return None
        step_px = float(np.abs(change[:2]).max())
        if every == EVERY_PX and step_px < CONVERGED_PX:
            break
        every = EVERY_PX if step_px < NEAR_PX else every
    left = max(0.0, float(sums[8, 8] - change @ sums[:8, 8])) / count
    both = 4.0 * (sums[6, 6] / count - (sums[6, 7] / count) ** 2)
    return Found(
        previous_from_current=whole(unknown[:6], current.shape),
        correlation=float((both - left) / max(both + left, 1e-12)),
        variance_px2=left * 0.5 * float(inverse[0, 0] + inverse[1, 1]),
    )


def edge_px(shape: tuple[int, ...]) -> int:
    """Along each edge of a picture of this shape, what no point is taken of."""
    return min(EDGE_PX, min(shape) // 8)


def halves(warp: Array, shape: tuple[int, ...]) -> Array:
    """u, v, p, q, r, t of the map previous from current: W = (1 + U / 2) (1 - U / 2)^-1."""
    centre, half = centre_px(shape), np.eye(2) + 0.5 * (warp[:, :2] - np.eye(2))
    moved = np.linalg.solve(half, warp[:, :2] @ centre + warp[:, 2] - centre)
    linear = (warp[:, :2] - np.eye(2)) @ np.linalg.inv(half)
    return np.concatenate([moved, linear.ravel() * shape[1] / 2.0])


def whole(unknown: Array, shape: tuple[int, ...]) -> Array:
    """The map previous from current, shape (2, 3): the inverse of `halves`."""
    centre = centre_px(shape)
    linear = unknown[2:6].reshape(2, 2) * 2.0 / shape[1]
    turned = (np.eye(2) + 0.5 * linear) @ np.linalg.inv(np.eye(2) - 0.5 * linear)
    moved = 0.5 * (np.eye(2) + turned) @ unknown[:2]
    return np.column_stack([turned, moved + centre - turned @ centre])


@compiled
def _sums(previous: Picture, current: Picture, unknown: Vector, edge: int, every: int) -> Array:
    """Sums of products of the eight columns and of C - P, over points both pictures show.

    The columns are the derivatives of P - C by u, v, p, q, r, t, then the mean of both, and one.
    """
    height, width = current.shape
    one, half = np.float32(1.0), np.float32(0.5)
    u0, v0, p, q, r, t = unknown
    centre_x, centre_y = half * np.float32(width - 1), half * np.float32(height - 1)
    scale = np.float32(2.0) / np.float32(width)
    least = np.float32(edge)
    most_x, most_y = np.float32(width - 1 - edge), np.float32(height - 1 - edge)
    columns = np.zeros(9, np.float32)
    row_sums = np.zeros((9, 9), np.float32)
    sums = np.zeros((9, 9))
    for j in range(edge, height - edge, every):
        row_sums[:, :] = 0.0
        for i in range(edge, width - edge, every):
            x, y = np.float32(i), np.float32(j)
            a, b = (x - centre_x) * scale, (y - centre_y) * scale
            u, v = half * (u0 + p * a + q * b), half * (v0 + r * a + t * b)
            if not (least <= min(x - u, x + u) and max(x - u, x + u) < most_x):
                continue
            if not (least <= min(y - v, y + v) and max(y - v, y + v) < most_y):
                continue
            before, before_x, before_y = _read(previous, x + u, y + v)
            now, now_x, now_y = _read(current, x - u, y - v)
            along, down = half * (before_x + now_x), half * (before_y + now_y)
            columns[0], columns[1] = along, down
            columns[2], columns[3] = along * a, along * b
            columns[4], columns[5] = down * a, down * b
            columns[6], columns[7], columns[8] = half * (before + now), one, now - before
            for m in range(9):
                for n in range(m, 9):
                    row_sums[m, n] += columns[m] * columns[n]
        sums += row_sums
    for m in range(9):
        for n in range(m):
            sums[m, n] = sums[n, m]
    return sums


@compiled
def _read(
    coefficients: Picture, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32]:
    """Value and slopes of the cubic B-spline at a place inside, one pixel from the edges."""
    i, j = np.int64(x), np.int64(y)
    a, b, c, d = _weights(x - np.float32(i))
    e, f, g, h = _slopes(x - np.float32(i))
    down, steep = _weights(y - np.float32(j)), _slopes(y - np.float32(j))
    value, along, below = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for k in range(4):
        row = coefficients[j - 1 + k]
        level = a * row[i - 1] + b * row[i] + c * row[i + 1] + d * row[i + 2]
        value += down[k] * level
        below += steep[k] * level
        along += down[k] * (e * row[i - 1] + f * row[i] + g * row[i + 1] + h * row[i + 2])
    return value, along, below


@compiled
def _weights(f: np.float32) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Of the uniform cubic B-spline at fraction f, for the coefficients at -1, 0, 1, 2."""
    sixth, three, four = np.float32(1.0 / 6.0), np.float32(3.0), np.float32(4.0)
    g = np.float32(1.0) - f
    return (
        g * g * g * sixth,
        (four - three * f * f * (g + np.float32(1.0))) * sixth,
        (four - three * g * g * (f + np.float32(1.0))) * sixth,
        f * f * f * sixth,
    )


@compiled
def _slopes(f: np.float32) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Derivatives of `_weights`."""
    half, three = np.float32(0.5), np.float32(3.0)
    g = np.float32(1.0) - f
    return (
        -half * g * g,
        half * f * (three * f - np.float32(4.0)),
        half * g * (three * f + np.float32(1.0)),
        half * f * f,
    )
