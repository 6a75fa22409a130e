"""Pictures and a window, each in a process of its own: OpenGL is chosen when MuJoCo is imported."""

import os
import shutil
import subprocess
import sys

import gymnasium
import pytest

from twin.camera import opengl
from twin.env import IDS
from twin.env.plough import PloughEnv
from twin.env.rendering import CAMERAS, Look
from twin.env.wheel_slip import WheelSlipEnv
from twin.env.window import Window
from twin.errors import OutOfRange, UnknownName

PICTURE = """
import warnings
warnings.simplefilter("error")
import gymnasium
import numpy as np
env = gymnasium.make(
    "twin.env:{name}", observation="truth", render_mode="rgb_array", width=320, height=200,
    camera="{camera}",
)
env.reset(seed=0)
try:
    shown = env.render()
except gymnasium.error.DependencyNotInstalled:
    raise SystemExit(77)
assert shown.shape == (200, 320, 3) and shown.dtype == np.uint8
stage = env.unwrapped.screen.staging.stage
machine = stage.model.geom_bodyid > 0
groups = stage.model.geom_group[machine].copy()
stage.model.geom_group[machine] = 5  # which the renderer leaves out
hidden = env.render()
stage.model.geom_group[machine] = groups
differs = np.abs(shown.astype(int) - hidden).max(axis=2) > 8
assert differs.mean() > 0.05, f"the machine fills {{differs.mean():.1%}} of the picture"
ground = ~differs
assert shown[ground].std(axis=0).min() > 5.0, "the ground is one flat colour"
for _ in range(40):
    env.step(env.action_space.high)
later = env.render()
moved = np.abs(later.astype(int) - shown).max(axis=2) > 8
assert moved.mean() > 0.02, "it drives and nothing moves"
again = np.abs(later.astype(int) - hidden).max(axis=2) > 8
middle = np.argwhere(differs).mean(axis=0) - np.argwhere(again).mean(axis=0)
assert np.abs(middle).max() < 60, "the camera does not follow"
env.close()
"""
MANY = """
import gymnasium
many = gymnasium.make_vec(
    "twin.env:Plough-v0", num_envs=2, vectorization_mode="vector_entry_point",
    observation="truth", render_mode="rgb_array", width=160, height=120, camera="top",
)
many.reset(seed=0, options={"soil.preset": "firm", "field.cross_slope_deg": 0.0})
try:
    first, second = many.render()
except gymnasium.error.DependencyNotInstalled:
    raise SystemExit(77)
assert first.shape == second.shape == (120, 160, 3)
for picture in (first, second):
    red = (picture[..., 0] > 120) & (picture[..., 1] < 60)
    assert red[:, 60:100].any(), "no tractor in the middle"
many.close()
"""
REFUSED = """
import gymnasium
env = gymnasium.make("twin.env:{name}", observation="truth", render_mode="rgb_array")
env.reset(seed=0)
said = []
for _ in range(3):
    try:
        env.render()
    except gymnasium.error.DependencyNotInstalled as error:
        said.append(str(error))
    env.step(env.action_space.sample())
assert len(said) == 3 and len(set(said)) == 1 and "\\n" not in said[0], said
from twin.camera.patch import NoGraphics, PatchRenderer
from twin.camera.pinhole import Pinhole
try:
    PatchRenderer(Pinhole(width_px=64, height_px=64, focal_px=64.0), 1, 0.5)
except NoGraphics as error:
    assert "EGL" in str(error)
else:
    raise SystemExit("it draws after OpenGL was refused")
print(said[0])
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
    env.step(np.zeros(env.action_space.shape))
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
@pytest.mark.parametrize(
    ("name", "camera"), [*((name, "follow") for name in IDS), ("Plough-v0", "top")]
)
def test_pictures_show_the_machine_on_its_ground_and_follow_it(name, camera):
    drawn(PICTURE.format(name=name, camera=camera))


@pytest.mark.slow
def test_each_of_many_has_its_picture():
    drawn(MANY)


def drawn(code):
    done = run(code, MUJOCO_GL="egl")
    if done.returncode == 77:
        pytest.skip("no OpenGL through EGL here")
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(("name", "without"), [
    ("Plough-v0", {"MUJOCO_GL": "glfw", "DISPLAY": ""}),
    ("WheelSlip-v0", {"MUJOCO_GL": "glfw", "DISPLAY": ""}),
    ("WheelSlip-v0", {"MUJOCO_GL": "egl", "MUJOCO_EGL_DEVICE_ID": "77"}),
    ("WheelSlip-v0", {"MUJOCO_GL": "disable"}),
])  # fmt: skip
def test_without_opengl_it_says_the_same_each_time_and_goes_on(name, without):
    done = run(REFUSED.format(name=name), **without)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "needs OpenGL" in done.stdout
    assert "MUJOCO_GL=egl" in done.stdout


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
    def fails(*args):
        raise RuntimeError("no display")

    monkeypatch.setattr(opengl, "_open", fails)
    monkeypatch.setattr(opengl, "_refusals", [])
    env = PloughEnv("truth", render_mode="rgb_array")
    env.reset(seed=0)
    for _ in range(2):
        match = r"libegl1.*MUJOCO_GL=egl.*no display"
        with pytest.raises(gymnasium.error.DependencyNotInstalled, match=match):
            env.render()
    env.step(env.action_space.sample())


def test_without_a_display_it_says_what_would_do(monkeypatch):
    import glfw

    monkeypatch.setattr(glfw, "init", lambda: False)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"no display.*rgb_array"):
        Window(Look("human"), None)


@pytest.mark.parametrize("env", [PloughEnv, WheelSlipEnv])
@pytest.mark.parametrize(
    ("look", "error"),
    [({"camera": "moon"}, UnknownName), ({"width": 0}, OutOfRange), ({"height": 9.5}, OutOfRange)],
)
def test_a_look_that_cannot_be_is_refused(env, look, error):
    with pytest.raises(error, match=next(iter(look))):
        env("truth", **look)


def test_the_cameras_are_those_that_can_be_drawn():
    from twin.viz.stage import VIEWS

    assert set(CAMERAS) == set(VIEWS)
