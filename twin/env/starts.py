"""Where episodes begin: keyframes of tractors that roll steadily, the plough carried."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.env.fleet import RAISED_M, Axes, Fleet, Start, lift_rad
from twin.env.grounds import Lie
from twin.machine.build import Machine
from twin.machine.ground_frame import quaternion
from twin.machine.start import RAISED_RAD
from twin.physics import block
from twin.simulation.braking import Foot
from twin.simulation.columns import Recorder

Array = NDArray[np.float64]

SETTLE_S, APPROACH_S = 4.0, 2.0
"""Time rolled before anything is seen, and time rolled before an episode that sensors see."""
MOST_KEPT = 256


class Starts:
    """The starts of a machine by how the field lies, each settled once."""

    def __init__(
        self, machine: Machine, *, seen: bool, nthread: int = 1, kind: type[Fleet] = Fleet
    ) -> None:
        self.machine, self.seen, self.nthread, self.kind = machine, seen, nthread, kind
        self.known: dict[Lie, Start] = {}

    def of(self, lies: Sequence[Lie]) -> list[Start]:
        """A start for each lie; those not known yet are settled side by side."""
        new = [lie for lie in dict.fromkeys(lies) if lie not in self.known]
        if new:
            settled = settle(self.machine, new, self.seen, self.nthread, self.kind)
            self.known |= dict(zip(new, settled, strict=True))
        found = [self.known[lie] for lie in lies]
        while len(self.known) > MOST_KEPT:
            self.known.popitem()
        return found


def settle(
    machine: Machine,
    lies: Sequence[Lie],
    seen: bool,
    nthread: int = 1,
    kind: type[Fleet] = Fleet,
) -> list[Start]:
    """Roll until everything has settled, a plough carried, and on for the approach.

    Args:
        machine: built on level ground.
        lies: how the field lies under each tractor.
        seen: keep the approach.
        nthread: threads to roll on.
        kind: how the machine is driven.
    """
    fleet = kind(machine, len(lies), nthread)
    axes = [Axes.of(lie, machine.scenario.course) for lie in lies]
    for i, lie in enumerate(lies):
        fleet.lay(i, axes[i], lie.furrow_depth_m)
        _place(fleet, i)
    for _ in range(round(SETTLE_S / fleet.period_s)):
        fleet.drive(fleet.rolling(), record=False)
    steps = round(APPROACH_S / fleet.period_s)
    records = [fleet.drive(fleet.rolling(), record=seen) for _ in range(steps)]
    starts = []
    for i in range(len(lies)):
        approach = None
        if seen:
            recorder = Recorder(machine)
            recorder.normal = fleet.world_from_ground[i, :, 2]
            own = [{k: v[i : i + 1] for k, v in r.items()} for r in records if r is not None]
            approach = recorder.trajectory(own)
        along_m = float(fleet.qpos[i, :3] @ fleet.world_from_ground[i, :, 0])
        foot = Foot(*(float(value[i]) for value in vars(fleet.foot).values()))
        place = along_m, float(fleet.steer_rad[i]), float(fleet.lift_rad[i]), foot
        first, second = fleet.rolling()[i].tolist()
        state = fleet.batch.state[i].copy()
        starts.append(Start(state, axes[i], approach, *place, (first, second)))
    return starts


def _place(fleet: Fleet, i: int) -> None:
    """Stand a tractor, settled on level ground, on its slope and let it roll."""
    machine, rotation = fleet.machine, fleet.world_from_ground[i]
    model, speed = machine.model, machine.start_speed_mps
    fleet.qpos[i], fleet.batch.bind("act")[i] = machine.start_qpos, machine.start_act
    fleet.qpos[i, :3] = rotation @ machine.start_qpos[:3]
    fleet.qpos[i, 3:7] = _times(quaternion(rotation), machine.start_qpos[3:7])
    fleet.qvel[i, :3] = rotation @ np.array([speed, 0.0, 0.0])
    for wheel in block.WHEELS:
        axle = "front" if wheel[0] == "f" else "rear"
        radius_m = machine.numbers[f"tyre_{axle}.free_rolling_radius_m"]
        fleet.qvel[i, model.joint(f"{wheel}_spin").dofadr[0]] = speed / radius_m
    rear_m = machine.numbers["tyre_rear.free_rolling_radius_m"]
    fleet.qvel[i, model.joint("drive").dofadr[0]] = speed / rear_m
    if machine.hitch is not None:
        fleet.lift_rad[i] = max(RAISED_RAD, float(lift_rad(machine, RAISED_M)))


def _times(p: Array, q: Array) -> Array:
    """Product of two quaternions wxyz."""
    a, b, c, d = p
    w, x, y, z = q
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )
