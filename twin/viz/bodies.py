"""The bodies of a model's plough, as they are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco

SHARE, WIDTH = "plough.share_", "plough.body_width_m"


@dataclass(frozen=True, kw_only=True)
class Bodies:
    """Where the bodies of a plough cut."""

    ahead_m: tuple[float, ...]
    """Where the shares stand along the tractor, the one beside the furrow first; all negative."""
    width_m: float
    """Of one body."""

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.ahead_m)


def bodies(model: Any) -> Bodies | None:
    """Those of a compiled mujoco.MjModel; None for one without a plough.

    Its sites `plough.share_1`, ... are the share tips, and `plough.body_width_m` a <numeric>.
    """
    names = [model.site(i).name for i in range(model.nsite)]
    shares = sorted(n for n in names if n.startswith(SHARE))
    if not shares or mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, WIDTH) < 0:
        return None
    return Bodies(
        ahead_m=tuple(_ahead_m(model, model.site(name)) for name in shares),
        width_m=float(model.numeric(WIDTH).data[0]),
    )


def _ahead_m(model: Any, site: Any) -> float:
    """Place along the machine with the linkage level."""
    ahead_m, body = float(site.pos[0]), int(site.bodyid[0])
    while int(model.body_parentid[body]) != 0:
        ahead_m += float(model.body_pos[body][0])
        body = int(model.body_parentid[body])
    return ahead_m
