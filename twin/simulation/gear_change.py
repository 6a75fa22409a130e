"""Another ratio between engine and rear axle, in a simulation that runs."""

from __future__ import annotations

import numpy as np

from twin.physics import block
from twin.physics.block import Engine
from twin.simulation.simulation import Simulation


class Driveline:
    """The first machine's shaft, on which the engine turns at the speed of the rear axle.

    With the ratio i the shaft has the inertia I i**2 of the engine and turns at w / i. A change of
    the ratio leaves the engine's speed w as it is, and so its energy; the clutch makes up for what
    shaft and wheels then differ.
    """

    def __init__(self, simulation: Simulation) -> None:
        batch, self.simulation = simulation.batch, simulation
        numbers = simulation.machine.numbers
        self.block = batch.expand("numeric_data")[0, -block.SIZE :]
        self.armature = batch.expand("dof_armature")[0]
        self.inertia_kgm2 = numbers["engine.inertia_kgm2"]
        self.clutch_nm = numbers["clutch.capacity_nm"]
        self.radius_m = numbers["tyre_rear.free_rolling_radius_m"]

    @property
    def ratio(self) -> float:
        """Engine turns per turn of the rear axle; below 0 in reverse."""
        return float(self.block[block.GEAR_RATIO])

    def change(self, ratio: float) -> None:
        """Put another ratio in."""
        simulation, before = self.simulation, self.ratio
        if ratio == before:
            return
        shaft = simulation.engine
        simulation.qvel[0, shaft] *= before / ratio
        self.armature[shaft] = self.inertia_kgm2 * ratio**2
        self.block[block.GEAR_RATIO] = ratio
        self.block[block.CLUTCH_NM] = self.clutch_nm * abs(ratio)
        known = simulation.drivetrain[0]
        known["gear_ratio"], known["mps_per_radps"] = ratio, self.radius_m / abs(ratio)

    def turn_key(self, key: int) -> None:
        """Let the engine run, shut its fuel off, or start it."""
        self.block[block.ENGINE + Engine.KEY] = key

    @property
    def engine(self) -> np.ndarray:
        """The engine's part of the parameter block."""
        return self.block[block.ENGINE : block.COUPLING]
