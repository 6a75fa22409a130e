"""The MJCF of an implement from the numbers of its file, made with mjSpec.

Its body is called `frame`; joints, sites and numerics are called as in a hand-made MJCF
(models/plough_1lf435).
"""

from __future__ import annotations

import math

import mujoco

from twin.io.plain import Plain
from twin.machine.looks import BOX, CAPSULE, CYLINDER, UPRIGHT, VISUAL
from twin.vehicle.derive import Derived
from twin.vehicle.implement import Implement
from twin.vehicle.implement_derive import derive_implement
from twin.vehicle.kinds import KINDS
from twin.vehicle.numerics import implement_numerics

FRAME, STEEL, RUBBER = (0.10, 0.24, 0.50, 1.0), (0.50, 0.49, 0.47, 1.0), (0.085, 0.085, 0.09, 1.0)
AXIS_M = 0.05
"""Height of the axis about which a plough turns over."""
LASER_M = (-1.0, 0.9, 0.05)
"""Where the range finder sits on the frame of a large plough."""


def tool_places_m(part: Implement, n: Derived) -> list[tuple[float, float]]:
    """Where the bodies or tools stand, x and y, the first one farthest to the left.

    Plough bodies stand one behind the other, each a width to the right. Tools are evenly spaced
    across, on the bars in turn: on three bars the order from the left is front, middle, rear.
    """
    count, width_m = int(n["bodies"]), n["body_width_m"]
    first_m = 0.5 * (count - 1) * width_m
    rows = count if KINDS[part.kind].furrow else int(n["rows"])
    step_m = (n["length_m"] - 0.65) / max(1, rows - 1)
    return [
        (-0.65 - step_m * (i % rows if rows < count else i), first_m - i * width_m)
        for i in range(count)
    ]


def implement_spec(part: Implement) -> mujoco.MjSpec:
    """mujoco.MjSpec of an implement on its own; its `frame` hangs on two hitch points."""
    n, kind = derive_implement(part), KINDS[part.kind]
    spec = mujoco.MjSpec()
    spec.modelname = part.name
    spec.compiler.degree = False
    for name, value in implement_numerics(n).items():
        spec.add_numeric(name=name, size=1, data=[value])
    frame = spec.worldbody.add_body(name="frame")
    mass_kg, length_m, width_m, sole_m = (
        n[k] for k in ("mass_kg", "length_m", "width_m", "sole_m")
    )
    frame.add_joint(
        name="pitch", axis=[0, 1, 0], range=[-0.8, 0.8], limited=1, damping=0.2 * mass_kg
    )
    frame.mass, frame.ipos = mass_kg, [n["cg_x_m"], 0.0, 0.35 * sole_m]
    long, wide, tall = (max(0.5, length_m) ** 2, max(0.5, width_m) ** 2, sole_m**2)
    frame.inertia = [mass_kg / 12.0 * s for s in (wide + tall, long + tall, 0.999 * (long + wide))]
    frame.explicitinertial = True
    middle_m, half_m = -0.65 - 0.5 * (length_m - 0.65), 0.5 * max(0.16, length_m - 0.65)
    wide_m = 0.08 if kind.furrow else 0.45 * width_m
    frame.add_geom(
        name="beam", type=BOX, pos=[middle_m, 0.0, 0.05], size=[half_m, wide_m, 0.08], contype=2,
        conaffinity=1, group=3, rgba=[0.6, 0.5, 0.4, 0.3], mass=0.0,
    )  # fmt: skip
    frame.add_site(name="top_link_rear", pos=[0.05, 0.0, n["mast_m"]])
    places = tool_places_m(part, n)
    for i, (x, y) in enumerate(places):
        aside = frame.add_frame(name=f"aside.{i + 1}", pos=[x, y, 0.0])
        frame.add_site(name=f"share_{i + 1}", pos=[0.0, 0.0, sole_m]).set_frame(aside)
        if kind.furrow:
            turned = frame.add_frame(name=f"turned.{i + 1}", pos=[0.0, 0.0, AXIS_M])
            turned.set_frame(aside)
            _dress_body(frame, turned, sole_m, n["body_width_m"])
    laser_m = [LASER_M[0] * min(1.0, length_m / 3.2), min(0.9, 0.5 * width_m + 0.2), LASER_M[2]]
    frame.add_site(name="depth_laser", pos=laser_m)
    radius_m = n["gauge_wheel.radius_m"]
    wheel = frame.add_body(
        name="depth_wheel", pos=[n["gauge_wheel.x_m"], 0.0, sole_m + 0.25 + radius_m]
    )
    wheel.mass, wheel.inertia, wheel.explicitinertial = 1e-3, [1e-6] * 3, True
    wheel.add_geom(
        name="depth_wheel_rim", type=CYLINDER, size=[radius_m, 0.08, 0.0], quat=UPRIGHT, contype=2,
        conaffinity=1, group=3, rgba=[0.1, 0.1, 0.1, 0.3], mass=0.0,
    )  # fmt: skip
    _dress(frame, wheel, part, n, places)
    for kind_, name, what, which in (
        ("JOINTPOS", "pitch_rad", "JOINT", "pitch"), ("FRAMEPOS", "laser_w", "SITE", "depth_laser"),
        ("FRAMEQUAT", "world_from_laser", "SITE", "depth_laser"),
    ):  # fmt: skip
        spec.add_sensor(
            name=name, type=getattr(mujoco.mjtSensor, f"mjSENS_{kind_}"),
            objtype=getattr(mujoco.mjtObj, f"mjOBJ_{what}"), objname=which,
        )  # fmt: skip
    return spec


def _dress_body(frame: Plain, turned: Plain, sole_m: float, width_m: float) -> None:
    """Draw the two bodies of a reversible plough, below and above the axis it turns over about."""
    for up in (1.0, -1.0):
        low = up * (sole_m - AXIS_M)
        leg = frame.add_geom(
            type=BOX, pos=[-0.15, -0.16 * up * width_m / 0.35, 0.5 * low],
            size=[0.08, 0.025, 0.5 * abs(low)], rgba=list(FRAME), **VISUAL,
        )  # fmt: skip
        board = frame.add_geom(
            type=BOX, pos=[-0.10, 0.0, low + 0.17 * up], size=[0.30, 0.015, 0.17],
            quat=_turned(0.65, -0.25 * up), rgba=list(STEEL), **VISUAL,
        )  # fmt: skip
        for geom in (leg, board):
            geom.set_frame(turned)


def _turned(about_z: float, about_x: float) -> list[float]:
    """A turn about x and then about z, as a quaternion."""
    a, b = 0.5 * about_z, 0.5 * about_x
    return [math.cos(a) * math.cos(b), math.cos(a) * math.sin(b),
            math.sin(a) * math.sin(b), math.sin(a) * math.cos(b)]  # fmt: skip


def _dress(
    frame: Plain, wheel: Plain, part: Implement, n: Derived, places: list[tuple[float, float]]
) -> None:
    """Draw headstock, bars, tools and the gauge wheel."""
    kind, width_m, sole_m = KINDS[part.kind], n["width_m"], n["sole_m"]

    def bar(start: Plain, end: Plain, radius: float, rgba: Plain = FRAME) -> None:
        frame.add_geom(
            type=CAPSULE, size=[radius, 0.0, 0.0], fromto=[*start, *end], rgba=list(rgba), **VISUAL
        )

    bar((0, -0.42, 0), (0, 0.42, 0), 0.03, STEEL)
    for side in (1, -1):
        bar((0, side * 0.35, 0.02), (0.04, side * 0.05, n["mast_m"]), 0.035)
    last_m = min(x for x, _ in places)
    bar((0.02, 0.0, n["mast_m"] - 0.04), (max(last_m, -0.65), 0.0, 0.08), 0.03)
    if kind.furrow:
        aside = frame.add_frame(name="aside.beam")
        turned = frame.add_frame(name="turned.beam", pos=[0.0, 0.0, AXIS_M])
        turned.set_frame(aside)
        (x0, y0), (x1, y1) = places[0], places[-1]
        for ends in (((0.0, 0.0), (x0, y0)), ((x0 + 0.1, y0), (x1 - 0.2, y1))):
            beam = frame.add_geom(
                type=CAPSULE, size=[0.07, 0.0, 0.0], fromto=[*ends[0], 0.0, *ends[1], 0.0],
                rgba=list(FRAME), **VISUAL,
            )  # fmt: skip
            beam.set_frame(turned)
    else:
        for x in sorted({x for x, _ in places}):
            bar((x, -0.5 * width_m, 0.05), (x, 0.5 * width_m, 0.05), 0.05)
        for y in (-0.25 * width_m, 0.25 * width_m):
            bar((0.0, y, 0.05), (last_m, y, 0.05), 0.045)
    for x, y in [] if kind.furrow else places:
        bar((x, y, 0.05), (x - 0.12, y, 0.45 * sole_m), 0.022, STEEL)
        bar((x - 0.12, y, 0.45 * sole_m), (x, y, sole_m + 0.02), 0.020, STEEL)
        frame.add_geom(
            type=BOX, pos=[x - 0.02, y, sole_m + 0.03],
            size=[0.09, 0.04 if part.kind != "sweep" else 0.4 * n["body_width_m"], 0.012],
            quat=[math.cos(0.2), 0.0, math.sin(0.2), 0.0], rgba=list(STEEL), **VISUAL,
        )  # fmt: skip
    if part.gauge_wheel.fitted:
        radius_m = n["gauge_wheel.radius_m"]
        wheel.add_geom(
            type=CYLINDER, size=[radius_m, 0.08, 0.0], quat=UPRIGHT, rgba=list(RUBBER), **VISUAL
        )
        wheel.add_geom(
            type=CYLINDER,
            size=[0.6 * radius_m, 0.09, 0.0],
            quat=UPRIGHT,
            rgba=list(FRAME),
            **VISUAL,
        )
        wheel.add_geom(
            type=CAPSULE, size=[0.03, 0.0, 0.0], fromto=[0.0, 0.12, 0.0, 0.15, 0.12, 0.5],
            rgba=list(FRAME), **VISUAL,
        )  # fmt: skip
