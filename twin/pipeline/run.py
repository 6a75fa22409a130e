"""One run from end to end: machine, sensors, truth, estimators."""

from __future__ import annotations

import itertools
import time
from collections import ChainMap
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from twin import sensors
from twin.errors import BadInput
from twin.io.spool import Spool
from twin.machine.build import Machine
from twin.machine.geometry import geometry
from twin.pipeline.estimating import Estimator, all_estimates
from twin.pipeline.result import Measured, Result
from twin.pipeline.unread import refuse_unread
from twin.plugins.failing import failing
from twin.plugins.percent import percent_note
from twin.scenario import Scenario
from twin.scenario.route import length_m
from twin.sensors import Sensors
from twin.simulation import calibration
from twin.simulation.build import build
from twin.simulation.course_task import asked_mps
from twin.simulation.driver import full_depth_m
from twin.simulation.levers import Controlled, SetLevers
from twin.simulation.notes import notes, unheld
from twin.simulation.operator import operated
from twin.streams import Frames, Setup, Streams, Table, concatenate
from twin.trajectory.end import End
from twin.truth import truth

if TYPE_CHECKING:
    from twin.camera.tracking import Tracker

Progress = Callable[[float, float], None]
"""Called with the share of the course driven, 0 to 1, and the time driven [s]."""
KEPT_EVERY = 10
"""One in this many of the camera's frames is saved."""


def run(
    scenario: Scenario | Measured,
    *,
    estimators: Mapping[str, Estimator],
    progress: Progress | None = None,
    frames: Path | None = None,
    controlled: Controlled | None = None,
) -> Result:
    """Result of a simulated drive: measurements, truth, and estimates from the measurements.

    Args:
        scenario: the scenario, with its random seed.
        estimators: name -> estimator; an estimator gets only the set-up and the streams.
        progress: called with the driven share of the course, 0 to 1, and the driven time [s].
        frames: folder where the camera's frames are saved as PNG.
        controlled: controller of throttle and hitch in work; None for the driver.

    Raises:
        BadInput: a field is set that the run does not read, or the scenario's own signals fail. An
            estimator that fails raises nothing: it gives NaN and a note.
        Diverged: a value of the simulation became NaN or too large.
    """
    start = time.perf_counter()
    end, said, kept = None, tuple[str, ...](), None
    refuse_unread(scenario)
    if isinstance(scenario, Scenario):
        scenario = scenario.with_numbers()
        machine = build(scenario)
        nominal = geometry(machine)
        setup = sensors.setup(scenario.sensors, nominal)
        set_levers = None if controlled is None else controlled.start(machine)
        streams, true, kept, ends = sense(
            machine, nominal.driven, progress or _silent, frames, set_levers
        )
        *before, end = ends
        said = notes(machine)
        if controlled is not None:
            said += (f"throttle and hitch in work were set by controller '{controlled.name}'",)
        elif not operated(scenario):  # else gears and throttle change on the way
            said += unheld(asked_mps(machine), true)
        said += tuple(f"calibration: {leg}" for leg in before if not leg.as_planned)
    else:
        if controlled is not None:
            raise BadInput(
                f"controller '{controlled.name}': scenario '{scenario.name}' has signals alone, "
                "and no machine to drive"
            )
        setup, streams, true = _measured(scenario)
        odd = percent_note("slip of the truth", true, streams)
        said = () if odd is None else (odd,)
    done = all_estimates(estimators, setup, streams)
    start_ns = int(true["epoch_ns"][0])
    return Result(
        scenario,
        setup,
        streams,
        true,
        {name: _of_the_run(table, start_ns) for name, table in done.tables.items()},
        wall_s=time.perf_counter() - start,
        end=end,
        frames=kept,
        notes=(*said, *done.notes),
        failed=done.failed,
    )


def _measured(scenario: Measured) -> tuple[Setup, Streams, Table]:
    """The signals of a scenario without a machine. Raises BadInput where they cannot be had."""
    with failing(f"scenario '{scenario.name}': measure", scenario):
        setup, streams, true = scenario.measure()
    return setup, streams, true


def _silent(fraction: float, driven_s: float) -> None:
    """No-op progress callback."""


def sense(
    machine: Machine,
    driven: tuple[str, ...],
    progress: Progress,
    frames: Path | None = None,
    set_levers: SetLevers | None = None,
) -> tuple[Streams, Table, Frames | None, list[End]]:
    """Measurements and truth of a simulated drive, which starts with the calibration.

    Args:
        machine: the simulated machine.
        driven: names of the driven wheels.
        progress: called with the driven share of the course, 0 to 1, and the driven time [s].
        frames: folder where the camera's frames are saved as PNG.
        set_levers: function that sets throttle and hitch in work; None for the driver.

    Returns:
        Measurements of the sensors, truth of the run, a few camera frames, and the ends of the
        legs of the calibration and, last, of the run.
    """
    scenario = machine.scenario
    recording, run_chunks = calibration.run_chunks(machine, set_levers)
    fitted = sensors.faults_from(scenario.sensors, recording.start_ns * 1e-9)
    state = sensors.init(fitted, scenario.seed)
    tracker = _tracker(fitted, machine, frames)
    course_m, driven_m, driven_s = length_m(scenario), 0.0, 0.0
    tables, framed, rows = dict[str, Spool](), list[Streams](), Spool()
    kept, ends = list[Frames](), list[End]()
    with ThreadPoolExecutor(1) as pool:
        for chunk in itertools.chain(recording.chunks(), run_chunks):
            state, sampled = sensors.sample(fitted, state, chunk)
            if sampled.frames is not None and chunk.epoch_ns[0] >= recording.start_ns:
                kept += _few(sampled.frames)
            sampled = recording.recorded(sampled)
            if tracker is not None:
                tracker, sampled = tracker.track(sampled, pool)
            for name, table in sampled.tables.items():
                tables.setdefault(name, Spool()).append(table)
            if sampled.frames is not None:
                framed.append(Streams({}, sampled.frames))
            if chunk.end is not None:
                ends.append(chunk.end)
            if chunk.epoch_ns[0] >= recording.start_ns:
                rows.append(truth.sample(chunk, driven))
                place_w = chunk["position_w"]
                driven_m += float(np.linalg.norm(place_w[-1] - place_w[0]))
                driven_s = float(chunk.epoch_ns[-1] - recording.start_ns) * 1e-9
                progress(min(1.0, driven_m / course_m), driven_s)
    plough = scenario.plough
    least_m = scenario.shallowest_m
    full_m = None if plough is None or least_m is None else full_depth_m(least_m, plough.hitch)
    progress(1.0, driven_s)
    table = truth.integrate(rows.table(), full_m)
    true = {name: np.ascontiguousarray(c) for name, c in table.items()}
    shown = ChainMap(*kept) if kept else None  # type: ignore[arg-type,var-annotated]
    streams = {name: spool.table() for name, spool in tables.items()}
    return Streams(streams, concatenate(framed).frames), true, shown, ends


def _tracker(fitted: Sensors, machine: Machine, frames: Path | None) -> Tracker | None:
    camera = fitted.camera
    if camera is None:
        return None
    from twin.camera import tracking  # slow to import, and few runs have a camera

    setup = sensors.setup(fitted, geometry(machine))
    return tracking.tracker(setup, camera.odometry, camera.processing_s, frames)


def _few(frames: Frames) -> list[Frames]:
    """Some of the frames that were drawn; none of others."""
    from twin.camera.frames import DrawnFrames

    return [frames.every(KEPT_EVERY)] if isinstance(frames, DrawnFrames) else []


def _of_the_run(estimates: Table, start_ns: int) -> Table:
    """Estimates from the run's first instant on: what was said in the calibration is no result."""
    kept = estimates["epoch_ns"] >= start_ns
    return {name: column[kept] for name, column in estimates.items()}
