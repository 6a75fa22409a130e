"""One pass over a field, simulated without sensors, and its statistics."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.errors import BadInput
from twin.machine.build import Machine
from twin.scenario import Scenario
from twin.sensors import Sensors
from twin.simulation.build import build
from twin.simulation.driver import full_depth_m
from twin.simulation.simulate import simulate
from twin.streams import Table
from twin.truth import truth

Array = NDArray[np.float64]

NO_SENSORS = Sensors(gnss=None, imu=None, wheels=None, depth=None, machine=None)
SETTLING_M = 5.0
"""Distance after full depth before a pass counts."""
LOSSES = (
    "parasitic", "transmission", "driveline", "brake", "slip_long", "slip_lat", "rolling",
    "tyre", "wall", "drawbar", "depth_wheel", "joint", "lift", "steer", "contact", "step",
    "mass",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Pass:
    """Statistics over the scored part of a pass, from 5 m after full depth to the end.

    `slip_sd` is the standard deviation of the true slip, `draft_cv` that of the draft over its
    mean, other fields are means. `power_closure` covers the whole pass.
    """

    speed_kmh: float
    slip: float
    slip_sd: float
    draft_n: float
    draft_cv: float
    draft_length_m: float
    """Distance at which the draft's autocorrelation has fallen to 1/e [m]."""
    draft_over_d497: float
    """Mean draft over the mean of ASABE D497's draft at the run's own speed and depth [-]."""
    depth_m: float
    fuel_lpha: float
    """Fuel over the area worked, the plough's width times the length [L/ha]."""
    roll_deg: float
    """Magnitude of the mean roll."""
    roll_expected_deg: float
    """atan((depth + difference of the rear tyres' deflections) / track)."""
    power_closure: float
    """(Engine work - all losses - change of stored energy) / engine work [-]."""
    length_m: float


def drive(scenario: Scenario) -> Pass:
    """Drive a ploughing scenario without sensors, and measure it. Raises BadInput, Diverged."""
    machine = build(replace(scenario, sensors=NO_SENSORS))
    parts = [truth.sample(chunk, ("rl", "rr")) for chunk in simulate(machine)]
    plough = machine.scenario.plough
    full_m = 0.0 if plough is None else full_depth_m(plough.depth_m, plough.hitch)
    table = truth.integrate(truth.concatenate(parts), full_m)
    return measure(machine, table)


def measure(machine: Machine, table: Table) -> Pass:
    """Measure a pass from its truth. Raises BadInput if no ploughing is left to score."""
    plough = machine.scenario.plough
    if plough is None or not table["ploughing"].any():
        raise BadInput(f"{machine.scenario.name}, seed {machine.scenario.seed}: it did not plough")
    travelled = np.cumsum(table["speed_mps"]) * truth.PERIOD_NS * 1e-9
    start = travelled[np.argmax(table["ploughing"])] + SETTLING_M
    if start >= travelled[-1]:
        raise BadInput(f"{machine.scenario.name}, seed {machine.scenario.seed}: it hardly ploughed")
    part = {name: column[travelled >= start] for name, column in table.items()}
    speed, draft = part["speed_mps"], part["draft_n"]
    track_m = 2.0 * float(machine.model.body("rl_wheel").pos[1])
    stiffness = machine.numbers["tyre_rear.stiffness_npm"]
    lower, upper = ("rl", "rr") if plough.furrow == "left" else ("rr", "rl")
    deflection_m = float(np.mean(part[f"load_{lower}_n"] - part[f"load_{upper}_n"])) / stiffness
    depth_m = float(np.mean(part["depth_m"]))
    return Pass(
        speed_kmh=3.6 * float(np.mean(speed)),
        slip=float(np.mean(part["slip"])),
        slip_sd=float(np.std(part["slip"])),
        draft_n=float(np.mean(draft)),
        draft_cv=float(np.std(draft) / np.mean(draft)),
        draft_length_m=correlation_length_m(draft, float(np.mean(speed))),
        draft_over_d497=float(np.mean(draft) / np.mean(d497_n(machine, speed, part["depth_m"]))),
        depth_m=depth_m,
        fuel_lpha=fuel_lpha(machine, part),
        roll_deg=abs(float(np.degrees(np.mean(roll_rad(part))))),
        roll_expected_deg=float(np.degrees(np.arctan((depth_m + deflection_m) / track_m))),
        power_closure=power_closure(table),
        length_m=float(travelled[-1] - start),
    )


def fuel_lpha(machine: Machine, table: Table) -> float:
    """Fuel over the area worked: sum Q dt / (bodies, width of one, sum v dt) [L/ha]."""
    litres = float(np.sum(table["fuel_lph"])) / 3600.0
    hectares = width_m(machine) * float(np.sum(table["speed_mps"])) / 1e4
    return litres / hectares


def width_m(machine: Machine) -> float:
    """Width of the whole plough [m]."""
    return machine.numbers["plough.bodies"] * machine.numbers["plough.body_width_m"]


def d497_n(machine: Machine, speed_mps: Array, depth_m: Array) -> Array:
    """Draft of the whole plough by ASABE D497 [N], shape (n,).

        F (A + C S**2) W T

    F is the soil's draft scale, S the speed [km/h], W the width [m] and T the depth [cm].
    """
    numbers = machine.numbers
    specific = numbers["plough.draft_a"] + numbers["plough.draft_c"] * (3.6 * speed_mps) ** 2
    scale = machine.scenario.soil.resolved.draft_scale
    return np.asarray(scale * specific * width_m(machine) * 100.0 * depth_m)


def correlation_length_m(signal: Array, speed_mps: float) -> float:
    """Distance at which a signal's autocorrelation first falls below 1/e [m]."""
    centred = signal - signal.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlation = np.fft.irfft(spectrum)[: len(centred)]
    lag = int(np.argmax(correlation < correlation[0] / np.e))
    return lag * truth.PERIOD_NS * 1e-9 * speed_mps


def roll_rad(table: Table) -> Array:
    """Roll of the body about its x axis [rad], shape (n,); positive lowers the right side."""
    return quaternion.roll_rad(*(table[name] for name in ("qw", "qx", "qy", "qz")))


def power_closure(table: Table) -> float:
    """(Engine work - losses - change of stored energy) / engine work [-], over the whole table."""
    dt_s = truth.PERIOD_NS * 1e-9
    engine = float(np.sum(table["power_engine_w"])) * dt_s
    lost = sum(float(np.sum(table[f"power_{name}_w"])) for name in LOSSES) * dt_s
    stored = sum(float(table[name][-1] - table[name][0]) for name in ("kinetic_j", "potential_j"))
    return (engine - lost - stored) / engine
