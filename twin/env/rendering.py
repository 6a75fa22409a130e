"""Where a tractor is looked at: pictures, or a window, where there is OpenGL to make them."""

from __future__ import annotations

import warnings
from typing import Any, Protocol

import mujoco
import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from twin.errors import UnknownName

WIDTH, HEIGHT, FPS = 640, 480, 50
DISTANCE_WHEELBASES, AZIMUTH_DEG, ELEVATION_DEG = 4.0, 125.0, -15.0
"""Where the eye is: from the tractor, at its left and ahead, a little above."""


class Screen(Protocol):
    """What a render mode shows tractors on."""

    def of(self, batch: Any, i: int) -> NDArray[np.uint8] | None:
        """Show one tractor of a Batch on its own ground; the picture, if it is one."""

    def close(self) -> None:
        """Let go of OpenGL."""


def check_mode(render_mode: str | None, modes: list[str]) -> None:
    """Raise UnknownName for a render mode that there is not."""
    if render_mode not in (None, *modes):
        raise UnknownName("render_mode", str(render_mode), modes)


def screen(render_mode: str, model: Any) -> Screen:
    """The screen of a render mode. Raises DependencyNotInstalled without what it needs."""
    if render_mode == "human":
        from twin.env.window import Window  # loads the window library

        return Window(model)
    return Camera(model)


class Camera:
    """Follows the tractor from the side; gives pictures (480, 640, 3)."""

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
        self.view = mujoco.MjvCamera()
        look_at_tractor(self.view, model)

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


def look_at_tractor(view: Any, model: Any) -> None:
    """Turn an eye to the tractor; a machine without its scene would stand in the dark."""
    if model.nlight == 0:
        model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.45, 0.75
    view.type = mujoco.mjtCamera.mjCAMERA_TRACKING
    view.trackbodyid = model.body("tractor").id
    view.distance = DISTANCE_WHEELBASES * float(model.body("front_axle").pos[0])
    view.azimuth, view.elevation = AZIMUTH_DEG, ELEVATION_DEG
