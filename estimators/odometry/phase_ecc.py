"""Phase correlation of the gyro-derotated picture, refined by ECC: method (c), the recommended.

Source: Kuglin and Hines 1975 (phase correlation).
"""

from __future__ import annotations

import functools
import math

import cv2
import numpy as np
from scipy import fft

from estimators.odometry.lens import Array, Picture, centre_px
from estimators.odometry.match import Match
from estimators.odometry.symmetric import EVERY_PX, SMOOTHED_PX, Found, find, smoothed

LEAST_PSR = 8.0
"""Peak-to-sidelobe ratio below which a peak is chance: the highest of 64 000 normal numbers is at
4.2 sd, and of unrelated soil at most 6."""
LEAST_CORRELATION = 0.6
SURE_CORRELATION = 0.9
"""No other place on the ground looks like that."""
FARTHEST_PX = 3.0
"""Farther than this from the start, ECC has found something else."""
FLOOR_PX = 0.0005
"""sd of ECC's displacement on noise-free pictures: detail finer than the pixels."""
PEAK_PX = 0.3
"""sd of the peak alone, measured between pixels and with 1 % of scale between the pictures."""
POINTS_PER_ONE = 4.0 * math.pi * (SMOOTHED_PX**2 + 1.0 / 3.0) / EVERY_PX**2
"""Points over which smoothing makes noise one: the area 4 pi sd^2 of Gaussian and spline."""


def match(
    previous: Picture, current: Picture, turn_rad: float, moved_px: Array | None = None
) -> Match | None:
    """The affine map from current to previous, or None.

    Where the camera goes on as it did ECC finds the map at once, and its correlation says so. Else:

    1. Turn the previous picture by the gyro's angle about the principal point.
    2. The peak of their phase correlation, under a Hann window, is the displacement.
    3. Symmetric ECC refines all six numbers of the map; where it fails the peak stands.
    """
    if moved_px is not None:
        start = turned_about(centre_px(current.shape), turn_rad)
        start[:, 2] += moved_px
        refined = refine(previous, current, start)
        if refined is not None and refined.correlation >= SURE_CORRELATION:
            return _told(refined)
    start, psr = peak(previous, current, turn_rad)
    if psr < LEAST_PSR:
        return None
    refined = refine(previous, current, start)
    if refined is None:
        quality = min(1.0, psr / 100.0)
        return Match(
            previous_from_current=start, variance_px2=PEAK_PX**2, quality=quality, turns=False
        )
    return _told(refined)


def _told(refined: Found) -> Match:
    return Match(
        previous_from_current=refined.previous_from_current,
        variance_px2=FLOOR_PX**2 + POINTS_PER_ONE * refined.variance_px2,
        quality=refined.correlation,
        stretches=True,
    )


def peak(previous: Picture, current: Picture, turn_rad: float) -> tuple[Array, float]:
    """Turn and displacement of the phase-correlation peak as a map, and its PSR."""
    height, width = current.shape
    turn = turned_about(centre_px(current.shape), turn_rad)
    derotated = cv2.warpAffine(
        previous,
        turn,
        (width, height),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    surface = correlation_surface(np.asarray(derotated, np.float32), current)
    shift, psr = highest(surface)
    turn[:, 2] += turn[:, :2] @ shift
    return turn, psr


def turned_about(centre: Array, angle_rad: float) -> Array:
    """x -> R (x - centre) + centre as a map, shape (2, 3)."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    linear = np.array([[cos, -sin], [sin, cos]])
    return np.column_stack([linear, centre - linear @ centre])


def correlation_surface(a: Picture, b: Picture) -> Picture:
    """Inverse Fourier transform of the normalised cross-power spectrum A conj(B) / |A conj(B)|.

    Its peak at (u, v) means b(x) = a(x + (u, v)).
    """
    window = _hann(b.shape)
    cross = fft.rfft2((a - a.mean()) * window) * np.conj(fft.rfft2((b - b.mean()) * window))
    surface = fft.irfft2(cross / (np.abs(cross) + np.float32(1e-6)), s=b.shape)
    return np.asarray(surface, np.float32)


def highest(surface: Picture) -> tuple[Array, float]:
    """The peak's place (u, v) to a fraction of a pixel, and its peak-to-sidelobe ratio.

    The place is the centroid of the 5 by 5 around the highest; PSR = (peak - mean) / sd of all
    but those. Displacements beyond half the picture come out negative.
    """
    height, width = surface.shape
    row, column = divmod(int(np.argmax(surface)), width)
    rows, columns = np.arange(row - 2, row + 3), np.arange(column - 2, column + 3)
    around = surface[np.ix_(rows % height, columns % width)].astype(np.float64)
    weight = np.maximum(around, 0.0)
    place = np.array([weight.sum(axis=0) @ columns, weight.sum(axis=1) @ rows]) / weight.sum()
    count = surface.size - around.size
    mean = (float(surface.sum(dtype=np.float64)) - around.sum()) / count
    power = float(np.vdot(surface, surface)) - float((around * around).sum())
    spread = math.sqrt(max(power / count - mean * mean, 1e-30))
    size = np.array([width, height])
    wrapped = (place + size / 2) % size - size / 2
    return wrapped, (float(surface[row, column]) - mean) / spread


def refine(previous: Picture, current: Picture, start: Array) -> Found | None:
    """The affine map of greatest correlation near `start`; None if none."""
    found = find(smoothed(previous), smoothed(current), start)
    if found is None or not found.correlation >= LEAST_CORRELATION:
        return None
    centre = np.append(centre_px(current.shape), 1.0)
    moved = float(np.linalg.norm((found.previous_from_current - start) @ centre))
    return found if moved <= FARTHEST_PX else None


@functools.lru_cache(maxsize=4)
def _hann(shape: tuple[int, ...]) -> Picture:
    return np.asarray(cv2.createHanningWindow(shape[::-1], cv2.CV_32F), np.float32)
