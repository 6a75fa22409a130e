"""The episodes of Plough-v0: what is ploughed, and what it is worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.env import judging, observations, reward
from twin.env.episodes import Episodes, asked
from twin.env.fleet import Fleet
from twin.env.grounds import PLOUGHED, ground_shapes
from twin.env.quantities import Ids
from twin.errors import OutOfRange
from twin.machine.fuel import rated
from twin.scenario import Course, Plough, Scenario
from twin.simulation.build import build
from twin.simulation.records import records

Array = NDArray[np.float64]


class Ploughing(Episodes):
    """Tractors that plough: throttle and hitch against slip and depth."""

    actions_named = ("throttle", "hitch")
    recipe = PLOUGHED
    terms = tuple(reward.PLOUGHING)
    derived = ("work_rate_haph", "fuel_lph")
    known = ("slip", "depth_m", "speed_mps", "draft_n", "traction_efficiency", *derived)
    task = tuple(entry.name for entry in observations.TASK)

    def __init__(
        self,
        observation: str,
        estimator: str,
        depth_m: float,
        slip_target: float,
        nsim: int = 1,
        nthread: int = 1,
        machine: str = Scenario.machine,
        implement: str | None = None,
    ) -> None:
        wanted = asked(observation, estimator, slip_target)
        self.depth_m, self.slip_target = float(depth_m), float(slip_target)
        built = build(ploughed("Plough-v0", self.depth_m, machine, implement))
        numbers = built.numbers
        self.width_m = numbers["plough.bodies"] * numbers["plough.body_width_m"]
        self.engine = records(rated(numbers), 1)
        seen = observation != "truth"
        super().__init__(
            Fleet(built, nsim, nthread, sensed=seen),
            ground_shapes(self.depth_m),
            observations.MODES[observation],
            wanted,
            seen=seen,
        )

    def judge(self, ids: Ids) -> None:
        """As `twin.env.judging.ploughing` does."""
        judging.ploughing(
            ids, self.width_m, self.depth_m, self.slip_target, self.engine, self.actions,
            self.fleet.lift_rad, self.values,
        )  # fmt: skip


def ploughed(name: str, depth_m: float, machine: str, implement: str | None) -> Scenario:
    """What is ploughed. Raises OutOfRange by the argument's name for a depth that does not do."""
    try:
        return Scenario(
            name=name,
            plough=Plough(depth_m=depth_m),
            course=Course(approach_m=1.0),  # the last furrow is there from the start
            machine=machine,
            implement=implement,
        )
    except OutOfRange as error:
        if error.name != "plough.depth_m":
            raise
        raise OutOfRange("depth_m", error.value, error.allowed) from None
