"""The episodes of WheelSlip-v0: an electric tractor pulls, and what that is worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.env import judging, observations, reward
from twin.env.episodes import Episodes, asked
from twin.env.grounds import ROLLED, ground_shapes
from twin.env.quantities import Ids
from twin.env.torque_fleet import USUAL_IMPLEMENT, TorqueFleet, motors
from twin.scenario import Course, Drive, Scenario, Soil
from twin.sensors import Imu, Sensors
from twin.simulation.build import build
from twin.vehicle import files

Array = NDArray[np.float64]

USUAL_MACHINE = "electric_tractor"


class Pulling(Episodes):
    """Electric tractors that tow a cultivator: a torque on each rear wheel against its slip."""

    actions_named = ("torque_left", "torque_right")
    recipe = ROLLED
    terms = tuple(reward.PULLING)
    known = (
        "slip", "slip_rl", "slip_rr", "speed_mps", "v_y_rear_mps", "draft_n", "traction_efficiency",
    )  # fmt: skip
    task = tuple(entry.name for entry in observations.TORQUE_TASK)

    def __init__(
        self,
        observation: str,
        estimator: str,
        slip_target: float,
        nsim: int = 1,
        nthread: int = 1,
        machine: str = USUAL_MACHINE,
        implement: str = USUAL_IMPLEMENT,
    ) -> None:
        wanted = asked(observation, estimator, slip_target)
        self.slip_target = float(slip_target)
        seen = observation != "truth"
        super().__init__(
            TorqueFleet(
                motors(build(pulled_along("WheelSlip-v0", machine))),
                nsim,
                nthread,
                sensed=seen,
                implement=files.implement(implement),
            ),
            ground_shapes(0.25, ROLLED),
            observations.TORQUE_MODES[observation],
            wanted,
            seen=seen,
        )

    def judge(self, ids: Ids) -> None:
        """As `twin.env.judging.pulling` does."""
        judging.pulling(ids, self.slip_target, self.actions, self.values)


def pulled_along(name: str, machine: str) -> Scenario:
    """An electric tractor on a straight course."""
    return Scenario(
        name=name,
        machine=machine,
        soil=Soil(preset="dry"),
        drive=Drive(differential_lock=False),
        course=Course(approach_m=0.0),
        sensors=Sensors(imu=Imu(vibration_rms_mps2=0.05), depth=None, machine=None),
    )
