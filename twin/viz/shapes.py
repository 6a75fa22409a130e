"""What a compiled model looks like: its visual geoms as rerun shapes, and where its bodies are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import rerun as rr

from twin.streams import Table
from twin.viz.tools import Array, set_time

VISUAL_GROUP = 2
_KINDS = mujoco.mjtGeom
_SOLID = frozenset(
    int(kind)
    for kind in (
        _KINDS.mjGEOM_BOX,
        _KINDS.mjGEOM_CYLINDER,
        _KINDS.mjGEOM_CAPSULE,
        _KINDS.mjGEOM_SPHERE,
        _KINDS.mjGEOM_ELLIPSOID,
        _KINDS.mjGEOM_MESH,
    )
)


@dataclass(frozen=True, kw_only=True)
class Shapes:
    """The geoms worth drawing and the bodies they sit on."""

    model: mujoco.MjModel
    bodies: dict[int, str]
    """Body number -> name, of the bodies that have something to draw."""
    geoms: dict[int, list[int]]
    """Body number -> its geoms."""

    @classmethod
    def of(cls, model: mujoco.MjModel) -> Shapes:
        """Moving geoms of group 2; of every group where a model marks none as visual."""
        moving = [g for g in range(model.ngeom) if model.geom_bodyid[g] > 0]
        solid = [g for g in moving if int(model.geom_type[g]) in _SOLID]
        chosen = [g for g in solid if model.geom_group[g] == VISUAL_GROUP] or solid
        geoms: dict[int, list[int]] = {}
        for g in chosen:
            geoms.setdefault(int(model.geom_bodyid[g]), []).append(g)
        bodies = {b: _plain(model.body(b).name) or f"body_{b}" for b in geoms}
        return cls(model=model, bodies=bodies, geoms=geoms)


def body_poses(model: mujoco.MjModel, truth: Table) -> tuple[Array, Array]:
    """Pose of every body at every row of truth, by forward kinematics.

    Args:
        model: its first free joint is the tractor; hinges are matched to `joint_<name>_rad`.
        truth: with east_m north_m up_m qw qx qy qz and joint columns.

    Returns:
        position_w: Shape (n, nbody, 3) [m].
        world_from_body: quaternions wxyz. Shape (n, nbody, 4).
    """
    states = joint_states(model, truth)
    n = len(states)
    data = mujoco.MjData(model)
    position_w, world_from_body = np.empty((n, model.nbody, 3)), np.empty((n, model.nbody, 4))
    for i, state in enumerate(states):
        data.qpos[:] = state
        mujoco.mj_kinematics(model, data)
        position_w[i], world_from_body[i] = data.xpos, data.xquat
    return position_w, world_from_body


def joint_states(model: mujoco.MjModel, truth: Table) -> Array:
    """The model's joint positions at every row of truth. Shape (n, nq)."""
    n = len(truth["epoch_ns"])
    states = np.tile(model.qpos0, (n, 1))  # (n, nq)
    for j in range(model.njnt):
        address = model.jnt_qposadr[j]
        name = model.joint(j).name.split("/")[-1].replace(".", "_")
        if int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_FREE):
            pose = [truth[c] for c in ("east_m", "north_m", "up_m", "qw", "qx", "qy", "qz")]
            states[:, address : address + 7] = np.stack(pose, axis=1)
        elif f"joint_{name}_rad" in truth:
            states[:, address] = truth[f"joint_{name}_rad"]
    return states


def log_shapes(
    recording: rr.RecordingStream,
    entity: str,
    shapes: Shapes,
    body: int,
    from_ns: int | None = None,
) -> None:
    """The geoms of one body in its frame: those of a kind together, each mesh alone.

    Static; or from a time on, for a body whose looks change.
    """
    model, static = shapes.model, from_ns is None
    if from_ns is not None:
        set_time(recording, from_ns)
    kinds: dict[int, list[int]] = {}
    for number, g in enumerate(shapes.geoms[body]):
        if int(model.geom_type[g]) == int(_KINDS.mjGEOM_MESH):
            name = _plain(model.geom(g).name) or f"geom_{number}"
            for part in (_mesh(model, g), _placement(model.geom_pos[g], model.geom_quat[g])):
                recording.log(f"{entity}/{name}", part, static=static)
        else:
            kinds.setdefault(int(model.geom_type[g]), []).append(g)
    for kind, geoms in kinds.items():
        name, shape = _batch(model, _KINDS(kind), np.array(geoms))
        recording.log(f"{entity}/{name}", shape, static=static)
    recording.reset_time()


def looks_alike(model: mujoco.MjModel, other: mujoco.MjModel, body: int) -> bool:
    """Whether the geoms of a body stand the same in two models of one machine."""
    mine = model.geom_bodyid == body
    return bool(
        np.array_equal(model.geom_pos[mine], other.geom_pos[mine])
        and np.array_equal(model.geom_quat[mine], other.geom_quat[mine])
    )


def _plain(name: str) -> str:
    """A model's name without what separates parts of entity paths."""
    return name.replace("/", "_").replace(".", "_")


def _batch(model: mujoco.MjModel, kind: Any, geoms: Array) -> tuple[str, Any]:
    """Geoms of one kind as one rerun archetype, placed in their body, and what to call it."""
    size, centre, wxyz = model.geom_size[geoms], model.geom_pos[geoms], model.geom_quat[geoms]
    placed: dict[str, Any] = {
        "quaternions": wxyz[:, [1, 2, 3, 0]],  # rerun keeps the scalar last
        "colors": [_colour(model, int(g)) for g in geoms],
        "fill_mode": "solid",
    }
    long = {"lengths": 2.0 * size[:, 1], "radii": size[:, 0]}
    if kind == _KINDS.mjGEOM_BOX:
        return "boxes", rr.Boxes3D(half_sizes=size, centers=centre, **placed)
    if kind == _KINDS.mjGEOM_CYLINDER:
        return "cylinders", rr.Cylinders3D(centers=centre, **long, **placed)
    if kind == _KINDS.mjGEOM_CAPSULE:
        axis = np.array([_z_axis(quaternion) for quaternion in wxyz])
        start = centre - size[:, 1:2] * axis  # rerun's capsule starts at its origin
        return "capsules", rr.Capsules3D(translations=start, **long, **placed)
    sphere = kind == _KINDS.mjGEOM_SPHERE
    half = np.repeat(size[:, :1], 3, axis=1) if sphere else size
    name = "spheres" if sphere else "ellipsoids"
    return name, rr.Ellipsoids3D(half_sizes=half, centers=centre, **placed)


def _mesh(model: mujoco.MjModel, g: int) -> rr.Mesh3D:
    mesh = model.geom_dataid[g]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    vertices = model.mesh_vert[first : first + count]
    triangles = model.mesh_face[face : face + faces]
    corners = vertices[triangles]  # (m, 3, 3), flat shaded: every face has its own corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return rr.Mesh3D(
        vertex_positions=corners.reshape(-1, 3),
        vertex_normals=np.repeat(normals, 3, axis=0),
        albedo_factor=_colour(model, g),
    )


def _placement(centre: Array, wxyz: Array) -> rr.InstancePoses3D:
    return rr.InstancePoses3D(translations=[centre], quaternions=[wxyz[[1, 2, 3, 0]]])


def _z_axis(wxyz: Array) -> Array:
    w, x, y, z = wxyz
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def _colour(model: mujoco.MjModel, g: int) -> list[int]:
    material = model.geom_matid[g]
    rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[g]
    red, green, blue, alpha = (int(v) for v in np.clip(np.round(255 * rgba), 0, 255))
    visual = model.geom_group[g] == VISUAL_GROUP  # hulls that stand in for looks are see-through
    return [red, green, blue, alpha if visual else 255]
