"""The same ground drawn by MuJoCo's off-screen renderer, on one square patch of it."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from twin.camera.ground import SIDE, ground, patch
from twin.camera.opengl import NoGraphics, opened
from twin.camera.pinhole import Array, Pinhole, View, exposed, ground_points, rotation
from twin.camera.planar import SUBFRAME_PX
from twin.camera.soil_texture import TILE
from twin.errors import OutOfRange

if TYPE_CHECKING:
    import mujoco


class Context(Protocol):
    """A graphics context of MuJoCo's."""

    def make_current(self) -> None:
        """Draw here from now on."""

    def free(self) -> None:
        """Let go of it."""


_GL_FROM_CV = np.diag([1.0, -1.0, -1.0])
_MODEL = """
<mujoco>
  <visual>
    <global offwidth="{width}" offheight="{height}"/>
    <quality offsamples="0"/>
    <map znear="0.01" zfar="100"/>
    <headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/>
  </visual>
  <statistic extent="1"/>
  <asset>
    <texture name="soil" type="2d" builtin="flat" width="{side}" height="{side}"/>
    <material name="soil" texture="soil" texrepeat="1 1" specular="0" shininess="0"/>
  </asset>
  <worldbody>
    <geom type="plane" size="{half_m} {half_m} 1" material="soil"/>
    <camera name="down" mode="fixed" fovy="{fovy_deg}"/>
  </worldbody>
</mujoco>
"""


class PatchRenderer:
    """MuJoCo draws a plane with the texture baked onto it; a context manager."""

    def __init__(
        self, lens: Pinhole, seed: int, height_m: float, centre_m: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        """A patch of SIDE texels (1.02 m of the finest) around `centre_m`, moved to whole tiles.

        Raises:
            NoGraphics: there is no EGL driver; says what to install.
        """
        self.lens = lens
        soil = ground(seed, finest_m=height_m / lens.focal_px)
        corner = [TILE * round((c / soil.texel_m - SIDE / 2) / TILE) for c in centre_m]
        self.centre_m = (np.array(corner) + SIDE / 2) * soil.texel_m
        self.half_m = SIDE / 2 * soil.texel_m
        self._open()
        self._bake(patch(soil, corner[0], corner[1], SIDE))

    def _open(self) -> None:
        import mujoco

        lens = self.lens
        text = _MODEL.format(
            fovy_deg=np.degrees(2 * np.arctan(lens.height_px / 2 / lens.focal_px)),
            width=lens.width_px,
            height=lens.height_px,
            side=SIDE,
            half_m=self.half_m,
        )
        self.model = mujoco.MjModel.from_xml_string(text)
        self.state = mujoco.MjData(self.model)
        self.driver, self.canvas = _opened(self.model, lens)
        self.scene = mujoco.MjvScene(self.model, maxgeom=10)
        self.eye = mujoco.MjvCamera()
        self.eye.type, self.eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0

    def _bake(self, texels: NDArray[np.uint8]) -> None:
        import mujoco

        # the first row of a MuJoCo texture lies at the high y of a plane
        first, count = self.model.tex_adr[0], texels.size * 3
        self.model.tex_data[first : first + count] = np.repeat(texels[::-1].reshape(-1), 3)
        mujoco.mjr_uploadTexture(self.model, self.canvas, 0)

    def __enter__(self) -> PatchRenderer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the graphics driver."""
        self.canvas.free()
        self.driver.free()

    def radiance(self, view: View) -> NDArray[np.float32]:
        """Brightness of every pixel: the mean over the parts of the exposure.

        Raises:
            OutOfRange: the picture goes beyond the patch.
        """
        parts = len(exposed(self.lens, view, SUBFRAME_PX))
        self._check(view)
        times_s = ((np.arange(parts) + 0.5) / parts - 0.5) * view.exposure_s
        total = np.zeros((self.lens.height_px, self.lens.width_px), np.float32)
        for time_s in times_s:
            total += self._draw(
                view.position_m + time_s * view.velocity_mps,
                rotation(view.spin_radps * time_s) @ view.ground_from_camera,
            )
        return total / np.float32(parts)

    def _draw(self, position_m: Array, ground_from_camera: Array) -> NDArray[np.uint8]:
        import mujoco

        self.model.cam_pos[0] = [*(position_m[:2] - self.centre_m), position_m[2]]
        mujoco.mju_mat2Quat(self.model.cam_quat[0], (ground_from_camera @ _GL_FROM_CV).reshape(-1))
        mujoco.mj_forward(self.model, self.state)
        self.driver.make_current()
        mujoco.mjv_updateScene(
            self.model, self.state, mujoco.MjvOption(), None, self.eye,
            mujoco.mjtCatBit.mjCAT_ALL, self.scene,
        )  # fmt: skip
        picture = np.empty((self.lens.height_px, self.lens.width_px, 3), np.uint8)
        window = mujoco.MjrRect(0, 0, self.lens.width_px, self.lens.height_px)
        mujoco.mjr_render(window, self.scene, self.canvas)
        mujoco.mjr_readPixels(picture, None, window, self.canvas)
        return picture[::-1, :, 1]  # OpenGL counts rows from below

    def _check(self, view: View) -> None:
        parts = exposed(self.lens, view, SUBFRAME_PX)
        seen = [ground_points(part, self.lens.corners_px()) for part in (parts[0], parts[-1])]
        out_m = np.max(np.abs(np.concatenate(seen, axis=1).T - self.centre_m)) - self.half_m
        if out_m > 0.0:
            raise OutOfRange("picture", f"{out_m:.2f} m beyond", "the patch that is drawn")


def _opened(model: mujoco.MjModel, lens: Pinhole) -> tuple[Context, mujoco.MjrContext]:
    """An EGL driver of the picture's size, whatever MUJOCO_GL says, and its canvas."""

    def make() -> tuple[Context, mujoco.MjrContext]:
        import mujoco
        from mujoco.egl import GLContext

        driver = GLContext(lens.width_px, lens.height_px)
        driver.make_current()
        canvas = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, canvas)
        return driver, canvas

    try:
        return opened(make)
    except NoGraphics as error:
        raise NoGraphics(
            "the off-screen renderer needs an EGL driver; on Debian: apt install libegl1 "
            f"libgl1-mesa-dri, with MUJOCO_GL unset or egl ({error})"
        ) from error
