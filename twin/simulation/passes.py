"""Passes over a field: which leg is driven, where the furrow lies, and the plough turned over."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

from mujoco.batch import Batch

from twin.machine.build import Machine
from twin.physics import block
from twin.physics.block import Field
from twin.scenario import Scenario
from twin.scenario.route import CLEAR_M, Leg, backed_turn, land_side, on_leg, turn, width_m
from twin.simulation.build import build

LEAD_M = 2.5
"""How far ahead of an arc the driver begins to turn the wheel [m]: half of what it takes him."""
ENDS_AHEAD_M = 1.0
"""How far before the front axle the furrow ends where the plough is raised [m]."""
SIDES = {"right": "left", "left": "right", "none": "none"}


class Passes:
    """What of a run changes from pass to pass."""

    def __init__(self, machine: Machine, batch: Batch) -> None:
        self.machine, self.batch = machine, batch
        self.count, self.legs = 1, deque([Leg(0.0, 0.0, 0.0)])
        self.more = machine.scenario.course.passes > 1
        if self.more:
            numbers = machine.numbers
            self.width_m, self.side = (
                width_m(machine.scenario, numbers),
                land_side(machine.scenario),
            )
            self.models = (
                machine.model,
                build(turned_over(machine.scenario), setting=machine.setting).model,
            )
            self.block = batch.expand("numeric_data")[0, -block.SIZE :]
            self.quat = batch.expand("body_quat")[0]

    @property
    def turning(self) -> bool:
        """Whether on a headland."""
        return math.isfinite(self.legs[0].length_m)

    def where(self, s_m: float, t_m: float, heading_rad: float) -> tuple[float, float, float]:
        """Distance along this leg, lateral and heading error; the next leg where one has ended."""
        while True:
            along, left, turned = on_leg(self.legs[0], s_m, t_m, heading_rad)
            if along < self.legs[0].length_m:
                return along, left, turned
            self.legs.popleft()
            if not self.turning:
                self._begin()

    def curvature_pm(self, along_m: float) -> float:
        """Of the way a little ahead."""
        soon = self.turning and along_m + LEAD_M > self.legs[0].length_m
        soon = soon and self.legs[1].back == self.legs[0].back  # else the machine stops first
        return self.legs[1 if soon else 0].curvature_pm

    def end(self, along_m: float) -> bool:
        """End a pass; whether it was the last."""
        if self.count == self.machine.scenario.course.passes:
            return True
        line, way = self.legs[0], self._way()
        self.end_furrow(along_m)
        start = replace(line, s_m=line.s_m + way * along_m)
        aside_m = self.side * self.count * self.width_m
        course, side = self.machine.scenario.course, round(way) * self.side
        if course.headland == "backing":
            self.legs = deque(backed_turn(start, self.width_m, side, course.backings))
        else:
            self.legs = deque(turn(start, self.width_m, side))
        self.count += 1
        self.legs.append(Leg(start.s_m + way * CLEAR_M, aside_m, 0.0 if way < 0.0 else math.pi))
        return False

    def end_furrow(self, along_m: float) -> None:
        """The furrow ends a little before the front axle."""
        front_m = along_m + float(self.machine.model.body("front_axle").pos[0])
        self.block[block.FIELD + Field.FURROW_END_M] = front_m + ENDS_AHEAD_M

    def _way(self) -> float:
        return 1.0 if self.count % 2 else -1.0

    def _begin(self) -> None:
        """The last furrow lies along the new line, the plough is turned over."""
        line, model = self.legs[0], self.models[(self.count - 1) % 2]
        other = model.numeric_data[-block.SIZE :]
        for part in (slice(block.ENGINE), slice(block.PLOUGH, None)):  # the gear stays in
            self.block[part] = other[part]
        for slot, value in (
            (Field.PASS_S_M, line.s_m), (Field.PASS_T_M, line.t_m), (Field.PASS_WAY, self._way()),
        ):  # fmt: skip
            self.block[block.FIELD + slot] = value
        if self.machine.scenario.plough is not None:
            frame = model.body("plough.frame").id
            self.quat[frame] = model.body_quat[frame]
            self.batch.set_const()


def turned_over(scenario: Scenario) -> Scenario:
    """The same with the furrow on the other side, as a reversible plough works on the way back."""
    if scenario.plough is None:
        return scenario
    return replace(scenario, plough=replace(scenario.plough, furrow=SIDES[scenario.plough.furrow]))
