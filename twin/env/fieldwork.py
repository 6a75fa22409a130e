"""The episodes of Plough-v1: a changing field is worked, and what that is worth and costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.env import judging, observations, reward
from twin.env.episodes import Episodes, asked
from twin.env.field_fleet import FieldFleet
from twin.env.grounds import WORKED, ground_shapes
from twin.env.ploughing import ploughed
from twin.env.quantities import Ids
from twin.errors import UnknownName
from twin.machine.fuel import rated
from twin.physics import block
from twin.physics.block import Engine
from twin.scenario import Field, Scenario
from twin.scenario.soils import LAWS
from twin.simulation.build import build
from twin.simulation.records import records

Array = NDArray[np.float64]

OTHER_SHARE, OTHER_LENGTH_M = 0.5, 12.0
"""Share of the field that is of the other soil, and the size of its areas [m]."""
COSTS = ("cost_depth", "cost_slip", "cost_lugging")


class FieldWork(Episodes):
    """Tractors that plough: throttle, gear and hitch for area and fuel, within limits."""

    actions_named = ("throttle", "gear", "hitch", "mix")
    terms = tuple(reward.WORKING)
    derived = ("work_rate_haph", "fuel_lph", *COSTS)
    known = ("slip", "depth_m", "speed_mps", "draft_n", "engine_radps", *derived)
    task = tuple(entry.name for entry in observations.FIELD_TASK)
    fleet: FieldFleet

    def __init__(
        self,
        observation: str,
        estimator: str,
        depth_m: float,
        law: str,
        nsim: int = 1,
        nthread: int = 1,
        machine: str = Scenario.machine,
        implement: str | None = None,
    ) -> None:
        wanted = asked(observation, estimator)
        if law not in LAWS:
            raise UnknownName("law", law, LAWS)
        self.recipe, self.depth_m = replace(WORKED, law=law), float(depth_m)
        field = Field(other_share=OTHER_SHARE, other_length_m=OTHER_LENGTH_M)
        scenario = replace(ploughed("Plough-v1", self.depth_m, machine, implement), field=field)
        built = build(scenario)
        numbers = built.numbers
        self.width_m = numbers["plough.bodies"] * numbers["plough.body_width_m"]
        self.engine = records(rated(numbers), 1)
        seen = observation != "truth"
        fleet = FieldFleet(built, nsim, nthread, sensed=seen)
        first = block.ENGINE
        self.numbers = fleet.blocks[0, first : first + Engine.SIZE].copy()
        super().__init__(
            fleet,
            ground_shapes(self.depth_m, WORKED),
            observations.FIELD_MODES[observation],
            wanted,
            seen=seen,
        )
        self.task_rows = np.array([self.place[name] for name in self.task])

    def judge(self, ids: Ids) -> None:
        """As `twin.env.judging.working` does, and what the levers are at."""
        judging.working(ids, self.width_m, self.depth_m, self.engine, self.numbers, self.values)
        fleet, task = self.fleet, self.values
        set_rpm = fleet.levers["idle_rpm"] + fleet.tasks["throttle"][ids] * (
            fleet.levers["no_load_rpm"] - fleet.levers["idle_rpm"]
        )
        slowest, fastest = fleet.levers["slowest_rpm"], fleet.levers["fastest_rpm"]
        now = (
            2.0 * (set_rpm - slowest) / (fastest - slowest) - 1.0,
            3.6 * self.rated_radps * fleet.drivetrain["mps_per_radps"][ids],
            fleet.lift_rad[ids],
            fleet.tasks["mix"][ids],
            np.full(len(ids), self.depth_m),
        )
        for row, value in zip(self.task_rows, now, strict=True):
            task[row, ids] = value

    @property
    def rated_radps(self) -> float:
        """Rated speed of the engine."""
        return float(self.numbers[Engine.RATED_RPM] * np.pi / 30.0)
