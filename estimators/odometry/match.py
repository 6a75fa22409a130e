"""What every matcher gives: where points of the current picture were in the previous one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from estimators.odometry.lens import Array, Picture


@dataclass(frozen=True, kw_only=True)
class Match:
    """An affine map from pixels (u, v, 1) of the current picture to the previous one."""

    previous_from_current: Array
    """Shape (2, 3)."""
    variance_px2: float
    """Of the displacement of the principal point, each axis."""
    quality: float
    """The matcher's own measure in [0, 1]: correlation, or share of inliers."""
    turns: bool = True
    """Whether the map's rotation was measured."""
    stretches: bool = False
    """Whether its stretching was."""


Matcher = Callable[[Picture, Picture, float, Array | None], Match | None]
"""matcher(previous, current, turn_rad, moved_px) -> Match, or None where none was found.

`turn_rad` is the gyro's rotation of the camera about its optical axis from previous to current;
`moved_px` is where the principal point was in the previous picture, beside its place, if the camera
goes on as it did; None where that is unknown.
"""
