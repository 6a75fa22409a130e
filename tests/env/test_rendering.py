"""Pictures and a window, each in a process of its own: OpenGL is chosen when MuJoCo is imported."""

import os
import shutil
import subprocess
import sys

import gymnasium
import pytest

from twin.env import IDS
from twin.env.plough import PloughEnv
from twin.env.window import Window

PICTURE = """
import warnings
warnings.simplefilter("error")
import gymnasium
try:
    for name in ("Plough-v0", "WheelSlip-v0"):
        env = gymnasium.make(f"twin.env:{name}", observation="truth", render_mode="rgb_array")
        env.reset(seed=0)
        picture = env.render()
        assert picture.shape == (480, 640, 3) and picture.std() > 10.0
        env.close()
        many = gymnasium.make_vec(
            f"twin.env:{name}", num_envs=2, vectorization_mode="vector_entry_point",
            observation="truth", render_mode="rgb_array",
        )
        many.reset(seed=0, options={"soil.preset": "firm"})
        assert len(many.render()) == 2 and (many.render()[0] == picture).mean() > 0.5
        many.close()
except gymnasium.error.DependencyNotInstalled:
    raise SystemExit(77)
"""
WINDOW = """
import time
import gymnasium
import mujoco
import numpy as np
env = gymnasium.make("twin.env:{name}", observation="truth", render_mode="human").unwrapped
try:
    env.reset(seed=0, options={{"field.cross_slope_deg": 4.0}})
except gymnasium.error.DependencyNotInstalled:
    raise SystemExit(77)
begin = time.perf_counter()
for _ in range(25):
    env.step(np.zeros(2))
assert time.perf_counter() - begin > 0.4, "faster than the tractor's own time"
window, picture = env.screen, np.zeros((480, 640, 3), np.uint8)
whole = mujoco.MjrRect(0, 0, 640, 480)
mujoco.mjr_readPixels(picture, None, whole, window.context)
assert picture.std() > 10.0, "nothing is drawn"
assert env.render() is None
env.close()
env.close()
"""


def run(code, command=(), **variables):
    return subprocess.run(
        [*command, sys.executable, "-c", code],
        env={**os.environ, **variables}, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip


@pytest.mark.slow
def test_pictures_show_something():
    done = run(PICTURE, MUJOCO_GL="egl")
    if done.returncode == 77:
        pytest.skip("no OpenGL through EGL here")
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_a_window_shows_the_tractor_in_its_own_time(name):
    if shutil.which("xvfb-run") is None:
        pytest.skip("xvfb-run, which makes a display to test with, is not installed")
    done = run(WINDOW.format(name=name), ("xvfb-run", "-a"), MUJOCO_GL="glfw")
    if done.returncode == 77:
        pytest.skip("no window opens under xvfb-run here")
    assert done.returncode == 0, done.stderr


def test_without_opengl_it_says_what_to_install(monkeypatch):
    import mujoco

    def fails(*args):
        raise RuntimeError("no display")

    monkeypatch.setattr(mujoco, "Renderer", fails)
    env = PloughEnv("truth", render_mode="rgb_array")
    env.reset(seed=0)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"libegl1.*MUJOCO_GL=egl"):
        env.render()
    env.step(env.action_space.sample())


def test_without_a_display_it_says_what_would_do(monkeypatch):
    import glfw
    import mujoco

    monkeypatch.setattr(glfw, "init", lambda: False)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"no display.*rgb_array"):
        Window(mujoco.MjModel.from_xml_string("<mujoco/>"))
