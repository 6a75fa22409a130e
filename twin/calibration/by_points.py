"""A calibration by points of a dynamometer at the PTO, and the drawbar power that it predicts.

    [pto]                     # full load at engine speeds
    engine_rpm = [2200]
    power_kw = [90.1]
    fuel_lph = [28.4]
    [drawbar]                      # never fitted
    power_kw = 75.6

The PTO does not use transmission, wheels and ground, so the points say nothing of these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from estimators.lag import UNKNOWN
from twin.calibration.applied import believed, can_fit, machine_with
from twin.calibration.fitting import Fit, Prior, fit
from twin.calibration.known import known
from twin.calibration.posterior import Posterior
from twin.calibration.result import Calibration
from twin.calibration.verdicts import NORMAL_95, far_notes, misfit_note, together, told
from twin.errors import BadInput
from twin.io.plain import from_plain
from twin.machine.build import assemble
from twin.machine.fuel import fuel_lph
from twin.physics import block
from twin.physics.engine import full_load_torque_nm
from twin.rig.gears import gears
from twin.scenario import Course, Scenario, Soil
from twin.vehicle import Machine
from twin.vehicle.derive import RPM
from twin.vehicle.numerics import machine_facts
from twin.vehicle.reading import table_of

Array = NDArray[np.float64]

NAMES = (
    "engine.rated_power_kw", "engine.pto_efficiency", "engine.fuel_l_per_kwh",
    "transmission.efficiency", "mass_kg",
)  # fmt: skip
"""Parameters that the points may determine, and those that drawbar power depends on beside them."""
SD = 0.01
"""Of a measured power and fuel rate, relative: what OECD Code 2 allows, from memory."""
ROAD = Soil(preset="asphalt")
GEARS_KMH = (8.5, 10.0, 12.0)
"""Gears of which the best is taken, by their speed at rated engine speed."""
SLOPE_STEP = 0.03
"""Difference of a logarithm over which drawbar power's slope is taken: its loads go in steps."""
RULE = "Every point of the PTO is fitted; what was measured at the drawbar never is."


@dataclass(frozen=True, kw_only=True)
class Pto:
    """Full load at the PTO."""

    engine_rpm: tuple[float, ...]
    power_kw: tuple[float, ...]
    fuel_lph: tuple[float, ...]

    def __post_init__(self) -> None:
        lengths = {len(self.engine_rpm), len(self.power_kw), len(self.fuel_lph)}
        if len(lengths) > 1 or lengths == {0}:
            raise BadInput("pto: engine_rpm, power_kw and fuel_lph need a value for each of "
                           "the points, one at least")  # fmt: skip
        for name in ("engine_rpm", "power_kw", "fuel_lph"):
            for value in getattr(self, name):
                if not (math.isfinite(value) and value > 0.0):
                    raise BadInput(f"pto.{name} = {value:g}; above 0 would do")


@dataclass(frozen=True, kw_only=True)
class Drawbar:
    """What was measured at the drawbar on a hard road."""

    power_kw: float


@dataclass(frozen=True, kw_only=True)
class Points:
    """One published test, or a dynamometer's sheet."""

    pto: Pto
    drawbar: Drawbar | None = None


@dataclass(frozen=True)
class Pulled:
    """Greatest drawbar power on a hard road."""

    power_kw: float
    low_kw: float
    high_kw: float
    measured_kw: float | None


@dataclass
class AtPto:
    """The model: power and fuel rate of each point."""

    machine: Machine
    points: Pto

    def __post_init__(self) -> None:
        self.channels = ("pto_kw", "fuel_lph")
        self.measured = np.array([self.points.power_kw, self.points.fuel_lph]).T
        self.time_s = np.arange(len(self.measured), dtype=np.float64)
        self.floor = np.array([0.01, 0.01])
        self.covariance = np.array([np.diag((SD * row) ** 2) for row in self.measured])

    def foretold(self, values: Array) -> Array:
        """Shape (k, n, 2)."""
        return np.array([self._of(machine_with(self.machine, dict(zip(NAMES, row.tolist(),
                         strict=True)))) for row in values])  # fmt: skip

    def _of(self, machine: Machine) -> Array:
        scenario = Scenario(name="pto", machine=machine.name, machine_numbers=machine,
                            course=Course(length_m=100.0))  # fmt: skip
        numbers = machine_facts(machine).numbers
        engine = assemble(scenario).model.numeric_data[-block.SIZE :][block.ENGINE :]
        found = []
        for rpm in self.points.engine_rpm:
            power_w = full_load_torque_nm(engine, rpm) * rpm * RPM
            found.append((1e-3 * numbers["engine.pto_efficiency"] * power_w,
                          float(fuel_lph(numbers, power_w, rpm * RPM))))  # fmt: skip
        return np.array(found)


def read_points(path: Path) -> Points:
    """Points from a TOML file. Raises BadInput."""
    try:
        return from_plain(Points, table_of(path))
    except BadInput as error:
        said = str(error)
        raise BadInput(said if said.startswith(str(path)) else f"{path}: {said}") from None


def by_points(
    points: Points, machine: Machine, name: str, say: Callable[[str], None] = lambda what: None
) -> Calibration:
    """Fit a machine to points of its PTO; predict its drawbar power where it was measured.

    Raises:
        BadInput: the machine's MJCF is made by hand, which has no such parameters.
    """
    if not all(can_fit(machine, n) for n in NAMES):
        raise BadInput(f"points of a PTO cannot be fitted to {machine.name}, whose MJCF is "
                       "made by hand; a machine's file without mjcf would do")  # fmt: skip
    before = [believed(machine, ROAD, n) for n in NAMES]
    low, high = np.log([(known(n).low, known(n).high) for n in NAMES]).T
    prior = Prior(NAMES, np.log([value for value, _, _ in before]),
                  np.array([sd for _, sd, _ in before]), low, high,
                  tuple(grade for _, _, grade in before))  # fmt: skip
    model = AtPto(machine, points.pto)
    result = fit(model, prior, starts=1)
    notes = [*far_notes(result), *filter(None, [misfit_note(result)])]
    if points.drawbar is not None:
        say("driving at the drawbar")
        notes.append(_said(foretold_drawbar(machine, result, points.drawbar.power_kw)))
    return Calibration(
        name=name, machine=machine_with(machine, result.values), soil=None,
        parameters=tuple(told(result)), posterior=Posterior(NAMES, result.u, result.cov),
        together=tuple(together(result)), gears=(), lag=UNKNOWN, fit=result,
        channels=model.channels, time_s=model.time_s, foretold=model.measured - result.residual,
        holdout=None, rule=RULE, notes=tuple(notes),
    )  # fmt: skip


def foretold_drawbar(machine: Machine, result: Fit, measured_kw: float | None = None) -> Pulled:
    """Greatest drawbar power on a hard road, with its 95 % interval by the posterior."""
    found, kmh = _best(machine, result.u, GEARS_KMH)
    slopes = [math.log(_best(machine, u, (kmh,))[0] / found) / SLOPE_STEP
              for u in result.u + SLOPE_STEP * np.eye(len(result.u))]  # fmt: skip
    spread = math.exp(NORMAL_95 * math.sqrt(np.array(slopes) @ result.cov @ np.array(slopes)))
    return Pulled(found, found / spread, found * spread, measured_kw)


def _best(machine: Machine, u: Array, speeds_kmh: Sequence[float]) -> tuple[float, float]:
    """Power [kW] in the best of some gears, and which it is."""
    driven = machine_with(machine, dict(zip(NAMES, np.exp(u).tolist(), strict=True)))
    found = gears(ROAD, speeds_kmh=speeds_kmh, machine=driven)
    best = int(np.argmax(found.drawbar_power_w))
    return 1e-3 * float(found.drawbar_power_w[best]), speeds_kmh[best]


def _said(pulled: Pulled) -> str:
    said = (f"drawbar power on a hard road is predicted as {pulled.power_kw:.1f} kW "
            f"({pulled.low_kw:.1f} to {pulled.high_kw:.1f})")  # fmt: skip
    if pulled.measured_kw is None:
        return said
    off = pulled.power_kw / pulled.measured_kw - 1.0
    return f"{said}; {pulled.measured_kw:.1f} kW were measured, {off:+.1%}"
