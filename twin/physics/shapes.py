"""Types of what the laws pass to each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""A part of the parameter block, or a field of mjData."""
Integers = NDArray[np.int32]
"""A field of mjModel that holds indices."""
Forces = tuple[float, float, float, float, float]
"""What a soil law gives: forces along and across, resistance [N], moment [N m], sinkage [m]."""
Vector = tuple[float, float, float]
"""A vector in world axes."""
Vector2 = tuple[float, float]
"""A vector in the ground plane."""
Vector4 = tuple[float, float, float, float]
"""What a tyre remembers, or its rates."""
