"""Visual geometry of a generated machine: bonnet, cab, mudguards and wheels in its proportions.

It has no mass and no contacts. Lengths are shares of the wheelbase along, of the rear track across
and of the rear tyre's radius up, so a small tractor is drawn small.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from twin.io.plain import Plain
from twin.vehicle.derive import Derived
from twin.vehicle.machine import Machine

VISUAL = {"contype": 0, "conaffinity": 0, "group": 2, "mass": 0.0}
COLOURS = {
    "rubber": (0.085, 0.085, 0.09, 1.0), "cast": (0.17, 0.18, 0.20, 1.0),
    "trim": (0.10, 0.10, 0.11, 1.0), "glass": (0.62, 0.78, 0.84, 0.28),
    "rim": (0.88, 0.80, 0.45, 1.0), "roof": (0.80, 0.78, 0.74, 1.0),
    "exhaust": (0.45, 0.43, 0.41, 1.0), "lamp": (0.98, 0.97, 0.88, 1.0),
    "antenna": (0.96, 0.96, 0.96, 1.0), "weight": (0.20, 0.21, 0.22, 1.0),
}  # fmt: skip
PAINTS = ((0.12, 0.38, 0.16), (0.62, 0.10, 0.06), (0.10, 0.22, 0.50), (0.78, 0.42, 0.08))
"""Colours of bonnets (red, green, blue); the machine's name decides which one is used."""
BOX, CYLINDER, CAPSULE = (
    mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE
)  # fmt: skip
LUGS = 14
UPRIGHT = [math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0]


def dress_machine(spec: mujoco.MjSpec, tractor: Plain, machine: Machine, n: Derived) -> None:
    """Draw the body of a machine."""
    length, across, up = n["wheelbase_m"], 0.5 * n["rear.track_m"], 0.5 * n["rear.diameter_m"]
    red, green, blue = PAINTS[sum(map(ord, machine.name)) % len(PAINTS)]
    paint = [red, green, blue, 1.0]
    top_m = n["height_m"] - n["rear.height_m"]

    def box(x: tuple[float, float], y: float, z: tuple[float, float], rgba: Plain) -> None:
        tractor.add_geom(
            type=BOX, pos=[0.5 * (x[0] + x[1]), 0.0, 0.5 * (z[0] + z[1])],
            size=[0.5 * (x[1] - x[0]), y, 0.5 * (z[1] - z[0])], rgba=list(rgba), **VISUAL,
        )  # fmt: skip

    def rod(start: Plain, end: Plain, radius: float, rgba: Plain) -> None:
        tractor.add_geom(
            type=CAPSULE, size=[radius, 0.0, 0.0], fromto=[*start, *end], rgba=list(rgba), **VISUAL
        )

    box((-0.14 * length, 0.42 * length), 0.22 * across, (-0.25 * up, 0.3 * up), COLOURS["cast"])
    box((0.4 * length, 1.08 * length), 0.26 * across, (-0.15 * up, 0.28 * up), COLOURS["cast"])
    rod((0, -0.75 * across, 0), (0, 0.75 * across, 0), 0.19 * up, COLOURS["cast"])
    _hull(spec, tractor, "bonnet", paint, [
        *((0.47 * length, s * y * across, z * up) for s in (1, -1)
          for y, z in ((0.33, 1.14), (0.40, 1.0), (0.40, 0.28))),
        *((x * length, s * y * across, z * up) for s in (1, -1)
          for x, y, z in ((1.19, 0.28, 0.97), (1.21, 0.37, 0.84), (1.23, 0.37, 0.28))),
    ])  # fmt: skip
    box((1.21 * length, 1.25 * length), 0.33 * across, (0.27 * up, 0.9 * up), COLOURS["trim"])
    for side in (1.0, -1.0):
        tractor.add_geom(
            type=BOX, pos=[1.25 * length, side * 0.22 * across, 0.75 * up],
            size=[0.01 * length, 0.08 * across, 0.06 * up], rgba=list(COLOURS["lamp"]), **VISUAL,
        )  # fmt: skip
        fender = 1.08 * up
        for k in range(5):
            low, high = (math.radians(35.0 + 27.0 * j) for j in (k, k + 1))
            ends = [(fender * math.cos(a), side * 0.78 * across, fender * math.sin(a))
                    for a in (low, high)]  # fmt: skip
            middle = 0.5 * (np.array(ends[0]) + np.array(ends[1]))
            angle = 0.5 * (low + high) - 0.5 * math.pi
            tractor.add_geom(
                type=BOX, pos=middle.tolist(), size=[0.26 * up, 0.17 * across, 0.012 * up],
                quat=[math.cos(0.5 * angle), 0.0, -math.sin(0.5 * angle), 0.0], rgba=paint,
                **VISUAL,
            )  # fmt: skip
    if top_m > 1.6 * up:
        _cab(spec, tractor, length, across, up, top_m)
    else:
        rod((0.1 * length, 0.0, 0.3 * up), (0.1 * length, 0.0, top_m), 0.03 * up, COLOURS["cast"])
    rod((0.58 * length, -0.3 * across, 1.0 * up), (0.58 * length, -0.3 * across, top_m - 0.25 * up),
        0.05 * up, COLOURS["exhaust"])  # fmt: skip
    for name in ("gnss_main", "gnss_aux"):
        place = [n[f"places.{name}_m.{axis}"] for axis in "xyz"]
        tractor.add_geom(
            type=CYLINDER, pos=place, size=[0.07 * up, 0.03 * up, 0.0],
            rgba=list(COLOURS["antenna"]), **VISUAL,
        )  # fmt: skip
    for weight in machine.ballast:
        edge = 0.5 * (weight.mass_kg / 7200.0) ** (1.0 / 3.0)
        tractor.add_geom(
            type=BOX, pos=[weight.x_m, 0.0, weight.z_m], size=[0.7 * edge, 2.0 * edge, 0.7 * edge],
            rgba=list(COLOURS["weight"]), **VISUAL,
        )  # fmt: skip


def _cab(
    spec: mujoco.MjSpec, tractor: Plain, length: float, across: float, up: float, top_m: float
) -> None:
    front, back, floor = 0.47 * length, -0.18 * length, 0.55 * up
    waist, wide = 1.0 * up, 0.66 * across
    tractor.add_geom(
        type=BOX, pos=[0.5 * (front + back), 0.0, 0.5 * (floor + waist)],
        size=[0.5 * (front - back), 0.62 * across, 0.5 * (waist - floor)],
        rgba=list(COLOURS["trim"]), **VISUAL,
    )  # fmt: skip
    ceiling = top_m - 0.12 * up
    edges = ((front, waist), (front - 0.07 * length, ceiling), (back, waist), (back, ceiling))
    corners = [(x, s * wide, z) for s in (1, -1) for x, z in edges]
    _hull(spec, tractor, "windows", COLOURS["glass"], corners)
    for side in (1, -1):
        for x, lean in ((front, 0.07 * length), (back, 0.0), (0.2 * length, 0.0)):
            tractor.add_geom(
                type=CAPSULE, size=[0.035 * up, 0.0, 0.0], rgba=list(COLOURS["trim"]),
                fromto=[x, side * wide, floor, x - lean, side * wide, ceiling], **VISUAL,
            )  # fmt: skip
    tractor.add_geom(
        type=BOX, pos=[0.5 * (front + back), 0.0, top_m - 0.06 * up],
        size=[0.53 * (front - back), 0.76 * across, 0.06 * up], rgba=list(COLOURS["roof"]),
        **VISUAL,
    )  # fmt: skip


def _hull(spec: mujoco.MjSpec, body: Plain, name: str, rgba: Plain, corners: Plain) -> None:
    """The convex hull of some points, as a mesh."""
    mesh = spec.add_mesh(name=name)
    mesh.uservert = np.array(corners, dtype=np.float64).ravel()
    # without inertia of its own a mesh is turned and moved to its middle; the geom undoes that
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, rgba=list(rgba), **VISUAL)


def dress_wheel(
    spec: mujoco.MjSpec, body: Plain, axle: str, side: int, machine: Machine, n: Derived
) -> None:
    """Draw a wheel: its tyre as a ring with lugs, its rim, and a second tyre outside of a pair."""
    radius, width, rim = (0.5 * n[f"{axle}.diameter_m"], n[f"{axle}.width_m"],
                          0.5 * n[f"{axle}.rim_m"])  # fmt: skip
    offsets = (0.0, side * 1.15 * width) if getattr(machine, axle).duals else (0.0,)
    name = f"tyre_{axle}"
    if spec.mesh(name) is None:
        ring = spec.add_mesh(name=name)
        section = 0.5 * (radius - rim)
        middle = 0.5 * (radius + rim)
        ring.make_supertorus(32, 0.96 * section / middle, 0.4, 1.0)
        ring.scale = [middle, middle, middle * 0.5 * width / section]
    for aside in offsets:
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, pos=[0.0, aside, 0.0], quat=UPRIGHT,
            rgba=list(COLOURS["rubber"]), **VISUAL,
        )  # fmt: skip
        body.add_geom(
            type=CYLINDER, size=[rim, 0.36 * width, 0.0], pos=[0.0, aside, 0.0], quat=UPRIGHT,
            rgba=list(COLOURS["rim"]), **VISUAL,
        )  # fmt: skip
        for k in range(LUGS):
            angle = 2.0 * math.pi * k / LUGS
            body.add_geom(
                type=BOX, size=[0.07 * radius, 0.48 * width, 0.025 * radius],
                pos=[0.965 * radius * math.sin(angle), aside, 0.965 * radius * math.cos(angle)],
                quat=[math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0],
                rgba=list(COLOURS["rubber"]), **VISUAL,
            )  # fmt: skip
    body.add_geom(
        type=CYLINDER, size=[0.35 * rim, 0.45 * width, 0.0], quat=UPRIGHT,
        rgba=list(COLOURS["cast"]), **VISUAL,
    )  # fmt: skip
