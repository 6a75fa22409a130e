"""OpenGL for MuJoCo's renderer: opened, or refused with one and the same error."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from twin.errors import TwinError

Opened = TypeVar("Opened")
_refusals: list[str] = []
"""What the first failure said, if there was one."""


class NoGraphics(TwinError):
    """There is no OpenGL to draw with."""


def opened(make: Callable[[], Opened]) -> Opened:
    """What `make` opens.

    MuJoCo looks for OpenGL once, and aborts the process when it is asked again after it found none;
    so what failed once is not tried again in this process.

    Raises:
        NoGraphics: it does not open, or something did not before; with what the first failure said.
    """
    if not _refusals:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what the window library says of a missing display
                return make()
        except Exception as error:  # each platform fails in a way of its own
            _refusals.append(" ".join(str(error).split()) or type(error).__name__)
    raise NoGraphics(_refusals[0])


class OffScreen:
    """A picture's frame to draw a model in, with MUJOCO_GL's driver."""

    def __init__(self, model: Any, width: int, height: int) -> None:
        """Raises NoGraphics."""
        self.size = (width, height)
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        self.driver, self.context = opened(lambda: _open(model, width, height))

    def draw(self, scene: Any) -> NDArray[np.uint8]:
        """A scene of the model as a picture, (height, width, 3)."""
        import mujoco

        width, height = self.size
        picture, whole = np.empty((height, width, 3), np.uint8), mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(whole, scene, self.context)
        mujoco.mjr_readPixels(picture, None, whole, self.context)
        return picture[::-1]  # OpenGL counts rows from below

    def make_current(self) -> None:
        """What is uploaded or drawn next is this frame's."""
        self.driver.make_current()

    def close(self) -> None:
        """Let go of OpenGL."""
        self.make_current()
        self.context.free()
        self.driver.free()


def _open(model: Any, width: int, height: int) -> tuple[Any, Any]:
    import mujoco
    from mujoco.gl_context import GLContext

    driver = GLContext(width, height)
    driver.make_current()
    context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)
    return driver, context
