"""A controller at the levers of a scenario's run, where the driver steers and turns."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.control import chosen, own
from twin.control.controllers import Controller
from twin.control.own import AnyController, ControllerSetup
from twin.env.fleet import levers, start_throttle
from twin.env.instruments import Instruments
from twin.env.levers import depth_set_m, governor, lift_sine
from twin.env.observations import MODES, space
from twin.env.ploughing import Ploughing
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.pipeline import named as registry
from twin.sensors import Sensors
from twin.simulation.columns import Record
from twin.simulation.levers import Controlled, Levers
from twin.simulation.simulation import DECISION_S, Simulation

TASK = "Plough-v0"
"""The environment whose observation and actions a controller has in a run."""
ENTRIES = MODES["estimate"]
NEEDED = ("gnss", "imu", "wheels", "depth", "machine")
"""Sensors behind that observation."""


def controlled_by(
    controller: AnyController | str, estimator: str = "slip-ekf", slip_target: float = 0.12
) -> Controlled:
    """A controller that sets throttle and hitch of a run while the plough works.

    It sees the observation "estimate" of Plough-v0, from the sensors of the run with their noise,
    and gives its actions every 20 ms. The driver steers, drives the approach and the headlands.

    ```
    twin.run("plough-25cm", controlled=controlled_by("pi"))
    ```

    Args:
        controller: what drives, or its name as `twin compare-controllers` takes it.
        estimator: whose estimate it sees: a name, or `module:Name`.
        slip_target: slip to work at [-]. The depth to work at is the scenario's.

    Raises:
        UnknownName, BadInput: there is no such controller or estimator.
    """
    seen_by = registry.load("estimator", estimator)
    name = controller if isinstance(controller, str) else type(controller).__name__

    def start(machine: Machine) -> AtTheLevers:
        instruments = Instruments(machine, seen_by)
        instruments.config = _fitted(machine, name)
        told = ControllerSetup(
            environment=TASK,
            period_s=DECISION_S,
            observed=ENTRIES,
            actions=Ploughing.actions_named,
            streams=instruments.setup,
        )
        found = chosen.controller(controller, told) if isinstance(controller, str) else controller
        return AtTheLevers(own.of_many(found, told, name), told, name, instruments, slip_target)

    return Controlled(name, start)


def _fitted(machine: Machine, name: str) -> Sensors:
    """The sensors behind the observation. Raises BadInput where there is nothing to control."""
    scenario = machine.scenario
    if machine.hitch is None or scenario.plough is None:
        raise BadInput(f"controller '{name}': scenario '{scenario.name}' has no implement to set")
    fitted = scenario.sensors.fitted()
    lacking = [sensor for sensor in NEEDED if sensor not in fitted]
    if lacking:
        raise BadInput(
            f"controller '{name}' needs the sensors {', '.join(NEEDED)}, and scenario "
            f"'{scenario.name}' has no {' and no '.join(lacking)}"
        )
    return replace(scenario.sensors, camera=None, extra=())


class AtTheLevers:
    """Shows a controller what the run's sensors say, and sets what it asks for."""

    def __init__(
        self,
        controller: Controller,
        told: ControllerSetup,
        name: str,
        instruments: Instruments,
        slip_target: float,
    ) -> None:
        machine = instruments.machine
        self.controller, self.told, self.name = controller, told, name
        self.instruments, self.levers = instruments, levers(machine)
        self.throttle = start_throttle(machine)
        self.slip_target, self.depth_m = slip_target, machine.scenario.plough.depth_m  # type: ignore[union-attr]
        self.box, self.names = space(ENTRIES), [entry.name for entry in ENTRIES]
        instruments.switch_on(machine.scenario.seed)
        self.state = own.started(controller, 1, name)

    def __call__(self, simulation: Simulation, last: Record | None, working: bool) -> Levers | None:
        """Look at what the sensors gave since the last decision, and decide in work."""
        if last is not None:
            self.instruments.advance(last)
        if not working:
            return None
        self.state, ((throttle, hitch),) = own.acted(
            self.controller, self.state, self.names, self._seen(simulation), self.told, self.name
        )
        self.throttle, hitch = (min(1.0, max(-1.0, float(v))) for v in (throttle, hitch))
        sine = lift_sine(depth_set_m(hitch, self.levers.deepest_m), self.levers)
        return Levers(governor(self.throttle, self.levers), math.asin(sine))

    def _seen(self, simulation: Simulation) -> NDArray[np.float32]:
        """The observation now, (1, entries)."""
        known = self.instruments.values() | {
            "throttle": self.throttle,
            "lift_set_rad": float(simulation.drivers["lift_rad"][0]),
            "slip_target": self.slip_target,
            "depth_target_m": self.depth_m,
        }
        row = np.array([[known[name] for name in self.names]], dtype=np.float32)
        return np.clip(row, self.box.low, self.box.high)
