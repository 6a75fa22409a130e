"""A machine as the text of a MJCF that plain MuJoCo opens, standing on a plane."""

from __future__ import annotations

import mujoco

from twin.machine.join import joined
from twin.vehicle.implement import Implement
from twin.vehicle.machine import Machine


def as_mjcf(machine: Machine, part: Implement | None = None) -> str:
    """The MJCF of a machine with its implement, on level ground.

    It has the documented numerics, so `--machine OUT.xml` reads it, if it was exported without an
    implement. The meshes of a hand-made MJCF have absolute paths. `part` is the implement, None
    for none.
    """
    spec, _ = joined(machine, part)
    spec.compiler.degree = False
    if spec.meshdir and spec.modelfiledir:
        folder = spec.modelfiledir.rstrip("/")
        spec.meshdir = f"{folder}/{spec.meshdir}"
    spec.worldbody.add_geom(
        name="field", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=1, conaffinity=2,
        rgba=[0.48, 0.40, 0.27, 1.0],
    )  # fmt: skip
    spec.worldbody.add_light(
        name="sun", pos=[3, -5, 14], dir=[-0.3, 0.42, -1],
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
    )  # fmt: skip
    spec.compile()
    return str(spec.to_xml())
