"""One pass whose throttle and hitch a controller sets by what its sensors say, and what it did."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.control.controllers import Controller
from twin.control.on_machine import controlled_by
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.reproduce.passes import SETTLING_M, width_m
from twin.scenario import Scenario
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.streams import Table
from twin.truth import truth

Array = NDArray[np.float64]

PERIOD_S = truth.PERIOD_NS * 1e-9
SECOND = round(1.0 / PERIOD_S)
"""Samples of the truth in a second."""


@dataclass(frozen=True, kw_only=True)
class Worked:
    """The true course of a pass, from 5 m after the plough was in, at 50 Hz. Shapes (n,)."""

    slip: Array
    depth_m: Array
    speed_mps: Array
    fuel_lph: Array
    width_m: float
    """Working width."""

    @property
    def seconds_slip(self) -> Array:
        """Mean slip of each second."""
        whole = len(self.slip) // SECOND * SECOND
        return np.asarray(self.slip[:whole].reshape(-1, SECOND).mean(axis=1))

    @property
    def capacity_haph(self) -> float:
        """Area worked per time, of the working width [ha/h]."""
        return 0.36 * self.width_m * float(self.speed_mps.mean())

    @property
    def fuel_lpha(self) -> float:
        """Fuel over the area worked [L/ha]."""
        return float(self.fuel_lph.mean()) / self.capacity_haph

    def first(self, duration_s: float) -> Worked:
        """Its first part. Raises BadInput if it did not last so long."""
        count = round(duration_s / PERIOD_S)
        if len(self.slip) < count:
            raise BadInput(
                f"the pass lasted {len(self.slip) * PERIOD_S:.0f} s, not {duration_s:g} s; a "
                "longer course would do"
            )
        return Worked(
            slip=self.slip[:count],
            depth_m=self.depth_m[:count],
            speed_mps=self.speed_mps[:count],
            fuel_lph=self.fuel_lph[:count],
            width_m=self.width_m,
        )


def worked(
    scenario: Scenario, controller: Callable[[Machine], Controller], slip_target: float = 0.12
) -> Worked:
    """Drive a scenario with a controller of Plough-v0 at the levers, told a slip to work at.

    Raises:
        BadInput: nothing was worked.
    """
    machine = build(scenario)
    set_levers = controlled_by(controller(machine), slip_target=slip_target).start(machine)
    parts = [
        truth.sample(chunk, ("rl", "rr")) for chunk in simulate(machine, set_levers=set_levers)
    ]
    table = truth.concatenate(parts)
    return _measured(machine, table)


def _measured(machine: Machine, table: Table) -> Worked:
    plough = machine.scenario.plough
    travelled = np.cumsum(table["speed_mps"]) * PERIOD_S
    entered = table["depth_m"] >= (0.0 if plough is None else 0.5 * plough.depth_m)
    if not entered.any() or travelled[np.argmax(entered)] + SETTLING_M >= travelled[-1]:
        raise BadInput(f"{machine.scenario.name}, seed {machine.scenario.seed}: it hardly worked")
    scored = travelled >= travelled[np.argmax(entered)] + SETTLING_M
    return Worked(
        slip=table["slip"][scored],
        depth_m=table["depth_m"][scored],
        speed_mps=table["speed_mps"][scored],
        fuel_lph=table["fuel_lph"][scored],
        width_m=width_m(machine),
    )
