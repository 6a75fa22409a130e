"""The field under a machine in MuJoCo's own renderer: a mesh that follows it, with soil baked on.

The mesh is fine about the machine and ever coarser to the horizon. Before each picture its vertices
and its texture are set anew from where it stands; both are functions of place, so nothing swims,
and the soil's grain repeats in four scales whose lengths do not agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.viz.bodies import Bodies
from twin.viz.furrows import Cut, Pass, left_by, worked_by
from twin.viz.mesh import normals, triangles
from twin.viz.tools import Array

NAME = "soil_seen"
HORIZON_M = 400.0
LONGER, GROWTH = 1.6, 1.17
"""A cell's length over its width; each cell over the one before it, away from the machine."""
TEXELS = 3
"""Of the texture to a cell of the mesh, along each side."""
LAND, STRAW, TURNED, SOLE = (150, 128, 92), (206, 184, 132), (96, 70, 49), (78, 57, 41)
"""Colours: stubble and its straw, turned soil, the sole of an open furrow."""
GRAIN_M = (0.021, 0.117, 0.83, 7.3)
"""Cells of the grain's scales."""
ROW_M = 0.14
"""Distance of the stubble's rows."""
RELIEF = (0.006, 0.05)
"""Height of clods over the grain's standard deviation, on land and on turned soil [m]."""
SHADOW_PX = 2048
SKY = ((0.38, 0.58, 0.84), (0.88, 0.92, 0.95))


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What is to be seen of a field from where a machine stands."""

    s_m: float
    t_m: float
    world_from_ground: Array = field(default_factory=lambda: np.eye(3))
    heights: Any = None
    """With `at(s_m, t_m)`, where the ground has heights."""
    bodies: Bodies | None = None
    """Of the plough, where one works."""
    furrow_depth_m: float = 0.0
    """Of the last furrow."""
    depth_m: float = 0.0
    """Of those that are cut."""
    cuts: Sequence[Cut] = ()
    done: Sequence[Pass] = ()
    """The passes so far."""


class FieldMesh:
    """Adds the field to a specification, and sets it in the compiled model for each picture."""

    def __init__(self, fine_m: float, reach_m: tuple[float, float]) -> None:
        """Args: fine_m: the smallest cell. reach_m: of the fine part, along and across."""
        self.fine_m = fine_m
        self.lines_s = _lines(LONGER * fine_m, reach_m[0])
        self.lines_t = _lines(fine_m, reach_m[1])

    def add(self, spec: mujoco.MjSpec) -> None:
        """The mesh, its texture, a sun and a sky, in place of what marks the ground there."""
        n, m = len(self.lines_s), len(self.lines_t)
        i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
        place = np.stack([i, j, 0.01 * ((i + j) % 2)], axis=-1)  # some shape, to be set later
        corner = np.stack([(j + 0.5) / m, (i + 0.5) / n], axis=-1)
        spec.add_mesh(
            name=NAME, uservert=place.ravel().astype(float),
            userface=triangles(n, m).astype(np.int32).ravel(), usertexcoord=corner.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )  # fmt: skip
        spec.add_texture(
            name=NAME, type=mujoco.mjtTexture.mjTEXTURE_2D,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, width=TEXELS * m, height=TEXELS * n,
        )  # fmt: skip
        spec.add_texture(
            name=f"{NAME}_sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, rgb1=SKY[0], rgb2=SKY[1],
            width=256, height=1536,
        )  # fmt: skip
        material = spec.add_material(name=NAME, specular=0.0, shininess=0.0)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = NAME
        spec.worldbody.add_geom(
            name=NAME, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=NAME, material=NAME,
            contype=0, conaffinity=0, group=2, mass=0.0, castshadow=False,
        )  # fmt: skip
        spec.worldbody.add_light(
            name=NAME, type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, pos=[0.0, 0.0, 20.0],
            dir=[0.35, -0.5, -0.8], ambient=[0.0] * 3, diffuse=[0.72, 0.70, 0.66],
            specular=[0.2] * 3, mode=mujoco.mjtCamLight.mjCAMLIGHT_FIXED,
        )  # fmt: skip
        for name in ("ground", "terrain"):
            if (geom := spec.geom(name)) is not None:
                geom.rgba[3] = 0.0
        head = spec.visual.headlight
        head.ambient[:], head.diffuse[:], head.specular[:] = 0.42, 0.22, 0.05
        spec.visual.quality.shadowsize = SHADOW_PX

    def set(self, model: mujoco.MjModel, seen: Seen) -> None:
        """Vertices, normals and texels for where a machine stands; `upload` shows them."""
        s_m = self.lines_s + _snapped(seen.s_m, LONGER * self.fine_m)
        t_m = self.lines_t + _snapped(seen.t_m, self.fine_m)
        height_m, _, _ = _ground(seen, s_m, t_m, self.fine_m)
        s, t = np.meshgrid(s_m, t_m, indexing="ij")
        points = np.stack([s, t, height_m], axis=-1) @ seen.world_from_ground.T
        mesh, light = model.mesh(NAME).id, model.light(NAME).id
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        model.mesh_vert[first : first + count] = points.reshape(-1, 3)
        first = model.mesh_normaladr[mesh]
        model.mesh_normal[first : first + count] = normals(points).reshape(-1, 3)
        geom = model.geom(NAME).id
        model.geom_pos[geom], model.geom_quat[geom] = 0.0, (1.0, 0.0, 0.0, 0.0)
        model.geom_sameframe[geom] = 0
        above = seen.world_from_ground @ [seen.s_m, seen.t_m, 12.0]
        model.light_pos[light] = above - 12.0 * model.light_dir[light] / abs(
            model.light_dir[light, 2]
        )
        texture = model.texture(NAME).id
        texels = _texels(seen, _between(s_m), _between(t_m), self.fine_m)
        first = model.tex_adr[texture]
        model.tex_data[first : first + texels.size] = texels.ravel()

    @staticmethod
    def upload(model: mujoco.MjModel, context: mujoco.MjrContext) -> None:
        """Give OpenGL what was set."""
        mujoco.mjr_uploadMesh(model, context, model.mesh(NAME).id)
        mujoco.mjr_uploadTexture(model, context, model.texture(NAME).id)


def _ground(seen: Seen, s_m: Array, t_m: Array, fine_m: float) -> tuple[Array, Array, Array]:
    """Height of the ground, where it is turned, and where a furrow is open. Shape (n, m) each."""
    s, t = np.meshgrid(s_m, t_m, indexing="ij")
    height, turned, open_ = np.zeros_like(s), np.zeros(s.shape, bool), np.zeros(s.shape, bool)
    if seen.bodies is not None:
        for cut in seen.cuts:
            found, here = left_by(cut, seen.bodies, seen.furrow_depth_m, s, t)
            height = np.where(here, found, height)
            turned, open_ = turned | (here & (found >= 0.0)), open_ | (here & (found < 0.0))
        for done in seen.done:
            found, here, cut_here = worked_by(done, seen.bodies, seen.depth_m, s, t)
            height = np.where(here, found, height)
            turned, open_ = np.where(here, ~cut_here, turned), np.where(here, cut_here, open_)
    grain = 0.6 * _grain(s_m, t_m, GRAIN_M[1], 1) + 0.4 * _grain(s_m, t_m, 0.37 * GRAIN_M[1], 2)
    relief = np.where(turned, RELIEF[1], RELIEF[0]) * grain
    away_m = np.maximum(np.abs(s - seen.s_m), np.abs(t - seen.t_m))
    height = height + relief * np.clip(2.0 - away_m / (160.0 * fine_m), 0.0, 1.0)
    if seen.heights is not None:
        height = height + seen.heights.at(s, t)
    return height, turned, open_


def _texels(seen: Seen, s_m: Array, t_m: Array, fine_m: float) -> NDArray[np.uint8]:
    """Colour of the ground, rows along s as OpenGL takes them. Shape (n, m, 3)."""
    _, turned, open_ = _ground(seen, s_m, t_m, fine_m)
    cells = np.maximum(np.gradient(s_m)[:, None], np.gradient(t_m)[None]).astype(np.float32)
    fine, middle, wide, widest = (  # what is finer than the texels is left out
        _grain(s_m, t_m, cell, 3 + k) / (1.0 + (0.7 * cells / cell) ** 2)
        for k, cell in enumerate(GRAIN_M)
    )
    colour = np.empty((*turned.shape, 3), np.float32)
    colour[:] = LAND
    rows = np.cos(2.0 * np.pi * t_m / ROW_M) / (1.0 + (2.0 * cells / ROW_M) ** 4)
    straw = np.clip(0.28 + 0.35 * rows + 0.22 * fine + 0.12 * middle, 0.0, 1.0)[..., None]
    colour += straw * (np.array(STRAW, np.float32) - colour)
    colour[turned], colour[open_] = TURNED, SOLE
    bright = 1.0 + 0.07 * fine + 0.06 * middle + 0.04 * wide + 0.05 * widest
    return np.asarray(np.clip(colour * bright[..., None], 0.0, 255.0), np.uint8)


def _grain(s_m: Array, t_m: Array, cell_m: float, which: int) -> Array:
    """Smooth noise of unit standard deviation, a function of place. Shape (n, m)."""
    table = _table(which)
    size = len(table)
    rows, columns = np.mod(s_m / cell_m, size), np.mod(t_m / cell_m, size)
    across, along = np.meshgrid(columns.astype(np.float32), rows.astype(np.float32))
    return np.asarray(cv2.remap(table, across, along, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP))


def _table(which: int, size: int = 509) -> Array:
    if which not in _TABLES:
        rough = np.random.default_rng(which).standard_normal((size, size)).astype(np.float32)
        smooth = cv2.GaussianBlur(rough, (0, 0), 0.7)
        _TABLES[which] = smooth / smooth.std()
    return _TABLES[which]


_TABLES: dict[int, Array] = {}


def _lines(fine_m: float, near_m: float) -> Array:
    """Lines of the mesh from its middle: close near it, and ever further apart to the horizon."""
    near = fine_m * np.arange(round(near_m / fine_m) + 1)
    far, step_m = [], fine_m
    at_m = float(near[-1])
    while at_m < HORIZON_M:
        step_m *= GROWTH
        at_m += step_m
        far.append(at_m)
    half = np.concatenate([near, far])
    return np.concatenate([-half[:0:-1], half])


def _between(lines: Array) -> Array:
    """Places of the texels along lines of the mesh, which lie in the middle of theirs."""
    n = len(lines)
    at = (np.arange(TEXELS * n) + 0.5) / TEXELS - 0.5
    return np.interp(at, np.arange(n), lines)


def _snapped(place_m: float, cell_m: float) -> float:
    return float(cell_m * np.round(place_m / cell_m))
