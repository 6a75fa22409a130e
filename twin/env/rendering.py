"""Where a tractor is looked at: pictures, or a window, where there is OpenGL to make them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from twin.camera.opengl import NoGraphics, OffScreen
from twin.errors import OutOfRange, UnknownName

if TYPE_CHECKING:
    from twin.env.fleet import Fleet

FPS = 50
CAMERAS = ("follow", "side", "behind", "front", "top")
LEAST_PX, MOST_PX = 16, 4096


class Screen(Protocol):
    """What a render mode shows tractors on."""

    def of(self, fleet: Fleet, i: int) -> NDArray[np.uint8] | None:
        """Show one tractor of a fleet on its own ground; the picture, if it is one."""

    def close(self) -> None:
        """Let go of OpenGL."""


@dataclass(frozen=True)
class Look:
    """How tractors are looked at: the arguments of an environment that say so."""

    render_mode: str | None = None
    width: int = 640
    height: int = 480
    camera: str = "follow"

    def check(self, modes: list[str]) -> Look:
        """Itself.

        Raises:
            UnknownName: a render mode or a camera that there is not.
            OutOfRange: a size that no picture has.
        """
        if self.render_mode not in (None, *modes):
            raise UnknownName("render_mode", str(self.render_mode), modes)
        if self.camera not in CAMERAS:
            raise UnknownName("camera", str(self.camera), CAMERAS)
        for name in ("width", "height"):
            size = getattr(self, name)
            if isinstance(size, bool) or int(size) != size or not LEAST_PX <= size <= MOST_PX:
                raise OutOfRange(name, size, f"the whole numbers {LEAST_PX} to {MOST_PX}")
        return self


def screen(look: Look, fleet: Fleet) -> Screen:
    """The screen of a render mode. Raises DependencyNotInstalled without what it needs."""
    if look.render_mode == "human":
        from twin.env.window import Window  # loads the window library

        return Window(look, fleet)
    return Camera(look, fleet)


class Camera:
    """Follows a tractor; gives pictures (height, width, 3)."""

    def __init__(self, look: Look, fleet: Fleet) -> None:
        """Raises DependencyNotInstalled without a working OpenGL driver."""
        from twin.env.staging import Staging  # loads what draws

        self.staging = Staging(look, fleet)
        try:
            self.frame = OffScreen(self.staging.stage.model, look.width, look.height)
        except NoGraphics as error:
            raise DependencyNotInstalled(
                "render_mode 'rgb_array' needs OpenGL, which does not start here. Install a driver "
                "(Debian: apt install libegl1, or libosmesa6) and set MUJOCO_GL=egl (or osmesa) "
                f"before Python starts. It said: {error}"
            ) from error

    def of(self, fleet: Fleet, i: int) -> NDArray[np.uint8]:
        """One tractor of a fleet on its own ground, (height, width, 3)."""
        return self.staging.set(fleet, i).picture(self.frame)

    def close(self) -> None:
        """Let go of the OpenGL context."""
        self.frame.close()
