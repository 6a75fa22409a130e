"""The episodes of Plough-v0: what is ploughed, and what it is worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.compute.compiled import law
from twin.env import observations, reward
from twin.env.episodes import Episodes, asked
from twin.env.fleet import Fleet
from twin.env.grounds import PLOUGHED, ground_shapes
from twin.env.quantities import PLACE, TRUE, Ids
from twin.machine.fuel import engine_fuel_lph, rated
from twin.scenario import Course, Plough, Scenario
from twin.simulation.build import build
from twin.simulation.records import Records, records

Array = NDArray[np.float64]

FIRST = len(TRUE)
SLIP, SPEED, DEPTH, RADPS, ENGINE_NM, EFFICIENCY = (
    PLACE[name]
    for name in (
        "slip", "speed_mps", "depth_m", "engine_radps", "engine_torque_nm", "traction_efficiency",
    )
)  # fmt: skip


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
        """As `_judge` does."""
        _judge(
            ids, self.width_m, self.depth_m, self.slip_target, self.engine, self.actions,
            self.fleet.lift_rad, self.values,
        )  # fmt: skip


@law
def _judge(
    ids: Ids,
    width_m: float,
    depth_m: float,
    slip_target: float,
    engine: Records,
    actions: Array,
    lift_rad: Array,
    out: Array,
) -> None:
    """Work rate and fuel; the terms of the reward and their sum; the task. Rows as in PLACE."""
    for i in ids:
        radps, depth = out[RADPS, i], out[DEPTH, i]
        rate = reward.work_rate_m2ps(out[SPEED, i], depth, width_m, depth_m)
        terms = reward.ploughing(
            rate, out[EFFICIENCY, i], out[SLIP, i], depth, slip_target, depth_m
        )
        total = 0.0
        for k in range(len(terms)):
            out[FIRST + 2 + k, i] = terms[k]
            total += terms[k]
        out[FIRST, i] = rate * 0.36
        out[FIRST + 1, i] = engine_fuel_lph(engine[0], out[ENGINE_NM, i] * radps, radps)
        out[FIRST + 6, i] = total
        out[FIRST + 7, i], out[FIRST + 8, i] = actions[i, 0], lift_rad[i]
        out[FIRST + 9, i], out[FIRST + 10, i] = slip_target, depth_m
