"""Types of the arguments and results of the laws."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""A part of the parameter block, or a field of mjData."""
Integers = NDArray[np.int32]
"""A field of mjModel that holds indices."""
Forces = tuple[float, float, float, float, float]
"""Result of a soil law: shear along and across, resistance, rolling moment over the rolling radius
[N], sinkage [m]."""
Vector = tuple[float, float, float]
"""A vector in world axes."""
Vector2 = tuple[float, float]
"""A vector in the ground plane."""
Vector4 = tuple[float, float, float, float]
"""A tyre's activations, or their rates: deflection of the tread along and across [m], slip of the
contact along and across [-]."""
