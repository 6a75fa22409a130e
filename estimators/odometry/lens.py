"""From a frame to the picture a matcher works on, and from its pixels to metres."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import compiled
from twin.streams import CameraSetup

Array = NDArray[np.float64]
Picture = NDArray[np.float32]

WORKING_PX = 320
"""Least width of the picture that is matched."""
FLAT = 1.0
"""Least sd of a picture's brightness: below it there is nothing to see. The noise of a frame
averages out to about 0.4 at the working size."""

EVENED_PX = 29
"""Width of the box that brightness is evened out with, twice."""
LEVEL = 100.0
"""Brightness of an evened picture: a middle grey of bytes."""

BODY_FROM_IMAGE = np.array([[0.0, -1.0], [-1.0, 0.0]])
"""Right in the picture is body -y, down is body -x."""
CAMERA_FROM_BODY = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


class Reason(enum.IntEnum):
    """Why a frame gave no velocity."""

    USED = 0
    FIRST = 1
    """There is nothing to compare it with: the first frame, or the first after a long gap."""
    MISSING = 2
    FLAT = 3
    """Black, white or grey all over."""
    FROZEN = 4
    """The same as the frame before, to the bit: a camera that hangs."""
    SIZE = 5
    """Another size than the frame before, or not that of a picture of this lens."""
    UNMATCHED = 6
    """No displacement explains it well enough."""


@dataclass(frozen=True, kw_only=True)
class Lens:
    """Intrinsics, and where the camera hangs, nominally."""

    width_px: int
    height_px: int
    focal_px: float
    height_m: float
    """Above the ground."""
    height_sd: float = 0.01
    """sd of the height over the height: a chassis that bounces by 5 mm on 0.5 m."""

    @classmethod
    def of(cls, setup: CameraSetup) -> Lens:
        """The lens of a set-up."""
        return cls(
            width_px=setup.width_px,
            height_px=setup.height_px,
            focal_px=setup.focal_px,
            height_m=setup.height_m,
        )


def picture(frame: NDArray[np.uint8] | None, lens: Lens) -> tuple[Picture | None, Reason]:
    """The frame in grey at its working size, or why it cannot be used.

    The working size is the frame's over the largest whole number that leaves WORKING_PX: each
    pixel is the mean of a square, so no detail turns into something it was not.
    """
    if frame is None:
        return None, Reason.MISSING
    if frame.ndim == 3 and frame.shape[2] == 3:
        frame = np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY), np.uint8)
    if frame.ndim != 2 or not same_shape(frame, lens):
        return None, Reason.SIZE
    factor = max(1, frame.shape[1] // WORKING_PX)
    size = (frame.shape[1] // factor, frame.shape[0] // factor)
    small = np.empty(size[::-1], np.float32)
    _means(np.ascontiguousarray(frame, np.uint8), factor, small)
    if not float(small.std()) >= FLAT:
        return None, Reason.FLAT
    return evened(small), Reason.USED


@compiled
def _means(frame: NDArray[np.uint8], factor: int, out: Picture) -> None:
    """Means of squares of pixels; what is left over at the right and below is left out.

    Sums of bytes are whole numbers, so their order changes no bit.
    """
    share = np.float32(1.0 / (factor * factor))
    sums = np.empty(out.shape[1] * factor, np.int32)
    for j in range(out.shape[0]):
        sums[:] = 0
        for r in range(j * factor, (j + 1) * factor):
            row = frame[r]
            for c in range(len(sums)):
                sums[c] += np.int32(row[c])
        for i in range(out.shape[1]):
            total = np.int32(0)
            for c in range(i * factor, (i + 1) * factor):
                total += sums[c]
            out[j, i] = np.float32(total) * share


def evened(small: Picture) -> Picture:
    """Brightness over its local mean, times LEVEL.

    A lens lets less light through towards the corners. That shade stands still while the ground
    moves, and would pull every displacement towards zero: cos^4 by 0.1 % of 20 px, with this 0.04.
    """
    box = (EVENED_PX, EVENED_PX)
    around = cv2.blur(cv2.blur(small, box), box)  # twice is nearly a Gaussian
    return np.asarray(LEVEL * small / np.maximum(around, 1.0), np.float32)


def same_shape(frame: NDArray[np.uint8], lens: Lens) -> bool:
    """Whether the frame has the lens's proportions, so that it can be its picture, binned."""
    height, width = frame.shape[:2]
    if min(height, width) < 32:
        return False
    return bool(abs(width * lens.height_px - height * lens.width_px) <= lens.width_px)


def centre_px(shape: tuple[int, ...]) -> Array:
    """Principal point (u, v) of a picture of this shape."""
    return np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])


def working_focal_px(lens: Lens, shape: tuple[int, ...]) -> float:
    """Focal length in pixels of a working picture."""
    return lens.focal_px * shape[1] / lens.width_px


def turn_of(rotation_vector: Array) -> Array:
    """Rotation matrix of a rotation vector (Rodrigues), shape (3, 3)."""
    matrix, _ = cv2.Rodrigues(np.asarray(rotation_vector, np.float64).reshape(3, 1))
    return np.asarray(matrix, np.float64)
