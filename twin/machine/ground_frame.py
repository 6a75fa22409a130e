"""The ground plane's frame: x along the course, y to its left, z normal.

Its origin is the world's; only the axes are rotated.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.scenario import Course, Field

Array = NDArray[np.float64]


def world_from_ground(field: Field, course: Course) -> Array:
    """Matrix that rotates ground axes to world axes, R_z(heading) R_y(-grade) R_x(cross slope).

    Shape (3, 3).
    """
    heading = math.radians(course.heading_deg)
    grade = math.radians(field.grade_deg)
    cross = math.radians(field.cross_slope_deg)
    about_z = np.array(
        [
            [math.cos(heading), -math.sin(heading), 0.0],
            [math.sin(heading), math.cos(heading), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    about_y = np.array(
        [
            [math.cos(grade), 0.0, -math.sin(grade)],
            [0.0, 1.0, 0.0],
            [math.sin(grade), 0.0, math.cos(grade)],
        ]
    )
    about_x = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, math.cos(cross), -math.sin(cross)],
            [0.0, math.sin(cross), math.cos(cross)],
        ]
    )
    return about_z @ about_y @ about_x
