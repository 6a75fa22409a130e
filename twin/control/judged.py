"""What is measured of a controller on each ground, by environment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.env.episodes import Episodes
from twin.env.fieldwork import COSTS

Array = NDArray[np.float64]
Known = Mapping[str, Array]
Value = Callable[[Any, Known], Array]
"""Function of an environment's episodes and infos, arrays (grounds,), that gives (grounds,)."""
LEAST = 1e-3
"""Least divisor of a mean."""


@dataclass(frozen=True)
class Measure:
    """A mean over the control steps after the entry."""

    unit: str
    value: Value
    per: Value | None = None
    """Divisor: the measure is mean(value) / mean(per). None: the measure is mean(value)."""
    root: bool = False
    """Whether the square root of the mean is reported, as for an RMS."""
    stalled: float = 0.0
    """Value in each control step of a tractor that has stalled."""

    def sums(self, episodes: Episodes, known: Known, alive: NDArray[np.bool_]) -> Array:
        """One control step's value and, if `per` is set, divisor: (1, grounds) or (2, grounds)."""
        rows = [np.where(alive, self.value(episodes, known), self.stalled)]
        if self.per is not None:
            rows.append(np.where(alive, self.per(episodes, known), 0.0))
        return np.stack(rows)

    def of(self, sums: Array, steps: int) -> Array:
        """The measure from the sums over `steps` control steps, (grounds,)."""
        if self.per is not None:
            return np.asarray(sums[0] / np.maximum(sums[1], LEAST * steps))
        return np.asarray(np.sqrt(sums[0] / steps) if self.root else sums[0] / steps)


def info_value(name: str) -> Value:
    """Function that gives the info `name` of all grounds, (grounds,), in the unit of that info."""
    return lambda episodes, known: known[name]


def squared(name: str, target: str | None = None) -> Value:
    """Function that gives the squared info `name`, or its squared error.

    The error is info `name` less the attribute `target` of the episodes.
    """

    def value(episodes: Episodes, known: Known) -> Array:
        error = known[name] - (0.0 if target is None else getattr(episodes, target))
        return np.asarray(error**2)

    return value


def both_slips(episodes: Any, known: Known) -> Array:
    """Squared error of slip from `slip_target`, mean of both rear wheels, (grounds,)."""
    left, right = (known[f"slip_{wheel}"] - episodes.slip_target for wheel in ("rl", "rr"))
    return np.asarray(0.5 * (left * left + right * right))


EFFICIENCY = Measure("1", info_value("traction_efficiency"))
WORK_RATE = Measure("ha/h", info_value("work_rate_haph"))
FUEL = Measure("L/ha", info_value("fuel_lph"), info_value("work_rate_haph"))
SPEED = Measure("m/s", info_value("speed_mps"))
SIDESLIP = Measure("m/s", squared("v_y_rear_mps"), root=True)


def _costs(*names: str) -> dict[str, Measure]:
    return {name: Measure("1", info_value(name), stalled=1.0) for name in names}


MEASURES: dict[str, dict[str, Measure]] = {
    "Plough-v0": {
        "traction_efficiency": EFFICIENCY,
        "work_rate": WORK_RATE,
        "fuel": FUEL,
        "slip_rms_error": Measure("1", squared("slip", "slip_target"), root=True, stalled=1.0),
        "depth_rms_error": Measure("m", squared("depth_m", "depth_m"), root=True),
    },
    "WheelSlip-v0": {
        "traction_efficiency": EFFICIENCY,
        "speed": SPEED,
        "slip_rms_error": Measure("1", both_slips, root=True, stalled=1.0),
        "sideslip_rms": SIDESLIP,
    },
    "Plough-v1": {"work_rate": WORK_RATE, "fuel": FUEL, **_costs(*COSTS)},
    "WheelSlip-v1": {
        "speed": SPEED,
        "energy": Measure("J/m", info_value("axle_w"), info_value("speed_mps")),
        **_costs("cost_line", "cost_slip"),
        "sideslip_rms": SIDESLIP,
    },
}
"""By environment; a trial knows the mean reward and the stalls beside them."""


def quantities(environment: str) -> dict[str, str]:
    """What is measured on each ground of an environment, with its unit."""
    units = {name: measure.unit for name, measure in MEASURES[environment].items()}
    return {"reward": "1", **units, "stalled": "1"}


UNITS = {name: unit for each in MEASURES for name, unit in quantities(each).items()}
