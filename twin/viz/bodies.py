"""The drawn bodies of a model's plough, and the furrow beside which they work."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from twin.physics import block
from twin.physics.block import Field
from twin.viz.tools import Array

SHARE, WIDTH, BLOCK = "plough.share_", "plough.body_width_m", "tractor_twin"


@dataclass(frozen=True, kw_only=True)
class Bodies:
    """Where the bodies of a plough cut, and where they throw what they cut."""

    ahead_m: tuple[float, ...]
    """Where the shares stand along the tractor, the one beside the furrow first; all negative."""
    left_m: tuple[float, ...]
    """The same to the left of the tractor."""
    width_m: float
    """Of one body."""
    side: int
    """To which they turn the soil: 1 left, -1 right."""
    wall_m: float
    """Wall of the last furrow, to that side of the tractor's line."""
    open_m: float
    """Width of an open furrow; so far to the side a slice is thrown."""

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.ahead_m)

    @property
    def aside_m(self) -> Array:
        """Middles of the bodies, to the side they turn to, from the line. Shape (m,)."""
        return self.side * np.array(self.left_m)

    @property
    def edge_m(self) -> Array:
        """Where each body's own cut ends on the land's side, as `aside_m`. Shape (m,)."""
        return self.aside_m - 0.5 * self.width_m


def bodies(model: mujoco.MjModel) -> Bodies | None:
    """Those of a compiled mujoco.MjModel; None for one without a plough.

    Its sites `plough.share_1`, ... are where the soil's forces act, `plough.body_width_m` is a
    <numeric>; they turn the soil to the side on which the first body stands. The furrow is that of
    the parameter block; without one, it is as wide as a body and the first body meets its wall.
    """
    names = [model.site(i).name for i in range(model.nsite)]
    shares = sorted(n for n in names if n.startswith(SHARE))
    if not shares or mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, WIDTH) < 0:
        return None
    place_m = np.array([_place_m(model, model.site(name)) for name in shares])
    width_m, left_m, field = float(model.numeric(WIDTH).data[0]), place_m[:, 1], _field(model)
    side = int(np.sign(left_m[0] - left_m[-1])) or int(field.get(Field.FURROW_SIDE, 0.0)) or -1
    return Bodies(
        ahead_m=tuple(place_m[:, 0].tolist()),
        left_m=tuple(left_m.tolist()),
        width_m=width_m,
        side=side,
        wall_m=field.get(Field.FURROW_EDGE_M) or side * float(left_m[0]) + 0.5 * width_m,
        open_m=field.get(Field.FURROW_WIDTH_M) or width_m,
    )


def _field(model: mujoco.MjModel) -> dict[int, float]:
    """The ground's numbers of the parameter block, none without one."""
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, BLOCK) < 0:
        return {}
    numbers = model.numeric(BLOCK).data[block.FIELD : block.FIELD + Field.SIZE]
    return dict(enumerate(numbers.tolist()))


def _place_m(model: mujoco.MjModel, site: Any) -> Array:
    """Place ahead and to the left on the machine, with the linkage level."""
    place_m, body = np.array(site.pos), int(site.bodyid[0])
    while int(model.body_parentid[body]) != 0:
        place_m = place_m + model.body_pos[body]
        body = int(model.body_parentid[body])
    return np.asarray(place_m[:2])
