"""Electric tractors that hold a line across slopes, with motors that lag behind the actions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.env.fleet import Start
from twin.env.grounds import Ground
from twin.env.torque_fleet import TorqueFleet
from twin.env.towing import pull
from twin.env.traction_drive import drive_motors, local_draft
from twin.machine.build import Machine
from twin.simulation.driver import STEER_GAIN_RAD_PER_MS
from twin.vehicle import Implement

Array = NDArray[np.float64]


class TractionFleet(TorqueFleet):
    """The electric machines of WheelSlip-v1."""

    speed_loop = False
    """Whether the actions are wheel speeds."""

    def __init__(
        self,
        machine: Machine,
        nsim: int = 1,
        nthread: int = 1,
        *,
        sensed: bool = True,
        implement: Implement | None = None,
    ) -> None:
        """As a torque fleet's; the driver learns the steering angle that a slope needs."""
        super().__init__(machine, nsim, nthread, sensed=sensed, implement=implement)
        self.tasks["steer_gain_rad_per_ms"] = STEER_GAIN_RAD_PER_MS
        self.held, self.here = np.zeros((nsim, 2)), np.zeros(nsim)

    def restore(
        self, ids: Sequence[int], starts: Sequence[Start], grounds: Sequence[Ground]
    ) -> None:
        """As a torque fleet's; a speed loop begins with the torque that the start was held with."""
        super().restore(ids, starts, grounds)
        self.held[ids] = self.torques[ids]
        self.observe()

    def act(self, actions: Array) -> None:
        """Torques of the rear wheels behind their lag; the cultivator pulls as it does here."""
        self.observe()
        local_draft(self.blocks, self.seen, self.draft_scale, self.here)
        drive_motors(
            actions, self.qvel[:, self.spins], self.speed_loop, self.held, self.torques,
            self.period_s,
        )  # fmt: skip
        pull(
            self.torques, self.stall_nm, self.implement, self.qpos, self.velocity, self.here,
            self.arm_m, self.motors, self.draft, self.pulled, self.ctrl,
        )  # fmt: skip
        self.control()


class SpeedFleet(TractionFleet):
    """The same with a speed loop around each motor."""

    speed_loop = True
