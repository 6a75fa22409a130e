"""A window to watch a tractor in."""

from __future__ import annotations

import time
import warnings
from typing import Any

import glfw
import mujoco
from gymnasium.error import DependencyNotInstalled
from mujoco.batch import Batch

from twin.env.rendering import FPS, HEIGHT, WIDTH, look_at_tractor

MOST_GEOMS = 10_000


class Window:
    """A window that follows the tractor, in the tractor's own time."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Raises DependencyNotInstalled without a display."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the same is said below
            self.window: Any = glfw.init() and glfw.create_window(
                WIDTH, HEIGHT, "tractor-twin", None, None
            )
        if not self.window:
            raise DependencyNotInstalled(
                "render_mode 'human' opens a window, and there is no display with OpenGL here; "
                "use render_mode 'rgb_array', or run under xvfb-run"
            )
        glfw.make_context_current(self.window)
        glfw.swap_interval(0)
        self.view = mujoco.MjvCamera()
        look_at_tractor(self.view, model)
        self.scene, self.option = mujoco.MjvScene(model, MOST_GEOMS), mujoco.MjvOption()
        self.context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        self.next_s = 0.0

    def of(self, batch: Batch, i: int) -> None:
        """One tractor of a Batch on its own ground, 20 ms after the last; nothing once closed."""
        if not self.window or glfw.window_should_close(self.window):
            return
        model, state = batch.get_model(i), batch.get_data(i)
        mujoco.mj_forward(model, state)
        glfw.make_context_current(self.window)
        every = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(model, state, self.option, None, self.view, every, self.scene)
        whole = mujoco.MjrRect(0, 0, *glfw.get_framebuffer_size(self.window))
        mujoco.mjr_render(whole, self.scene, self.context)
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
