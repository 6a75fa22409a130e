"""The drawn tractors of a fleet, each on its own field with what it has ploughed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from twin.env.fleet import Fleet
from twin.env.rendering import Look
from twin.physics import block
from twin.physics.block import Field
from twin.viz.field import Seen
from twin.viz.furrows import Cut, Pass
from twin.viz.ground import SHALLOWEST_M
from twin.viz.stage import Stage

Place = tuple[float, float]


class Staging:
    """A stage for the tractors of a fleet, who are looked at one after the other."""

    def __init__(self, look: Look, fleet: Fleet) -> None:
        machine = fleet.machine
        self.stage = Stage(machine.scenario, machine.setting, camera=look.camera)
        self.furrows: dict[int, list[list[Place]]] = {}
        self.last_s_m: dict[int, float] = {}

    def set(self, fleet: Fleet, i: int) -> Stage:
        """The stage with one of the tractors in its present state."""
        rotation, qpos = fleet.world_from_ground[i], fleet.qpos[i]
        s_m, t_m = (qpos[:3] @ rotation)[:2].tolist()
        field = fleet.blocks[i, block.FIELD : block.FIELD + Field.SIZE]
        seen = Seen(s_m=s_m, t_m=t_m, world_from_ground=rotation)
        if self.stage.bodies is not None:
            seen = replace(seen, **self._ploughed(fleet, i, field, (s_m, t_m)))
        self.stage.set(qpos, seen)
        return self.stage

    def _ploughed(self, fleet: Fleet, i: int, field: Any, place: Place) -> dict[str, Any]:
        """The last furrow, and what was ploughed between the looks so far of this episode.

        Between two looks it is taken to have gone straight, and to have ploughed if it does at
        both.
        """
        assert self.stage.bodies is not None
        if place[0] < self.last_s_m.get(i, np.inf):  # another episode
            self.furrows[i] = [[]]
        self.last_s_m[i] = place[0]
        if fleet.true()["depth_m"][i] > SHALLOWEST_M:
            self.furrows[i][-1].append(place)
        elif self.furrows[i][-1]:
            self.furrows[i].append([])
        ways = [np.array(way).reshape(-1, 2) for way in self.furrows[i]]
        side, wall_m = self.stage.bodies.side, float(field[Field.FURROW_EDGE_M])
        cut = Cut(
            from_ns=0,
            wall_m=side * wall_m,
            low_m=float(field[Field.FURROW_START_M]),
            high_m=float(field[Field.FURROW_END_M]),
        )
        return {
            "bodies": replace(self.stage.bodies, wall_m=wall_m),
            "furrow_depth_m": float(field[Field.FURROW_DEPTH_M]),
            "depth_m": fleet.machine.scenario.plough.depth_m,  # type: ignore[union-attr]
            "cuts": [cut],
            "done": [Pass(s_m=way[:, 0], t_m=way[:, 1]) for way in ways],
        }
