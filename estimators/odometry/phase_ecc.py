"""Phase correlation of the gyro-derotated picture, refined by ECC: method (c), the recommended.

Sources: Kuglin and Hines 1975 (phase correlation); Evangelidis and Psarakis 2008 (ECC).
"""

from __future__ import annotations

import functools
import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from estimators.odometry.lens import Array, Picture, centre_px
from estimators.odometry.match import Match

ITERATIONS, CONVERGED = 12, 1e-3
SMOOTHED_PX = 9
"""Width of the Gaussian that ECC smooths both pictures with, 1.7 px of sd. What is finer than a few
pixels pulls a displacement towards whole ones, in every frame alike: at 5 px wide by 0.006 px rms,
so by 0.003; noise that differs from frame to frame grows to 0.004, which a mean takes out."""
LEAST_PSR = 8.0
"""Peak-to-sidelobe ratio below which a peak is chance: the highest of 64 000 normal numbers is at
4.2 sd, and of unrelated soil at most 6."""
LEAST_CORRELATION = 0.6
FARTHEST_PX = 3.0
"""Farther than this from the peak, ECC has found something else."""
FLOOR_PX = 0.006
"""sd of ECC's displacement on noise-free pictures: interpolation."""
PEAK_PX = 0.3
"""sd of the peak alone, measured between pixels and with 1 % of scale between the pictures."""
SMOOTHED_AREA_PX2 = 36.0
"""Pixels over which the smoothing makes noise one: 4 pi sd^2 of the Gaussian."""


def match(previous: Picture, current: Picture, turn_rad: float) -> Match | None:
    """The affine map from current to previous, or None.

    1. Turn the previous picture by the gyro's angle about the principal point.
    2. The peak of their phase correlation, under a Hann window, is the displacement.
    3. ECC refines all six numbers of the map; where it fails the peak stands.
    """
    start, psr = peak(previous, current, turn_rad)
    if psr < LEAST_PSR:
        return None
    refined = refine(previous, current, start)
    if refined is None:
        quality = min(1.0, psr / 100.0)
        return Match(
            previous_from_current=start, variance_px2=PEAK_PX**2, quality=quality, turns=False
        )
    warp, correlation = refined
    return Match(
        previous_from_current=warp,
        variance_px2=variance_px2(current, correlation),
        quality=correlation,
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


def refine(previous: Picture, current: Picture, start: Array) -> tuple[Array, float] | None:
    """The affine map of greatest correlation near `start`, and that correlation; None if none."""
    until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ITERATIONS, CONVERGED)
    first = start.astype(np.float32)
    try:
        correlation, warp = cv2.findTransformECC(
            current,
            previous,
            first,
            cv2.MOTION_AFFINE,
            until,
            _everywhere(current.shape),
            SMOOTHED_PX,
        )
    except cv2.error:  # says so when the correlation falls
        return None
    found = np.asarray(warp, np.float64)
    centre = np.append(centre_px(current.shape), 1.0)
    moved = float(np.linalg.norm((found - start) @ centre))
    if not (correlation >= LEAST_CORRELATION and moved <= FARTHEST_PX):
        return None
    return found, float(correlation)


def variance_px2(current: Picture, correlation: float) -> float:
    """Variance of ECC's displacement of the principal point, each axis [px^2].

        var = floor^2 + area (1 - rho^2) sd^2 / sum of squared slopes

    The second term is the Cramer-Rao bound of a displacement between pictures that differ by noise
    of variance (1 - rho^2) sd^2, correlated over `area`.
    """
    smooth = cv2.GaussianBlur(current, (SMOOTHED_PX, SMOOTHED_PX), 0)
    slopes = np.diff(smooth, axis=1)
    steep = max(float(np.vdot(slopes, slopes)), 1e-9)
    noise = max(0.0, 1.0 - correlation * correlation) * float(smooth.var())
    return FLOOR_PX**2 + SMOOTHED_AREA_PX2 * noise / steep


@functools.lru_cache(maxsize=4)
def _everywhere(shape: tuple[int, ...]) -> NDArray[np.uint8]:
    return np.full(shape, 255, np.uint8)


@functools.lru_cache(maxsize=4)
def _hann(shape: tuple[int, ...]) -> Picture:
    return np.asarray(cv2.createHanningWindow(shape[::-1], cv2.CV_32F), np.float32)
