"""The calibration drive before a run, from which an estimator may learn its offsets.

It has two legs on level ground, out and back. A leg here is one drive of the calibration; that of
`twin.scenario.route` is a part of a course. The legs and the run are one recording, paused while
the machine is turned round and moved. In a pause the clocks of the sensors go on, and their samples
are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.machine.build import Machine
from twin.scenario import Course, Driver, Scenario
from twin.simulation.build import build
from twin.simulation.levers import SetLevers
from twin.simulation.simulate import simulate
from twin.streams import Streams
from twin.terrain.maps import ground_maps
from twin.trajectory.trajectory import Trajectory

BACK_DEG = 180.0
"""Heading of the leg back."""
PAUSE_S = 6.0
"""Length of a pause [s]: longer than what any estimator here takes for the same drive."""


def legs(scenario: Scenario) -> tuple[Scenario, ...]:
    """Out and back along a line on level ground of the same soil, the plough left behind."""
    course = scenario.course
    if course.calibration_m <= 0.0:
        return ()
    level = replace(scenario.field, cross_slope_deg=0.0, grade_deg=0.0, patches=())
    return tuple(
        replace(
            scenario,
            field=level,
            plough=None,
            implement=None,
            implement_numbers=None,
            driver=Driver(),
            events=(),
            course=Course(approach_m=0.0, length_m=course.calibration_m, heading_deg=heading_deg),
        )
        for heading_deg in (0.0, BACK_DEG)
    )


def leg_machine(leg: Scenario) -> Machine:
    """The machine of a leg; that back drives on the ground of that out, which lies turned there."""
    if leg.course.heading_deg != BACK_DEG:
        return build(leg)
    maps = {name: grid.turned(leg.course.length_m) for name, grid in ground_maps(leg).items()}
    return build(leg, maps=maps)


@dataclass(frozen=True)
class Leg:
    """A leg of the calibration at its place in the recording."""

    scenario: Scenario
    start_ns: int
    wheel_angle_rad: NDArray[np.float64] | None
    """Offset added to the leg's wheel angles, so that they go on from the last leg's, (4,)."""
    pause: Trajectory
    """Trajectory of the pause after it, in the recording's time."""


@dataclass(frozen=True)
class Recording:
    """The calibration up to where the run begins."""

    legs: tuple[Leg, ...] = ()
    start_ns: int = 0
    """Epoch of the run's first row."""
    wheel_angle_rad: NDArray[np.float64] | None = None
    """Offset added to the run's wheel angles, so that they go on from the last leg's, (4,)."""

    @property
    def pauses_ns(self) -> tuple[tuple[int, int], ...]:
        """First epoch in each pause, and first epoch after it."""
        ends = [leg.start_ns for leg in self.legs[1:]] + [self.start_ns]
        return tuple(
            (int(leg.pause.epoch_ns[0]), end) for leg, end in zip(self.legs, ends, strict=False)
        )

    def chunks(self) -> Iterator[Trajectory]:
        """The calibration's trajectory, contiguous, with its pauses; each call drives it again."""
        for leg in self.legs:
            for chunk in simulate(leg_machine(leg.scenario)):
                yield _shifted(chunk, leg.start_ns, leg.wheel_angle_rad)
            yield leg.pause

    def shifted(self, chunk: Trajectory) -> Trajectory:
        """A chunk of the run at its place in the recording."""
        return _shifted(chunk, self.start_ns, self.wheel_angle_rad)

    def recorded(self, streams: Streams) -> Streams:
        """The streams without the samples whose epoch lies in a pause."""
        if not self.legs:
            return streams
        tables = {}
        for name, table in streams.tables.items():
            epoch_ns = table["epoch_ns"]
            kept = np.ones(len(epoch_ns), bool)
            for first_ns, end_ns in self.pauses_ns:
                kept &= (epoch_ns < first_ns) | (epoch_ns >= end_ns)
            tables[name] = {column: values[kept] for column, values in table.items()}
        return Streams(tables, streams.frames)


def record(machine: Machine, first: Trajectory) -> Recording:
    """The calibration of a machine's scenario, before the run whose first chunk is given.

    Each leg is driven once here, to find when and how it ends. `Recording.chunks` drives it again,
    so that no long trajectory is held in memory.

    Raises:
        Diverged: a state is not finite, or MuJoCo warned.
    """
    driven = [(leg, *_ends(simulate(leg_machine(leg)))) for leg in legs(machine.scenario)]
    found = Recording()
    for number, (scenario, _, last) in enumerate(driven):
        after = driven[number + 1][1] if number + 1 < len(driven) else first
        found = _paused(found, scenario, found.shifted(last), after)
    return found


def _ends(chunks: Iterator[Trajectory]) -> tuple[Trajectory, Trajectory]:
    """The first row of a drive, and its last two."""
    first = last = next(chunks)
    for chunk in chunks:
        last = chunk
    return _copied(first, 0, 1), _copied(last, len(last) - 2, len(last))


def _copied(chunk: Trajectory, start: int, stop: int) -> Trajectory:
    """Some rows, without the rest of the chunk behind them."""
    rows = chunk.cut(start, stop)
    return Trajectory(rows.epoch_ns.copy(), {n: c.copy() for n, c in rows.columns.items()})


def _paused(
    before: Recording, scenario: Scenario, last: Trajectory, after: Trajectory
) -> Recording:
    """The recording with another leg, of which the last rows are given, and the pause behind it."""
    step_ns = int(last.epoch_ns[1] - last.epoch_ns[0])
    count = round(PAUSE_S * 1e9) // step_ns
    first_ns = int(last.epoch_ns[-1]) + step_ns
    end_ns = first_ns + count * step_ns
    angle = last["wheel_angle_rad"][-1] - after["wheel_angle_rad"][0]
    held = _held(last, after, angle, first_ns + step_ns * np.arange(count, dtype=np.int64))
    leg = Leg(scenario, before.start_ns, before.wheel_angle_rad, held)
    return Recording((*before.legs, leg), end_ns, angle)


def _held(
    last: Trajectory, after: Trajectory, angle: NDArray[np.float64], epoch_ns: NDArray[np.int64]
) -> Trajectory:
    """The last row of a leg, then the first of the next, which lets the filters settle on it."""
    half = len(epoch_ns) // 2
    sides = (last.cut(len(last) - 1, len(last)), _shifted(after.cut(0, 1), 0, angle))
    columns = {
        name: np.concatenate(
            [np.repeat(sides[0][name], half, 0), np.repeat(sides[1][name], len(epoch_ns) - half, 0)]
        )
        for name in last.columns
    }
    return Trajectory(epoch_ns, columns)


def _shifted(
    chunk: Trajectory, by_ns: int, wheel_angle_rad: NDArray[np.float64] | None
) -> Trajectory:
    columns = dict(chunk.columns)
    if wheel_angle_rad is not None:
        columns["wheel_angle_rad"] = columns["wheel_angle_rad"] + wheel_angle_rad
    end = chunk.end
    if end is not None:
        end = replace(end, time_s=end.time_s + by_ns * 1e-9)
    return Trajectory(chunk.epoch_ns + by_ns, columns, end)


def run_chunks(
    machine: Machine, set_levers: SetLevers | None = None
) -> tuple[Recording, Iterator[Trajectory]]:
    """Drive the calibration before a run, in which a controller may set the levers.

    Returns:
        The calibration, and an iterator over the run's chunks, shifted in time to start after it.
        A scenario without a calibration gives an empty Recording and unshifted chunks.

    Raises:
        Diverged: a state is not finite, or MuJoCo warned.
    """
    chunks = simulate(machine, set_levers=set_levers)
    if not legs(machine.scenario):
        return Recording(), chunks
    first = next(chunks)
    found = record(machine, first)

    def own() -> Iterator[Trajectory]:
        yield found.shifted(first)
        for chunk in chunks:
            yield found.shifted(chunk)

    return found, own()
