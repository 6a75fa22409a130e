"""The drawbar rig: the tractor pulls loads that are held while it runs steadily, on the level."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.errors import BadInput, check_range
from twin.physics.block import MachineSlot, WheelSlot
from twin.rig.defaults import HITCH_M, STEP_N
from twin.rig.table import Measured
from twin.rig.tractor import Slots, drive, mean, statics, tractor
from twin.rig.tyre import Tyre
from twin.rig.wheel import towed, wheel
from twin.scenario import Drive, Soil
from twin.simulation.simulation import DECISION_S, Simulation
from twin.vehicle import Machine, files
from twin.vehicle.numerics import machine_facts

Array = NDArray[np.float64]

ROLLING_S = 4.0
"""Time in which the tractor gets up to its speed before it is loaded [s]."""
SETTLING_S, HOLD_S = 1.0, 5.0
"""Time before a point, and time over which it is averaged, the pull held [s]."""
STEADY = 2e-3
"""Most that speed and slip may change from one half of a hold to the other: speed relative to
itself. What the tractor then stores or gives back is below 0.3 % of its power."""
MOST_HOLDS = 4
"""How many times a load is held until speed and slip are steady."""
STANDING_MPS = 0.1
LIFTED_N = 500.0
ITERATIONS = 5
"""Iterations of loads and forces in the closed form; each gains about a digit."""


@dataclass(frozen=True, kw_only=True)
class DrawbarCurve(Measured):
    """Measurements of the drawbar rig, one value per load. Shape (n,)."""

    pull_n: Array
    slip: Array
    """Mean of the rear wheels, (w R - v) / max(|w R|, |v|)."""
    front_slip: Array
    """Mean slip of the front wheels, likewise."""
    speed_mps: Array
    front_load_n: Array
    rear_load_n: Array
    axle_torque_nm: Array
    """Torque of the gearbox on the rear axle."""
    front_pull_n: Array
    """Shear less resistance of the front wheels, below 0 where they are towed."""
    engine_rpm: Array
    crank_power_w: Array
    """Torque times speed of the engine."""

    @property
    def drawbar_power_w(self) -> Array:
        """Pull times speed."""
        return self.pull_n * self.speed_mps

    def columns(self) -> dict[str, Array]:
        """Everything measured and derived, by name."""
        return super().columns() | {"drawbar_power_w": self.drawbar_power_w}


def drawbar(
    soil: Soil,
    *,
    hitch_m: float | None = None,
    first_n: float | None = None,
    step_n: float | None = None,
    most_slip: float = 0.40,
    gear: Drive | None = None,
    machine: str | Machine = files.USUAL,
) -> DrawbarCurve:
    """Pull of a tractor over slip, under constant loads, differential locked if it can be.

    The pull is horizontal, against the course. A load acts for 1 s and is then measured over 5 s.
    If speed or slip differs between the two halves of the 5 s, they are repeated, so that stored
    energy does not count as work. The test ends at `most_slip`, where the tractor does not hold a
    load, or where its front axle lifts.

    Args:
        soil: what lies under it, the same everywhere.
        hitch_m: height of the pull above the ground; None for 0.45 m, and no higher than the rear
            axle of a small machine.
        first_n: the first load [N]; None for a step.
        step_n: load from one point to the next [N]; None for 500 N, and no more than a hundredth of
            the weight.
        most_slip: slip at which the test ends.
        gear: gear, governor setting and driven axles; None for the machine's usual ones.
        machine: a name of `twin list`, a file, or what a file holds.

    Raises:
        UnknownName: there is no such machine.
        OutOfRange: an argument outside what can be tested.
        BadInput: the test ended with fewer than three points, too few for a curve.
    """
    own = usual(machine)
    height_m = _height_m(own, hitch_m)
    first_n = (step_n or own.step_n) if first_n is None else first_n
    step_n = own.step_n if step_n is None else step_n
    check_range("step_n", step_n, min(100.0, own.step_n), 5000.0)
    check_range("first_n", first_n, min(100.0, own.step_n), 50e3)
    check_range("most_slip", most_slip, 0.05, 0.9)
    simulation = Simulation(tractor("rig-drawbar", soil, gear=gear, machine=machine))
    drive(simulation, ROLLING_S)
    points: list[tuple[float, ...]] = []
    while not points or points[-1][1] < most_slip:
        pull_n = first_n + step_n * len(points)
        held = _held(simulation, height_m, pull_n, own.lifted_n)
        if held is None:
            break
        points.append((pull_n, *_read(held)))
    if len(points) < 3:
        raise BadInput(f"the tractor does not pull {first_n + 2.0 * step_n:g} N on this soil")
    return _curve(points)


def pulled(
    soil: Soil,
    pulls_n: Sequence[float],
    *,
    hitch_m: float | None = None,
    gear: Drive | None = None,
    machine: str | Machine = files.USUAL,
) -> DrawbarCurve:
    """Given pulls, in the given order; each is held until speed and slip are steady.

    Args:
        soil, hitch_m, gear, machine: as for `drawbar`.
        pulls_n: pulls [N], n of them.

    Raises:
        OutOfRange: a height outside what can be tested.
        BadInput: no pull is given; or one stops the tractor, lifts its front axle or does not
            become steady.
    """
    if not len(pulls_n):
        raise BadInput("pulls_n is empty; give at least one pull [N]")
    own = usual(machine)
    height_m = _height_m(own, hitch_m)
    simulation = Simulation(tractor("rig-drawbar", soil, gear=gear, machine=machine))
    drive(simulation, ROLLING_S)
    points = []
    for pull_n in pulls_n:
        held = _held(simulation, height_m, pull_n, own.lifted_n)
        if held is None:
            raise BadInput(f"the tractor does not hold {pull_n:g} N on this soil")
        points.append((pull_n, *_read(held)))
    return _curve(points)


@dataclass(frozen=True)
class Usual:
    """Sizes of a test that suit a machine."""

    hitch_m: float
    step_n: float
    lifted_n: float
    """Load of the front axle below which it lifts."""


def usual(machine: str | Machine) -> Usual:
    """Height, step and least front load of a test, by the sizes of a machine."""
    known = files.machine(machine) if isinstance(machine, str) else machine
    numbers = machine_facts(known).numbers
    loads = (numbers[f"tyre_{axle}.nominal_load_n"] for axle in ("front", "rear"))
    hundredth_n = 0.01 * 2.0 * sum(loads)
    radius_m = 0.5 * numbers["tyre_rear.diameter_m"]
    return Usual(min(HITCH_M, radius_m), min(STEP_N, hundredth_n), min(LIFTED_N, hundredth_n))


def _height_m(own: Usual, hitch_m: float | None) -> float:
    """Height of the pull above the ground, checked."""
    height_m = own.hitch_m if hitch_m is None else hitch_m
    check_range("hitch_m", height_m, 0.1, 1.2)
    return height_m


def _curve(points: list[tuple[float, ...]]) -> DrawbarCurve:
    pull, slip, speed, front, rear, torque, rpm, crank, front_slip, front_pull = np.array(points).T
    return DrawbarCurve(
        pull_n=pull, slip=slip, speed_mps=speed, front_load_n=front, rear_load_n=rear,
        axle_torque_nm=torque, engine_rpm=rpm, crank_power_w=crank, front_slip=front_slip,
        front_pull_n=front_pull,
    )  # fmt: skip


def _held(simulation: Simulation, hitch_m: float, pull_n: float, lifted_n: float) -> Slots | None:
    """The mean over a hold that is steady; None for a load that the tractor does not hold."""
    _drawn(simulation, hitch_m, pull_n, SETTLING_S)
    for _ in range(MOST_HOLDS):
        first, second = (_drawn(simulation, hitch_m, pull_n, 0.5 * HOLD_S) for _ in range(2))
        before, after = _read(first), _read(second)
        speed_mps, front_n = after[1], after[2]
        if speed_mps < STANDING_MPS or front_n < lifted_n:
            return None
        if abs(speed_mps - before[1]) < STEADY * speed_mps and abs(after[0] - before[0]) < STEADY:
            return mean([first, second])
    return None


def _drawn(simulation: Simulation, hitch_m: float, pull_n: float, seconds: float) -> Slots:
    """Drive on against a pull; the mean. Its line is kept while the body pitches."""
    reported = []
    for _ in range(round(seconds / DECISION_S)):
        _pull(simulation, hitch_m, pull_n)
        reported += drive(simulation, DECISION_S)
    return mean(reported)


def _read(slots: Slots) -> tuple[float, ...]:
    """Slip, speed, loads, axle torque, engine speed and power; slip and pull of the front."""
    front, rear, load, machine = (
        slots.wheels[:2],
        slots.wheels[2:],
        slots.wheels[:, WheelSlot.LOAD_N],
        slots.machine,
    )
    engine_radps = float(machine[MachineSlot.ENGINE_RADPS])
    return (
        float(rear[:, WheelSlot.SLIP].mean()),
        float(rear[:, WheelSlot.SPEED_X_MPS].mean()),
        float(load[:2].sum()),
        float(load[2:].sum()),
        float(machine[MachineSlot.AXLE_TORQUE_NM]),
        engine_radps * 30.0 / np.pi,
        engine_radps * float(machine[MachineSlot.ENGINE_TORQUE_NM]),
        float(front[:, WheelSlot.SLIP].mean()),
        float((front[:, WheelSlot.SHEAR_X_N] - front[:, WheelSlot.RESISTANCE_N]).sum()),
    )


def _pull(simulation: Simulation, hitch_m: float, pull_n: float) -> None:
    """A horizontal force against the course (the world's x), its line through the body's middle."""
    body = simulation.machine.model.body("tractor").id
    height_m = simulation.batch.bind("xipos")[0, body, 2]
    force = simulation.batch.bind("xfrc_applied")
    force[0, body, 0] = -pull_n
    force[0, body, 4] = -pull_n * (hitch_m - height_m)


def expected_pull_n(
    soil: Soil, slip: ArrayLike, *, hitch_m: float | None = None, machine: str = files.USUAL
) -> Array:
    """Pull at given slips of the driven rear axle, by the wheel rig and statics. Shape (n,).

    Moments about the rear hubs, with the wheels' forces at their hubs and the axle torque T:

        N_f = (x_cg W - (h - z_r) P + (z_f - z_r) F_f - T) / L        N_r = W - N_f
        P   = N_r NTR(s, N_r / 2) + F_f

    F_f < 0 is the towed front wheels'. Height of the centre of gravity does not count on the level.
    """
    hitch_m = usual(machine).hitch_m if hitch_m is None else hitch_m
    slips, body = np.atleast_1d(np.asarray(slip, dtype=np.float64)), statics(soil, machine)
    rear_tyre, front_tyre = (Tyre(machine=machine, axle=axle) for axle in ("rear", "front"))
    rear_n = np.full(slips.shape, body.weight_n * (1.0 - body.cg_ahead_m / body.wheelbase_m))
    pull_n = np.zeros(slips.shape)
    for _ in range(ITERATIONS):
        driven = wheel(rear_tyre, soil, slip=slips, load_n=0.5 * rear_n)
        front = towed(front_tyre, soil, load_n=0.5 * (body.weight_n - rear_n))
        front_n = 2.0 * front.net_pull_n
        pull_n = 2.0 * driven.net_pull_n + front_n
        moment = (
            body.cg_ahead_m * body.weight_n
            - (hitch_m - body.rear_hub_m) * pull_n
            + (body.front_hub_m - body.rear_hub_m) * front_n
            - 2.0 * driven.axle_torque_nm
        )
        rear_n = body.weight_n - moment / body.wheelbase_m
    return pull_n
