"""The episodes of WheelSlip-v1: an electric tractor pulls along a line across a slope."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twin.env import judging, observations, reward
from twin.env.episodes import Episodes, asked
from twin.env.grounds import SLANTED, ground_shapes
from twin.env.pulling import USUAL_MACHINE, pulled_along
from twin.env.quantities import Ids
from twin.env.torque_fleet import USUAL_IMPLEMENT, motors
from twin.env.traction_fleet import SpeedFleet, TractionFleet
from twin.errors import UnknownName
from twin.simulation.build import build
from twin.vehicle import files

Array = NDArray[np.float64]

ACTUATIONS = {"torque": TractionFleet, "speed": SpeedFleet}


class Traction(Episodes):
    """Electric tractors: speed for little energy, near the line, without much slip."""

    recipe = SLANTED
    terms = tuple(reward.TRACTION)
    derived = ("left_m", "cost_line", "cost_slip")
    known = (
        "slip", "slip_rl", "slip_rr", "speed_mps", "v_y_rear_mps", "draft_n", "axle_w", *derived,
    )  # fmt: skip
    task = tuple(entry.name for entry in observations.TRACTION_TASK)
    fleet: TractionFleet

    def __init__(
        self,
        observation: str,
        estimator: str,
        actuation: str = "torque",
        nsim: int = 1,
        nthread: int = 1,
        machine: str = USUAL_MACHINE,
        implement: str = USUAL_IMPLEMENT,
    ) -> None:
        wanted = asked(observation, estimator)
        if actuation not in ACTUATIONS:
            raise UnknownName("actuation", actuation, ACTUATIONS)
        self.actions_named = (f"{actuation}_left", f"{actuation}_right")
        seen = observation != "truth"
        super().__init__(
            ACTUATIONS[actuation](
                motors(build(pulled_along("WheelSlip-v1", machine))),
                nsim,
                nthread,
                sensed=seen,
                implement=files.implement(implement),
            ),
            ground_shapes(0.25, SLANTED),
            observations.TRACTION_MODES[observation],
            wanted,
            seen=seen,
        )
        self.task_rows = np.array([self.place[name] for name in self.task])

    def judge(self, ids: Ids) -> None:
        """As `twin.env.judging.traction` does, and where guidance has the tractor."""
        fleet = self.fleet
        fleet.observe()
        judging.traction(ids, fleet.seen, self.values)
        left, heading = fleet.seen["left_m"][ids], fleet.seen["heading_rad"][ids]
        if self.instruments:
            found = np.array([self._guided(i) for i in ids.tolist()])
            left, heading = found.T
        now = (*fleet.torques[ids].T, left, heading)
        for row, value in zip(self.task_rows, now, strict=True):
            self.values[row, ids] = value

    def _guided(self, i: int) -> tuple[float, float]:
        """Distance to the left of the line [m], and the heading [rad], by the last GNSS sample.

            y = j . p - l_x sin(heading) - l_y cos(heading)

        with the ground's axis j to the left, the main antenna at p, its lever arm l.
        """
        latest, setup = self.instruments[i].latest, self.instruments[i].setup.gnss
        assert setup is not None
        askew = latest["gnss.heading_rad"] - setup.heading_mount_rad
        heading = math.remainder(askew, 2.0 * math.pi)
        place = np.array([latest[f"gnss.{axis}_m"] for axis in ("east", "north", "up")])
        across = float(self.fleet.world_from_ground[i][:, 1] @ place)
        ahead, aside = setup.lever_arm_m[:2]
        return across - ahead * math.sin(heading) - aside * math.cos(heading), heading
