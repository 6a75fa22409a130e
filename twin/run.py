"""One run from end to end: machine, sensors, truth, estimators."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from twin import sensors, truth
from twin.machine.build import Machine, build
from twin.machine.driver import FULL_DEPTH
from twin.machine.geometry import geometry
from twin.machine.notes import notes
from twin.machine.route import length_m
from twin.machine.simulate import simulate
from twin.scenario import Scenario
from twin.streams import Setup, Streams, Table, concatenate


class Estimator(Protocol):
    """What consumes streams: a state at the start, then a new state and estimates per chunk."""

    def init(self, setup: Setup) -> Any:
        """State before the first sample."""

    def run(self, state: Any, chunk: Streams) -> tuple[Any, Table]:
        """New state, and what is estimated from the chunk."""


@dataclass(frozen=True)
class Run:
    """What a run produced."""

    scenario: Scenario
    setup: Setup
    streams: Streams
    truth: Table
    estimates: dict[str, Table]
    wall_s: float
    ended: str = "course driven"
    """Why the run ended."""
    notes: tuple[str, ...] = ()
    """Where the run leaves the range in which its soil law was measured, in sentences."""


def run(
    scenario: Scenario,
    *,
    estimators: Mapping[str, Estimator],
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Drive a scenario, sense it, and estimate from what was sensed.

    Args:
        scenario: what is driven, with its seed.
        estimators: by name; each sees the set-up and the streams, nothing else.
        progress: told the fraction of the course driven, from 0 to 1.

    Raises:
        Diverged: the simulation left the finite numbers; its evidence repeats the last second.
    """
    start = time.perf_counter()
    machine = build(scenario)
    nominal = geometry(machine)
    setup = sensors.setup(scenario.sensors, nominal)
    streams, true = sense(machine, nominal.driven, progress or (lambda fraction: None))
    ended = _ended(machine, true)
    estimates = {
        name: estimator.run(estimator.init(setup), streams)[1]
        for name, estimator in estimators.items()
    }
    wall_s = time.perf_counter() - start
    return Run(scenario, setup, streams, true, estimates, wall_s, ended, notes(machine))


def _ended(machine: Machine, true: Table) -> str:
    """Why a run ended: the course driven, a stall, or a depth never reached."""
    course, plough = machine.scenario.course, machine.scenario.plough
    place_w = np.array([true[name][-1] for name in ("east_m", "north_m", "up_m")])
    if course.edge_m is not None:
        return "course driven"  # to the platform's side or to its end
    along_m = float(place_w @ machine.world_from_ground[:, 0])
    if course.passes > 1:
        along_m = float(np.sum(np.abs(true["speed_mps"]))) * truth.PERIOD_NS * 1e-9
    if along_m < length_m(machine.scenario) - 1.0:
        return f"stalled {along_m:.1f} m along the course"
    if plough is not None and not true["ploughing"].any():
        return f"never at {FULL_DEPTH:.0%} of the set depth"
    return "course driven"


def sense(
    machine: Machine, driven: tuple[str, ...], progress: Callable[[float], None]
) -> tuple[Streams, Table]:
    """Drive a machine; what its sensors gave, and the truth."""
    scenario = machine.scenario
    state = sensors.init(scenario.sensors, scenario.seed)
    course_m, driven_m = length_m(scenario), 0.0
    streams, parts = [], []
    for chunk in simulate(machine):
        state, sampled = sensors.sample(scenario.sensors, state, chunk)
        streams.append(sampled)
        parts.append(truth.sample(chunk, driven))
        driven_m += float(np.linalg.norm(chunk["position_w"][-1] - chunk["position_w"][0]))
        progress(min(1.0, driven_m / course_m))
    full_depth_m = None if scenario.plough is None else FULL_DEPTH * scenario.plough.depth_m
    progress(1.0)
    table = truth.integrate(truth.concatenate(parts), full_depth_m)
    return concatenate(streams), {name: np.ascontiguousarray(c) for name, c in table.items()}
