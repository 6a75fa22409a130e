"""Tractors that work a field with throttle, gear, and a hitch between position and draft."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.env.fleet import Fleet, Start, lay_soil, start_throttle
from twin.env.gearbox import FASTEST_KMH, SLOWEST_KMH, Gearbox, set_field_levers, set_ratio
from twin.env.grounds import Ground
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.physics import block
from twin.physics.block import Field, Soil
from twin.simulation.driver import HitchControl
from twin.simulation.records import records

Array = NDArray[np.float64]

EVERYWHERE_M = -1e9
"""Where the course's approach ends for a driver who lowers the plough when the actions say so."""


def gearbox(machine: Machine) -> Gearbox:
    """That of a machine with a plough set. Raises BadInput if it has none."""
    plough, setting, numbers = machine.scenario.plough, machine.setting, machine.numbers
    if plough is None or setting is None:
        raise BadInput(f"{machine.scenario.machine} has no plough; choose a machine that ploughs")
    rim_m = numbers["tyre_rear.free_rolling_radius_m"]
    at_1_kmh = 3.6 * rim_m * numbers["engine.rated_rpm"] * math.pi / 30.0
    least, most = machine.scenario.facts.ratio_range or (0.0, math.inf)
    return Gearbox(
        longest=max(least, at_1_kmh / FASTEST_KMH),
        shortest=min(most, at_1_kmh / SLOWEST_KMH),
        inertia_kgm2=numbers["engine.inertia_kgm2"],
        clutch_nm=numbers["clutch.capacity_nm"],
        rim_m=rim_m,
        draft_npm=setting.draft_n / plough.depth_m,
    )


class FieldFleet(Fleet):
    """The machines of Plough-v1, each in a gear of its own."""

    def __init__(
        self, machine: Machine, nsim: int = 1, nthread: int = 1, *, sensed: bool = True
    ) -> None:
        """As a fleet's."""
        super().__init__(machine, nsim, nthread, sensed=sensed)
        self.box = gearbox(machine)
        self.boxes = records(self.box, 1)
        self.ratios = np.array(machine.scenario.facts.ratios, dtype=np.float64)
        shaft = int(machine.model.joint("drive").dofadr[0])
        self.armature = self.batch.expand("dof_armature")[:, shaft]
        self.spin = self.qvel[:, shaft]
        self.shift_wait_s = np.zeros(nsim)
        self.tasks["hitch"], self.tasks["approach_m"] = int(HitchControl.VALVE), EVERYWHERE_M

    def restore(
        self, ids: Sequence[int], starts: Sequence[Start], grounds: Sequence[Ground]
    ) -> None:
        """As a fleet's, in the gear and with the throttle that the start was settled with."""
        ratio, throttle = self.machine.scenario.gear.ratio, self.machine.throttle
        for i, ground in zip(ids, grounds, strict=True):
            set_ratio(i, ratio, self.boxes[0], self.drivetrain, self.blocks, self.armature)
            self.tasks["throttle"][i], self.tasks["mix"][i] = throttle, 0.0
            self.shift_wait_s[i] = 0.0
            if ground.other_preset is not None:
                first = block.FIELD + Field.OTHER
                other = self.blocks[i, first : first + Soil.SIZE]
                lay_soil(other, ground.other_preset, ground.other_own, ground.law)
        super().restore(ids, starts, grounds)

    def act(self, actions: Array) -> None:
        """Throttle, gear, depth and mix by the actions, the rest by the driver."""
        set_field_levers(
            actions, self.levers, self.boxes, self.ratios, self.tasks, self.drivetrain,
            self.shift_wait_s, self.work_rad, self.blocks, self.armature, self.spin, self.period_s,
        )  # fmt: skip
        self.control()

    def gear_action(self) -> float:
        """The action of the gear that the starts are settled in."""
        box, ratio = self.box, self.machine.scenario.gear.ratio
        return 2.0 * math.log(box.shortest / ratio) / math.log(box.shortest / box.longest) - 1.0

    def steady(self) -> Array:
        """The plough carried, in the machine's usual gear. Shape (nsim, 4)."""
        action = [start_throttle(self.machine), self.gear_action(), -1.0, -1.0]
        return np.tile([action], (len(self.state), 1))
