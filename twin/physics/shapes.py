"""Types of what the laws pass to each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""A part of the parameter block, or a field of mjData."""
Vector = tuple[float, float, float]
"""A vector in world axes."""
Vector2 = tuple[float, float]
"""A vector in the ground plane."""
Vector4 = tuple[float, float, float, float]
"""What a tyre remembers, or its rates."""
