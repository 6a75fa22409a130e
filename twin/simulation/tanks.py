"""Mass that is filled in and taken out on the way: fuel, seed, water."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.machine.tanks import GYRATION_M2, body_of
from twin.simulation.simulation import Simulation

GRAVITY_MPS2 = 9.81


class Tanks:
    """The tanks of the first machine of a simulation."""

    def __init__(self, simulation: Simulation) -> None:
        batch, self.simulation = simulation.batch, simulation
        model = simulation.machine.model
        self.mass_kg = batch.expand("body_mass")[0]
        self.inertia_kgm2 = batch.expand("body_inertia")[0]
        self.bodies = {
            name: model.body(body_of(name)).id
            for name in {e.tank or "fuel" for e in simulation.machine.scenario.events if e.mass_kg}
        }
        self.places = {name: np.array(model.body(body).pos) for name, body in self.bodies.items()}

    def fill(self, tank: str, kg: float) -> float:
        """Fill so much in, below 0 out; the energy it brings at its place and speed [J].

        E = m (g h + v**2 / 2) + w . (m k) w / 2
        """
        simulation, body, place = self.simulation, self.bodies[tank], self.places[tank]
        self.mass_kg[body] += kg
        self.inertia_kgm2[body] = self.mass_kg[body] * np.array(GYRATION_M2)
        simulation.batch.set_const()
        qpos, qvel = simulation.qpos[0], simulation.qvel[0]
        axes = [np.array(axis(*qpos[3:7])) for axis in AXES]
        arm = sum((a * p for a, p in zip(axes, place, strict=True)), np.zeros(3))
        turning = sum((a * w for a, w in zip(axes, qvel[3:6], strict=True)), np.zeros(3))
        velocity = qvel[:3] + np.cross(turning, arm)
        rotation = float(np.dot(np.array(GYRATION_M2), qvel[3:6] ** 2))
        height = float(qpos[2] + arm[2])
        return kg * (GRAVITY_MPS2 * height + 0.5 * _square(velocity) + 0.5 * rotation)


AXES = (quaternion.x_axis, quaternion.y_axis, quaternion.z_axis)


def _square(vector: NDArray[np.float64]) -> float:
    return float(np.dot(vector, vector))
