"""Figures of the rigs."""

from __future__ import annotations

import numpy as np

from twin.rig import figures
from twin.rig.tyre import Tyre
from twin.rig.wheel import towed, wheel
from twin.scenario import Soil


def test_angles_are_written_as_they_were_given() -> None:
    angles_deg = np.array([0.0, 4.0, 7.5, 20.0])
    angle, slip = (a.ravel() for a in np.meshgrid(np.radians(angles_deg), [0.1, 0.2]))
    load = np.full(angle.shape, 20e3)
    curve = wheel(Tyre(), Soil(), slip=slip, load_n=load, slip_angle_rad=angle)
    free = towed(Tyre(), Soil(), load_n=np.array([20e3]))
    drawn = figures.wheel(curve, free, "title")
    labels = drawn.axes[3].get_legend_handles_labels()[1]
    assert labels == ["4°, 20 kN", "7.5°, 20 kN", "20°, 20 kN"]
