"""The drawbar rig: the tractor pulls a load that grows slowly, on level ground."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twin.errors import BadInput, check_range
from twin.machine.simulate import DECISION_S, Cab
from twin.physics.block import MachineSlot, WheelSlot
from twin.rig.tractor import drive, mean, statics, tractor
from twin.rig.tyre import Tyre
from twin.rig.wheel import towed, wheel
from twin.scenario import Soil

Array = NDArray[np.float64]

HITCH_M = 0.45
"""Height of the pull above the ground [m]: that of a drawbar; assumed."""
ROLLING_S = 4.0
"""Time in which the tractor gets up to its speed before it is loaded [s]."""
POINT_S = 1.0
"""Time over which one point is averaged [s]: a few bounces."""
RAMP_NPS = 100.0
"""Growth of the pull [N/s]; at 30 % slip the tractor's inertia then hides 0.3 % of it."""
STANDING_MPS = 0.1
LIFTED_N = 500.0
ITERATIONS = 5
"""Of loads and forces in the closed form; each gains about a digit."""


@dataclass(frozen=True, kw_only=True)
class DrawbarCurve:
    """What the drawbar rig measured, one value per second of the ramp. Shape (n,)."""

    pull_n: Array
    slip: Array
    """Mean of the rear wheels, (w R - v) / max(|w R|, |v|)."""
    speed_mps: Array
    front_load_n: Array
    rear_load_n: Array
    axle_torque_nm: Array
    """What the gears give the rear axle."""

    @property
    def drawbar_power_w(self) -> Array:
        """Pull times speed."""
        return self.pull_n * self.speed_mps

    def columns(self) -> dict[str, Array]:
        """Everything measured and derived, by name."""
        measured = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return measured | {"drawbar_power_w": self.drawbar_power_w}


def drawbar(
    soil: Soil, *, hitch_m: float = HITCH_M, ramp_nps: float = RAMP_NPS, most_slip: float = 0.40
) -> DrawbarCurve:
    """Pull against slip of the tractor by a load ramp; rear-wheel drive, differential locked.

    The pull is horizontal, against the course, and grows so slowly that inertia does not count.
    The test ends at `most_slip`, or where the tractor stalls or its front axle lifts.

    Args:
        soil: what lies under it, the same everywhere.
        hitch_m: height of the pull above the ground.
        ramp_nps: growth of the pull [N/s].
        most_slip: slip at which the test ends.

    Raises:
        OutOfRange: an argument outside what can be tested.
        BadInput: the tractor cannot pull at all on this soil.
    """
    check_range("hitch_m", hitch_m, 0.1, 1.2)
    check_range("ramp_nps", ramp_nps, 20.0, 1000.0)
    check_range("most_slip", most_slip, 0.05, 0.9)
    cab = Cab(tractor("rig-drawbar", soil))
    drive(cab, ROLLING_S)
    points: list[tuple[float, ...]] = []
    while not points or _goes_on(points[-1], most_slip):
        points.append(_point(cab, hitch_m, ramp_nps, POINT_S * len(points)))
    if len(points) < 3:
        raise BadInput(f"the tractor does not pull {ramp_nps * POINT_S:g} N on this soil")
    pull, slip, speed, front, rear, torque = np.array(points).T
    return DrawbarCurve(
        pull_n=pull, slip=slip, speed_mps=speed, front_load_n=front, rear_load_n=rear,
        axle_torque_nm=torque,
    )  # fmt: skip


def _point(cab: Cab, hitch_m: float, ramp_nps: float, start_s: float) -> tuple[float, ...]:
    """Drive one point of the ramp; pull, slip, speed, front and rear load, axle torque."""
    decisions = round(POINT_S / DECISION_S)
    times = start_s + DECISION_S * np.arange(1, decisions + 1)
    seen = []
    for time_s in times:
        _pull(cab, hitch_m, ramp_nps * float(time_s))
        seen += drive(cab, DECISION_S)
    average = mean(seen)
    rear, load = average.wheels[2:], average.wheels[:, WheelSlot.LOAD_N]
    return (
        float(ramp_nps * times.mean()),
        float(rear[:, WheelSlot.SLIP].mean()),
        float(rear[:, WheelSlot.SPEED_X_MPS].mean()),
        float(load[:2].sum()),
        float(load[2:].sum()),
        float(average.machine[MachineSlot.AXLE_TORQUE_NM]),
    )


def _goes_on(point: tuple[float, ...], most_slip: float) -> bool:
    _, slip, speed, front, _, _ = point
    return slip < most_slip and speed > STANDING_MPS and front > LIFTED_N


def _pull(cab: Cab, hitch_m: float, pull_n: float) -> None:
    """A horizontal force against the course (the world's x), its line through the body's middle."""
    body = cab.machine.model.body("tractor").id
    height_m = cab.batch.bind("xipos")[0, body, 2]
    force = cab.batch.bind("xfrc_applied")
    force[0, body, 0] = -pull_n
    force[0, body, 4] = -pull_n * (hitch_m - height_m)


def expected_pull_n(soil: Soil, slip: ArrayLike, *, hitch_m: float = HITCH_M) -> Array:
    """Pull at given slips of the rear axle, by the wheel rig and the tractor's statics. Shape (n,).

    Moments about the rear hubs, with the wheels' forces at their hubs and the axle torque T:

        N_f = (x_cg W - (h - z_r) P + (z_f - z_r) F_f - T) / L        N_r = W - N_f
        P   = N_r NTR(s, N_r / 2) + F_f

    F_f < 0 is the towed front wheels'. Height of the centre of gravity does not count on the level.
    """
    slips, body = np.atleast_1d(np.asarray(slip, dtype=np.float64)), statics(soil)
    rear_n = np.full(slips.shape, body.weight_n * (1.0 - body.cg_ahead_m / body.wheelbase_m))
    pull_n = np.zeros(slips.shape)
    for _ in range(ITERATIONS):
        driven = wheel(Tyre(axle="rear"), soil, slip=slips, load_n=0.5 * rear_n)
        front = towed(Tyre(axle="front"), soil, load_n=0.5 * (body.weight_n - rear_n))
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
