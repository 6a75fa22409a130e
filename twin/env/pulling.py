"""The episodes of WheelSlip-v0: an electric tractor pulls, and what that is worth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.env import observations, reward
from twin.env.episodes import Episodes, Some, asked
from twin.env.grounds import ROLLED, ground_shapes
from twin.env.torque_fleet import USUAL_IMPLEMENT, TorqueFleet, motors
from twin.scenario import Course, Drive, Scenario, Soil
from twin.sensors import Imu, Sensors
from twin.simulation.build import build
from twin.vehicle import files

Array = NDArray[np.float64]

USUAL_MACHINE = "electric_tractor"
KNOWN = (
    "slip", "slip_rl", "slip_rr", "speed_mps", "v_y_rear_mps", "draft_n", "traction_efficiency",
)  # fmt: skip


class Pulling(Episodes):
    """Electric tractors that tow a cultivator: a torque on each rear wheel against its slip."""

    actions_named = ("torque_left", "torque_right")
    recipe = ROLLED

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
        scenario = Scenario(
            name="WheelSlip-v0",
            machine=machine,
            soil=Soil(preset="dry"),
            drive=Drive(differential_lock=False),
            course=Course(approach_m=0.0),
            sensors=Sensors(imu=Imu(vibration_rms_mps2=0.05), depth=None, machine=None),
        )
        super().__init__(
            TorqueFleet(motors(build(scenario)), nsim, nthread, files.implement(implement)),
            ground_shapes(0.25, ROLLED),
            observations.TORQUE_MODES[observation],
            wanted,
            seen=observation != "truth",
        )

    def terms(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """Slip of each rear wheel, and sideslip; see `twin.env.reward.pulling_terms`."""
        return reward.pulling_terms(true, self.slip_target)

    def task(self, ids: Some) -> dict[str, ArrayLike]:
        """Torques in force, and the target."""
        left, right = self.actions[ids].T
        return {"torque_left": left, "torque_right": right, "slip_target": self.slip_target}

    def info(self, true: Mapping[str, Array]) -> dict[str, Array]:
        """What is true now and worth knowing of each tractor, each of shape (nsim,)."""
        return {name: true[name] for name in KNOWN}
