"""A window to watch a tractor in."""

from __future__ import annotations

import time
import warnings
from typing import Any

import glfw
import mujoco
from gymnasium.error import DependencyNotInstalled

from twin.camera.opengl import NoGraphics, opened
from twin.env.fleet import Fleet
from twin.env.rendering import FPS, Look
from twin.env.staging import Staging

REFUSED = (
    "render_mode 'human' opens a window, and there is no display with OpenGL here; "
    "use render_mode 'rgb_array', or run under xvfb-run"
)


class Window:
    """A window that follows the tractor, no faster than real time."""

    def __init__(self, look: Look, fleet: Fleet) -> None:
        """Raises DependencyNotInstalled without a display."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the same is said below
            self.window: Any = glfw.init() and glfw.create_window(
                look.width, look.height, "tractor-twin", None, None
            )
        if not self.window:
            raise DependencyNotInstalled(REFUSED)
        self.staging = Staging(look, fleet)
        model = self.staging.stage.model
        glfw.make_context_current(self.window)
        glfw.swap_interval(0)
        try:
            self.context = opened(
                lambda: mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
            )
        except NoGraphics as error:
            glfw.destroy_window(self.window)
            raise DependencyNotInstalled(f"{REFUSED}. It said: {error}") from error
        self.next_s = 0.0

    def of(self, fleet: Fleet, i: int) -> None:
        """One tractor of a fleet on its own ground, 20 ms after the last; nothing once closed."""
        if not self.window or glfw.window_should_close(self.window):
            return
        stage = self.staging.set(fleet, i)
        glfw.make_context_current(self.window)
        stage.mesh.upload(stage.model, self.context)
        whole = mujoco.MjrRect(0, 0, *glfw.get_framebuffer_size(self.window))
        mujoco.mjr_render(whole, stage.scene, self.context)
        glfw.swap_buffers(self.window)
        glfw.poll_events()
        time.sleep(max(0.0, self.next_s - time.perf_counter()))
        self.next_s = time.perf_counter() + 1.0 / FPS

    def close(self) -> None:
        """Close the window."""
        if self.window:
            self.context.free()
            glfw.destroy_window(self.window)
            self.window = None
