"""A pinhole camera over a plane: poses, and the homography from its pixels to the ground.

Camera axes: x to the right of the picture, y down, z out of the lens. Pixel (u, v) has its centre
at the whole numbers; the principal point is the middle of the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import OutOfRange

Array = NDArray[np.float64]

CAMERA_DOWN = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""body_from_camera of a camera that looks straight down, forward at the top of the picture."""


@dataclass(frozen=True, kw_only=True)
class Pinhole:
    """Size of the picture and focal length [px]."""

    width_px: int
    height_px: int
    focal_px: float

    @property
    def centre_px(self) -> tuple[float, float]:
        """Principal point (u, v) [px]."""
        return (self.width_px - 1) / 2, (self.height_px - 1) / 2

    def corners_px(self) -> Array:
        """The outer corners of the corner pixels, homogeneous, shape (3, 4)."""
        right, below = self.width_px - 0.5, self.height_px - 0.5
        return np.array(
            [[-0.5, right, right, -0.5], [-0.5, -0.5, below, below], [1.0, 1.0, 1.0, 1.0]]
        )


def focal_px(width_px: int, field_of_view_rad: float) -> float:
    """f = (W / 2) / tan(HFOV / 2) [px]."""
    return width_px / 2 / math.tan(field_of_view_rad / 2)


@dataclass(frozen=True, kw_only=True)
class View:
    """Pose of the camera at the middle of the exposure, and its motion, in ground axes.

    The ground plane is z = 0.
    """

    position_m: Array
    """Optical centre [m], shape (3,)."""
    ground_from_camera: Array
    """Rotation matrix, shape (3, 3)."""
    velocity_mps: Array
    """Velocity of the optical centre [m/s], shape (3,)."""
    spin_radps: Array
    """Angular velocity [rad/s], shape (3,)."""
    exposure_s: float = 0.0


def ground_from_pixel(lens: Pinhole, view: View, time_s: float = 0.0) -> Array:
    """Homography from a pixel (u, v, 1) [px] to the ground z = 0, (x, y, 1) [m].

        r = R K^-1,   H = [c_x r_z - c_z r_x;  c_y r_z - c_z r_y;  r_z] / r_zz

    K is the camera matrix, R the rotation from camera to ground axes and c the optical centre, both
    at `time_s`. r_x, r_y, r_z are the rows of r, and r_zz is the last element of r_z. H is
    projective: x and y are the first two components over the third.

    Args:
        lens: the camera.
        view: its pose and motion at the middle of the exposure.
        time_s: time after the middle of the exposure [s].

    Returns:
        Shape (3, 3).

    Raises:
        OutOfRange: the camera is not above the ground, or a corner of the picture does not see the
            ground or sees it at less than about 3 degrees.
    """
    u, v = lens.centre_px
    f = lens.focal_px
    ray = np.array([[1 / f, 0.0, -u / f], [0.0, 1 / f, -v / f], [0.0, 0.0, 1.0]])
    turn = rotation(view.spin_radps * time_s)
    r = turn @ view.ground_from_camera @ ray
    c = view.position_m + time_s * view.velocity_mps
    if c[2] <= 0.0 or np.max((r @ lens.corners_px())[2]) > -0.05:
        tilt_deg = math.degrees(math.acos(min(1.0, max(-1.0, -view.ground_from_camera[2, 2]))))
        raise OutOfRange(
            "camera",
            f"{c[2]:.3f} m above the ground and {tilt_deg:.1f} degrees from straight down",
            "what sees ground in the whole picture",
        )
    rows = np.array([c[0] * r[2] - c[2] * r[0], c[1] * r[2] - c[2] * r[1], r[2]])
    homography: Array = rows / r[2, 2]
    return homography


def exposed(lens: Pinhole, view: View, path_px: float) -> Array:
    """Homographies at the midpoints of s equal parts of an exposure, shape (s, 3, 3).

    s is the smallest number for which no corner of the picture moves by more than `path_px` within
    a part; 1 if nothing moves. Pixels of motion are metres on the ground times focal length over
    height.

    Args:
        lens: the camera.
        view: pose at the middle of the exposure, and motion.
        path_px: largest motion within a part [px].

    Raises:
        OutOfRange: a corner of the picture does not see the ground.
    """
    half_s = 0.5 * view.exposure_s
    ends = [ground_from_pixel(lens, view, t) for t in (-half_s, half_s)]
    seen_m = ground_points(ends[0], lens.corners_px()) - ground_points(ends[1], lens.corners_px())
    pixel_m = view.position_m[2] / lens.focal_px
    blur_px = float(np.max(np.hypot(seen_m[0], seen_m[1]))) / pixel_m
    parts = max(1, math.ceil(blur_px / path_px))
    times_s = ((np.arange(parts) + 0.5) / parts - 0.5) * view.exposure_s
    return np.array([ground_from_pixel(lens, view, t) for t in times_s])


def ground_points(homography: Array, pixels: Array) -> Array:
    """Ground (x, y) [m] of homogeneous pixels (3, n); shape (2, n)."""
    point = homography @ pixels
    flat: Array = point[:2] / point[2]
    return flat


def rotation(angle_rad: Array) -> Array:
    """Rotation matrix, shape (3, 3), of a rotation vector [rad], shape (3,) (Rodrigues)."""
    angle = float(np.linalg.norm(angle_rad))
    x, y, z = angle_rad / angle if angle > 0.0 else (0.0, 0.0, 0.0)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: Array = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * (k @ k)
    return turned
