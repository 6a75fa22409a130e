"""Forward model of long logs at a slow rate: slip of steady driving from engine torque and speed.

The power that the engine gives the wheels drives them at their rims with a force

    F = (x T_ref - T_p) eta w_e / (k v_w)

with the torque x over its reference T_ref, the parasitic torque T_p, the transmission's efficiency
eta, the engine's speed w_e and the wheels' true speed k v_w. The soil's own law says at which slip
the driven wheels hand on so much, under their loads:

    sum_i (G_i(s) + M_i) = F        ground speed = k v_w (1 - s)

Loads are those of the machine standing level, with what the implement puts on it and what the pull
moves from the front axle to the rear. It is the steady state of the laws that the machine itself
runs on, without running it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.calibration.applied import machine_with, soil_with
from twin.calibration.steady_rows import SteadyRows
from twin.machine.build import assemble
from twin.machine.fuel import fuel_lph
from twin.machine.parameters import soil_part
from twin.physics import block
from twin.physics.block import Soil as SoilSlot
from twin.physics.block import Wheel
from twin.physics.steady_slip import slips
from twin.scenario import Course, Scenario, Soil
from twin.vehicle import Machine
from twin.vehicle.derive import GRAVITY_MPS2
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

PULL_HEIGHT_M = 0.45
"""Height of the pull above the ground; assumed."""
BEHIND = 1.3
"""Rear axle's share of what a mounted implement weighs; the front axle is relieved of the rest."""
CHANNELS = ("speed_ratio", "fuel_lph")


@dataclass
class Steady:
    """The model: ground over wheel speed and fuel rate of steady rows."""

    machine: Machine
    soil: Soil
    names: tuple[str, ...]
    rows: SteadyRows
    all_wheel_drive: bool
    of_axle: bool = False
    """Whether the rows' torque is the rear axle's, over the reference torque."""

    def __post_init__(self) -> None:
        scenario = Scenario(
            name="calibrate",
            machine=self.machine.name,
            machine_numbers=self.machine,
            soil=self.soil,
            course=Course(length_m=100.0),
        )
        whole = assemble(scenario)
        data = whole.model.numeric_data[-block.SIZE :]
        self._soil = data[block.SOIL : block.WHEEL].copy()
        self._wheels = data[block.WHEEL : block.ENGINE].reshape(4, int(Wheel.SIZE)).copy()
        fuel = np.isfinite(self.rows.fuel_lph).mean() > 0.9
        self.channels = CHANNELS if fuel else CHANNELS[:1]
        measured = {"speed_ratio": self.rows.ratio, "fuel_lph": self.rows.fuel_lph}
        self.measured = np.stack([measured[c] for c in self.channels], axis=1)
        self.time_s, self.covariance = self.rows.time_s, None
        self.floor = np.array([0.001, 0.02])[: len(self.channels)]

    def foretold(self, values: Array) -> Array:
        """The channels of all rows for parameters (k, p): shape (k, n, c)."""
        return np.array([self._of(dict(zip(self.names, row.tolist(), strict=True)))
                         for row in values])  # fmt: skip

    def slip(self, values: dict[str, float]) -> Array:
        """Slip of the rear wheels in all rows. Shape (n,)."""
        machine, rows = machine_with(self.machine, values), self.rows
        numbers = machine_facts(machine).numbers
        soil = self._soil.copy()
        for slot, value in soil_part(soil_with(self.soil, values)).items():
            if slot != SoilSlot.LAW:
                soil[slot] = value
        true = values.get("log.wheel_scale", 1.0)
        power = values["log.reference_torque_nm"] * rows.force
        if not self.of_axle:
            lost = numbers["engine.parasitic_nm"] * rows.engine_radps / rows.wheel_mps
            power = (power - lost) * numbers["engine.transmission_efficiency"]
        carried_n = GRAVITY_MPS2 * values.get("log.carried_kg", 0.0)
        front_n = numbers["tyre_front.nominal_load_n"] - 0.5 * (BEHIND - 1.0) * carried_n
        rear_n = numbers["tyre_rear.nominal_load_n"] + 0.5 * BEHIND * carried_n
        radii = (numbers[f"tyre_{a}.free_rolling_radius_m"] for a in ("front", "rear"))
        front_m, rear_m = radii
        lead = numbers["front_drive.ratio"] * front_m / rear_m - 1.0
        height = PULL_HEIGHT_M / _wheelbase_m(machine)
        lead = lead if self.all_wheel_drive else math.nan
        load_n = np.array([front_n, rear_n])
        return slips(soil, self._wheels, load_n, lead, height, power / true)

    def _of(self, values: dict[str, float]) -> Array:
        true = values.get("log.wheel_scale", 1.0)
        found = {"speed_ratio": true * (1.0 - self.slip(values))}
        if "fuel_lph" in self.channels:
            numbers = machine_facts(machine_with(self.machine, values)).numbers
            power_w = values["log.reference_torque_nm"] * self.rows.torque * self.rows.engine_radps
            found["fuel_lph"] = fuel_lph(numbers, power_w, self.rows.engine_radps)
        return np.stack([found[c] for c in self.channels], axis=1)


def _wheelbase_m(machine: Machine) -> float:
    return machine.wheelbase_m or 2.6
