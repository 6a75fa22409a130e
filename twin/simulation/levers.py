"""Who sets throttle and hitch in work in the driver's place: a controller on trial."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from twin.machine.build import Machine
from twin.simulation.columns import Record
from twin.simulation.simulation import Simulation


class Levers(NamedTuple):
    """What the controller sets."""

    throttle: float
    """Control of the governor, 0 to 1."""
    lift_rad: float
    """Angle of the lower links that the hitch is set to."""


SetLevers: TypeAlias = Callable[[Simulation, Record | None, bool], Levers | None]
"""Asked before every decision, with the machine, what was recorded since the last (None at first),
and whether it works: past the approach, and not on a headland. None leaves it to the driver."""


@dataclass(frozen=True)
class Controlled:
    """A controller by its name, and how it starts on a machine."""

    name: str
    start: Callable[[Machine], SetLevers]
