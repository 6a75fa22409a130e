"""A machine on its field, dressed for MuJoCo's own renderer: in pictures and in windows."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.camera.opengl import OffScreen
from twin.machine.build import assemble
from twin.machine.join import joined
from twin.plugins.lookup import Thing
from twin.viz.bodies import bodies
from twin.viz.field import FieldMesh, Seen
from twin.viz.tools import LARGE_M, Array

CELL_M, REACH_M = 0.07, (6.5, 3.0)
"""Smallest cell of the field, and how far it reaches along and across."""
VIEWS = {
    "follow": (-36.0, -20.0, 9.5),
    "side": (-90.0, -12.0, 9.5),
    "behind": (0.0, -18.0, 9.0),
    "front": (145.0, -15.0, 9.0),
    "top": (0.0, -89.0, 10.0),
}
"""Where the eye is: azimuth and elevation of its view [deg], distance from a large tractor [m]."""
ANTIALIASED = 4
"""Samples of a pixel."""
MOST_GEOMS = 2000


class Stage:
    """A model that is only looked at, its state, and the eye that follows it."""

    def __init__(
        self, scenario: Thing, setting: Any = None, *, camera: str = "follow", detail: float = 1.0
    ) -> None:
        """Args: setting: of the plough. camera: one of VIEWS. detail: over the field's usual."""
        scale = _wheelbase_m(scenario) / LARGE_M
        self.mesh = FieldMesh(
            CELL_M * scale / detail,
            (REACH_M[0] * scale * detail**0.5, REACH_M[1] * scale * detail**0.5),
        )
        self.machine = assemble(scenario, looks=True, setting=setting, dress=self.mesh.add)
        self.model = self.machine.model
        self.model.stat.extent = 8.0 * scale
        self.model.vis.map.znear, self.model.vis.map.zfar = 0.01, 200.0
        self.model.vis.quality.offsamples = ANTIALIASED
        self.bodies = bodies(self.model)
        self.data, self.option = mujoco.MjData(self.model), mujoco.MjvOption()
        self.scene = mujoco.MjvScene(self.model, MOST_GEOMS)
        self.tractor = self.model.body("tractor").id
        self.eye = mujoco.MjvCamera()
        self.eye.azimuth, self.eye.elevation, distance_m = VIEWS[camera]
        alone = self.bodies is None  # no implement behind it
        self.eye.distance = scale * distance_m * (0.7 if alone else 1.0)
        self.look_at_m = scale * np.array([1.1 if alone else -0.9, 0.0, -0.2])

    def set(self, qpos: Array, seen: Seen) -> None:
        """Put the machine and the field under it where they are."""
        self.data.qpos[:] = qpos
        self.mesh.set(self.model, seen)
        mujoco.mj_fwdPosition(self.model, self.data)
        self.eye.lookat[:] = self.data.xpos[self.tractor] + self.look_at_m
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            self.model, self.data, self.option, None, self.eye, everything, self.scene
        )

    def picture(self, frame: OffScreen) -> NDArray[np.uint8]:
        """What the eye sees, (height, width, 3)."""
        frame.make_current()
        self.mesh.upload(self.model, frame.context)
        return frame.draw(self.scene)


def _wheelbase_m(scenario: Thing) -> float:
    spec, _ = joined(scenario.machine_file)
    return float(spec.body("front_axle").pos[0])
