"""The episodes of Plough-v0: what is ploughed, and what it is worth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.env import observations, reward
from twin.env.episodes import Episodes, Some, asked
from twin.env.fleet import Fleet
from twin.env.grounds import PLOUGHED, ground_shapes
from twin.machine.fuel import fuel_lph
from twin.scenario import Course, Plough, Scenario
from twin.simulation.build import build

Array = NDArray[np.float64]

KNOWN = ("slip", "depth_m", "speed_mps", "draft_n", "traction_efficiency")


class Ploughing(Episodes):
    """Tractors that plough: throttle and hitch against slip and depth."""

    actions_named = ("throttle", "hitch")
    recipe = PLOUGHED

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
        scenario = Scenario(
            name="Plough-v0",
            plough=Plough(depth_m=self.depth_m),
            course=Course(approach_m=1.0),  # the last furrow is there from the start
            machine=machine,
            implement=implement,
        )
        built = build(scenario)
        numbers = built.numbers
        self.width_m = numbers["plough.bodies"] * numbers["plough.body_width_m"]
        super().__init__(
            Fleet(built, nsim, nthread),
            ground_shapes(self.depth_m),
            observations.MODES[observation],
            wanted,
            seen=observation != "truth",
        )

    def terms(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """Work, efficiency, slip and depth; see `twin.env.reward.terms`."""
        return reward.terms(true, self.width_m, self.depth_m, self.slip_target)

    def task(self, ids: Some) -> dict[str, ArrayLike]:
        """Throttle and hitch in force, and the targets."""
        return {
            "throttle": self.actions[ids, 0],
            "lift_set_rad": self.fleet.drivers["lift_rad"][ids],
            "slip_target": self.slip_target,
            "depth_target_m": self.depth_m,
        }

    def info(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """What is true now and worth knowing of each tractor, each of shape (nsim,)."""
        rate_m2ps = reward.work_rate_m2ps(true, self.width_m, self.depth_m)
        radps = true["engine_radps"]
        return {
            **{name: true[name] for name in KNOWN},
            "work_rate_haph": rate_m2ps * 0.36,
            "fuel_lph": fuel_lph(
                self.fleet.machine.numbers, true["engine_torque_nm"] * radps, radps
            ),
        }
