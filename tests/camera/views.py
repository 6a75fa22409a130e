"""Views of the ground, made by hand."""

import numpy as np

from twin.camera.pinhole import CAMERA_DOWN, Pinhole, View, focal_px, rotation

LENS = Pinhole(width_px=1280, height_px=800, focal_px=focal_px(1280, np.radians(53.0)))
SMALL = Pinhole(width_px=320, height_px=200, focal_px=LENS.focal_px)


def view(
    x_m=0.0, y_m=0.0, height_m=0.5, turn_rad=(0, 0, 0), velocity_mps=(0, 0, 0), exposure_s=0.0
):
    return View(
        position_m=np.array([x_m, y_m, height_m]),
        ground_from_camera=rotation(np.array(turn_rad, float)) @ CAMERA_DOWN,
        velocity_mps=np.array(velocity_mps, float),
        spin_radps=np.zeros(3),
        exposure_s=exposure_s,
    )
