"""Where episodes begin: keyframes of tractors that roll steadily, the plough carried."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.compute import quaternion
from twin.env.fleet import Fleet, GroundFrame, Start, lift_rad
from twin.env.grounds import GroundShape
from twin.env.kept_starts import kept
from twin.env.levers import RAISED_M
from twin.machine.build import Machine
from twin.machine.start import RAISED_RAD
from twin.simulation.columns import Recorder

Array = NDArray[np.float64]

SETTLE_S, APPROACH_S = 4.0, 2.0
"""Time rolled before anything is seen, and time rolled before an episode that sensors see."""
MOST_KEPT = 256


class Starts:
    """The starts of a machine by how the field lies, each settled once."""

    def __init__(
        self,
        machine: Machine,
        shapes: Sequence[GroundShape],
        *,
        seen: bool,
        nthread: int = 1,
        kind: type[Fleet] = Fleet,
    ) -> None:
        """Those of the shapes are read from disk where they were settled before."""
        self.machine, self.seen, self.nthread, self.kind = machine, seen, nthread, kind
        starts = kept(machine, shapes, seen, kind, partial(self._settled, shapes))
        self.known = dict(zip(shapes, starts, strict=True))

    def of(self, shapes: Sequence[GroundShape]) -> list[Start]:
        """A start for each shape; those not known yet are settled side by side."""
        new = [shape for shape in dict.fromkeys(shapes) if shape not in self.known]
        if new:
            self.known |= dict(zip(new, self._settled(new), strict=True))
        found = [self.known[shape] for shape in shapes]
        while len(self.known) > MOST_KEPT:
            self.known.popitem()
        return found

    def _settled(self, shapes: Sequence[GroundShape]) -> list[Start]:
        return settle(self.machine, shapes, self.seen, self.nthread, self.kind)


def settle(
    machine: Machine,
    shapes: Sequence[GroundShape],
    seen: bool,
    nthread: int = 1,
    kind: type[Fleet] = Fleet,
) -> list[Start]:
    """Roll until everything has settled, a plough carried, and on for the approach.

    Args:
        machine: built on level ground.
        shapes: how the field lies under each tractor.
        seen: keep the approach.
        nthread: threads to roll on.
        kind: how the machine is driven.
    """
    fleet = kind(machine, len(shapes), nthread, sensed=seen)
    frames = stand(fleet, shapes)
    for _ in range(round(SETTLE_S / fleet.period_s)):
        fleet.drive(fleet.steady(), record=False)
    steps = round(APPROACH_S / fleet.period_s)
    records = [fleet.drive(fleet.steady(), record=seen) for _ in range(steps)]
    starts = []
    for i, frame in enumerate(frames):
        approach = None
        if seen:
            recorder = Recorder(machine)
            recorder.normal = frame.world_from_ground[:, 2]
            kept = [r for r in records if r is not None]
            own = {k: np.concatenate([r[k][i : i + 1] for r in kept], axis=1) for k in kept[0]}
            approach = recorder.sensed(own)
        start = Start(
            state=fleet.state[i].copy(),
            frame=frame,
            approach=approach,
            along_m=float(fleet.qpos[i, :3] @ frame.world_from_ground[:, 0]),
            driver=fleet.drivers[i].copy(),
            pedal=fleet.pedals[i].copy(),
            action=tuple(fleet.steady()[i].tolist()),
        )
        starts.append(start)
    return starts


def stand(fleet: Fleet, shapes: Sequence[GroundShape]) -> list[GroundFrame]:
    """Stand each tractor, settled on level ground, on a slope of its own, and let it roll."""
    machine = fleet.machine
    frames = [GroundFrame.of(shape, machine.scenario.course) for shape in shapes]
    for i, (frame, shape) in enumerate(zip(frames, shapes, strict=True)):
        fleet.lay(i, frame, shape.furrow_depth_m)
    fleet.start_rolling()
    for i, frame in enumerate(frames):
        fleet.qpos[i, :3] = frame.world_from_ground @ machine.start_qpos[:3]
        fleet.qpos[i, 3:7] = quaternion.multiplied(frame.quaternion, machine.start_qpos[3:7])
    if machine.hitch is not None:
        fleet.drivers["lift_rad"] = max(RAISED_RAD, float(lift_rad(machine, RAISED_M)))
    return frames
