"""What a plough leaves of the ground: open furrows, and slices that lie turned, as heights.

Across a pass, u counts from its line to the side the soil is turned to:

    body i cuts             from e_i      to e_i + w        e_i its edge on the land's side
    the furrow stays open   from e_i      to e_i + f        f the width of an open furrow
    its slice lies          from e_i + f  to e_i + f + w    in the furrow of the body before it

The width w of a turned slice of depth d is inclined to the furrow's bottom by
a = asin(min(d / w, 0.85)). The upper edges of the slices form a sawtooth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.viz.bodies import Bodies
from twin.viz.tools import Array

PLOUGHED_M = 6.0
"""How far the land beside the first furrow was ploughed before the run, as drawn."""
BANK_M = 0.05
"""Width over which a wall falls, as drawn."""
CRUMBLED = 0.7
"""Height of the turned slices' edges over that of slices which do not crumble."""
STEEPEST = 0.85
"""Largest depth over width at which a slice still leans on the next and does not stand."""


@dataclass(frozen=True, kw_only=True)
class Cut:
    """An open furrow: where its wall is, and from when on and over which stretch it lies there."""

    from_ns: int
    wall_m: float
    low_m: float
    high_m: float
    ploughed_m: float = PLOUGHED_M
    """How far from the wall the land was ploughed that is drawn with it."""


@dataclass(frozen=True, kw_only=True)
class Pass:
    """The way of a pass in the ground, over which the bodies worked."""

    s_m: Array
    """Along the ground; monotonic."""
    t_m: Array
    """Of the tractor's line there."""


def leaning_rad(depth_m: float, width_m: float) -> float:
    """Inclination of a turned slice's width to the furrow's bottom: asin(min(d / w, 0.85))."""
    return float(np.arcsin(min(depth_m / width_m, STEEPEST)))


def ridges_m(u_m: Array, depth_m: float, width_m: float) -> Array:
    """Height of turned slices above the field, whose valleys are where u is a multiple of w.

    A sawtooth of slopes tan(a) and -cot(a), with a of `leaning_rad`, and 0.7 times as high because
    the edges crumble.
    """
    angle = leaning_rad(depth_m, width_m)
    along_m = np.mod(u_m, width_m)
    rising_m = width_m * np.cos(angle) ** 2
    crest_m = CRUMBLED * width_m * np.sin(angle) * np.cos(angle)
    up, down = along_m / rising_m, (width_m - along_m) / (width_m - rising_m)
    return np.asarray(crest_m * np.minimum(up, down))


def left_by(cut: Cut, bodies: Bodies, depth_m: float, s: Array, t: Array) -> tuple[Array, Array]:
    """What an earlier pass left: its open furrow, and beside it the land that it ploughed.

    Returns:
        height above the field [m], and whether it is set here; as s and t.
    """
    u = bodies.side * (t - cut.wall_m)
    if cut.low_m == np.inf:
        return np.zeros_like(s), np.zeros(s.shape, bool)
    along = np.clip((s - cut.low_m) / 1.5, 0.0, 1.0) * np.clip((cut.high_m - s) / 1.5, 0.0, 1.0)
    open_ = (u > 1e-6) & (u < bodies.open_m + BANK_M - 1e-6)
    turned = (u >= bodies.open_m + BANK_M - 1e-6) & (u < cut.ploughed_m)
    height = open_ * -depth_m + turned * ridges_m(u - bodies.open_m, depth_m, bodies.width_m)
    return along * height, (along > 0.0) & (open_ | turned)


def worked_by(
    done: Pass, bodies: Bodies, depth_m: float, s: Array, t: Array, *, slices: bool = True
) -> tuple[Array, Array, Array]:
    """What the bodies have made of the ground so far on a pass.

    Args:
        done: the pass until now.
        bodies: of the plough.
        depth_m: of the furrows.
        s, t: places on the ground.
        slices: lay them too; without, the furrows are all open.

    Returns:
        height above the field [m]; whether it is set here, and whether it is an open furrow.
    """
    if len(done.s_m) < 2:
        return np.zeros_like(s), np.zeros(s.shape, bool), np.zeros(s.shape, bool)
    way = 1.0 if done.s_m[-1] > done.s_m[0] else -1.0
    height, here, open_ = np.zeros_like(s), np.zeros(s.shape, bool), np.zeros(s.shape, bool)
    for i in range(bodies.count):
        of_tractor = way * (s - way * bodies.ahead_m[i])  # where it was when the body was at s
        passed = (of_tractor >= way * done.s_m[0]) & (of_tractor <= way * done.s_m[-1])
        line = np.interp(of_tractor, way * done.s_m, done.t_m)
        u = bodies.side * (t - line) - bodies.edge_m[i]
        wide = bodies.open_m if i else max(bodies.open_m, bodies.wall_m - bodies.edge_m[0])
        furrow = passed & (u > 0.0) & (u < wide)
        height[furrow], here[furrow], open_[furrow] = -depth_m, True, True
        if slices:
            end_m = bodies.open_m + bodies.width_m + (0.0 if i else BANK_M)
            turned = passed & (u >= bodies.open_m) & (u < end_m)
            height[turned] = ridges_m(u - bodies.open_m, depth_m, bodies.width_m)[turned]
            here[turned], open_[turned] = True, False
    return height, here, open_
