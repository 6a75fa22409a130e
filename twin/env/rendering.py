"""A picture of a tractor, where there is an OpenGL driver to make one."""

from __future__ import annotations

import warnings
from typing import Any

import mujoco
import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from twin.errors import UnknownName

WIDTH, HEIGHT = 640, 480
RENDER_MODES = ["rgb_array"]


def check_mode(render_mode: str | None) -> None:
    """Raise UnknownName for a render mode that there is not."""
    if render_mode not in (None, *RENDER_MODES):
        raise UnknownName("render_mode", str(render_mode), RENDER_MODES)


class Camera:
    """Follows the tractor from the side."""

    def __init__(self, model: Any) -> None:
        """Raises DependencyNotInstalled without a working OpenGL driver."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what the window library says of a missing display
                self.renderer = mujoco.Renderer(model, HEIGHT, WIDTH)
        except Exception as error:  # each OpenGL platform fails in a way of its own
            raise DependencyNotInstalled(
                "render_mode 'rgb_array' needs OpenGL, which does not start here. Install a driver "
                "(Debian: apt install libegl1, or libosmesa6) and set MUJOCO_GL=egl (or osmesa) "
                f"before Python starts. It said: {error}"
            ) from error
        if model.nlight == 0:  # a machine without its scene stands in the dark
            model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.45, 0.75
        self.view = mujoco.MjvCamera()
        self.view.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        self.view.trackbodyid = model.body("tractor").id
        self.view.distance, self.view.azimuth, self.view.elevation = 10.0, 125.0, -15.0

    def of(self, batch: Any, i: int) -> NDArray[np.uint8]:
        """One tractor of a Batch on its own ground, (height, width, 3)."""
        model, state = batch.get_model(i), batch.get_data(i)
        mujoco.mj_forward(model, state)
        return self.picture(state)

    def picture(self, state: Any) -> NDArray[np.uint8]:
        """The tractor of an MjData whose kinematics are current, (height, width, 3)."""
        self.renderer.update_scene(state, camera=self.view)
        picture: NDArray[np.uint8] = self.renderer.render()
        return picture

    def close(self) -> None:
        """Let go of the OpenGL context."""
        self.renderer.close()
