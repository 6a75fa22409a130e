"""What `twin bench` measures: a physics step, speed and memory of a whole run, a study's speed.

Compared figures are measured in turn in one process, and the best of many short stretches counts,
because the machine's other work only ever adds time.
"""

from __future__ import annotations

import pickle
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import mujoco

from twin import sensors
from twin.bench.memory import peak_mb
from twin.camera.tracking import ODOMETRY
from twin.env import speed
from twin.errors import BadInput
from twin.io import run_folder as runfolder
from twin.io.result_rows import Rows, row
from twin.machine.build import Machine
from twin.machine.geometry import geometry
from twin.machine.join import joined
from twin.pipeline.named import load
from twin.pipeline.result import Result
from twin.pipeline.run import run, sense
from twin.plugins.lookup import attribute
from twin.reproduce import ima_pkf_speed
from twin.scenario import Course, Field, Scenario, Soil
from twin.simulation.build import build
from twin.simulation.simulation import Simulation
from twin.streams import Streams

STRETCHES, STEPS = 60, 200
MOST_DECISIONS = 3000
"""Decisions of the driver, a minute, within which a plough must be at its depth."""
RUN = ("run", "plough-25cm", "--quiet", "--estimators", "ratio,four-state", "--out")
COMMAND = """
import sys
from twin.cli import main
assert main(sys.argv[1:]) == 0
"""
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


def rows() -> Rows:
    """All measurements, as rows with their bounds."""
    own = [*step_rows(), *estimator_rows(), *run_rows(), *camera_rows()]
    return [*own, *speed.rows(), *ima_pkf_speed.rows()]


def step_rows(machine: str = Scenario.machine) -> Rows:
    """Time of a step while ploughing, against MuJoCo's own contacts, and of what adds to it."""
    rough = replace(load("scenario", "plough-25cm"), machine=machine)
    grounds = {
        "rough": rough,
        "plane": replace(rough, field=Field()),
        "soil map": replace(load("scenario", "plough-patchy"), machine=machine),
        "bekker": replace(rough, soil=Soil(preset="lete-sand", law="bekker")),
        "brixius": replace(rough, soil=Soil(preset="lete-sand", cone_index_kpa=1200.0)),
    }
    cases = [*(_ploughing(scenario) for scenario in grounds.values()), _native(rough)]
    times = _best(*(partial(mujoco.mj_step, *case, STEPS) for case in cases))
    own_us, plane_us, map_us, bekker_us, brixius_us, native_us = times
    case = "physics step, ploughing, sensors off"
    return [
        row(case, "time with the soil law", own_us, "us"),
        row(case, "time on MuJoCo's own contacts", native_us, "us"),
        row(case, "ratio", own_us / native_us, "1", high=0.8),
        row(case, "time on a height field over a plane's", own_us / plane_us, "1", high=1.2),
        row(case, "the same with a map of two soils", map_us / plane_us, "1"),
        row(case, "time by Bekker-Wong over Brixius'", bekker_us / brixius_us, "1", high=2.0),
    ]


def _ploughing(scenario: Scenario) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A ploughing machine at its depth, sensors off."""
    simulation = Simulation(build(scenario))
    for _ in range(MOST_DECISIONS):
        if simulation.seen["depth_m"][0] >= 0.24:
            break
        simulation.advance()
    else:
        raise BadInput(f"{scenario.facts.name} does not bring its implement to 24 cm")
    model = simulation.batch.get_model(0)
    model.opt.disableflags = NO_SENSORS
    return model, simulation.batch.get_data(0)


def _native(scenario: Scenario) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The machine with its plough as plain MuJoCo has it, settled, then rolling at 1.5 m/s."""
    spec, numbers = joined(scenario.machine_file, scenario.implement_file)
    spec.worldbody.add_geom(
        name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=1, conaffinity=2,
        friction=[0.7, 0.02, 0.01],
    )  # fmt: skip
    spec.compiler.discardvisual = True  # as ours is compiled: looks cost time and change nothing
    model = spec.compile()
    model.opt.disableflags = NO_SENSORS
    state = mujoco.MjData(model)
    mujoco.mj_step(model, state, 2000)
    state.qvel[0] = 1.5
    for wheel in ("fl", "fr", "rl", "rr"):
        axle = "front" if wheel[0] == "f" else "rear"
        radius_m = numbers[f"tyre_{axle}.nominal_rolling_radius_m"]
        state.joint(f"{wheel}_spin").qvel[0] = 1.5 / radius_m
    return model, state


def _best(*actions: Callable[[], None]) -> list[float]:
    """Shortest time of each action per step [us], the actions taken in turn."""
    best = [float("inf")] * len(actions)
    for _ in range(STRETCHES):
        for i, action in enumerate(actions):
            start = time.perf_counter()
            action()
            best[i] = min(best[i], (time.perf_counter() - start) / STEPS * 1e6)
    return best


def estimator_rows() -> Rows:
    """Time of the slip filter per wheel sample, compiled before, and the size of its state."""
    scenario = replace(load("scenario", "plough-25cm"), course=Course(length_m=60.0))
    done = run(scenario, estimators={})
    estimator = load("estimator", "slip-ekf")
    fresh = estimator.init(done.setup)
    state, table = estimator.run(fresh, done.streams)
    best_s = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        estimator.run(fresh, done.streams)
        best_s = min(best_s, time.perf_counter() - start)
    case = "slip-ekf, 50 Hz wheels, 50 Hz IMU, 20 Hz GNSS"
    per_sample_us = best_s / len(table["epoch_ns"]) * 1e6
    state_mb = len(pickle.dumps(state)) / 1e6
    return [
        row(case, "time per wheel sample, its reading included", per_sample_us, "us", high=10.0),
        row(case, "state", state_mb, "MB", high=1.0),
    ]


def run_rows() -> Rows:
    """Speed and memory of a whole run, files written, imports and compiling done before."""
    scenario = load("scenario", "plough-25cm")
    with tempfile.TemporaryDirectory() as folder:
        short = replace(scenario, course=Course(length_m=5.0))
        saved(short, Path(folder) / "first")
        start = time.perf_counter()
        done = saved(scenario, Path(folder) / "second")
        wall_s = time.perf_counter() - start
        simulated_s = float(done.truth["epoch_ns"][-1]) * 1e-9
        recording = Path(folder) / "second" / runfolder.RECORDING
        recording_mb = recording.stat().st_size / 1e6
        recording_s = _recording_s(done, recording)
        own_mb = peak_mb(COMMAND, *RUN, str(Path(folder) / "third"))
    case, over = "plough-25cm, files written", wall_s / (wall_s - recording_s)
    return [
        row(case, "simulated time per wall time", simulated_s / wall_s, "1", low=30.0),
        row(case, "wall time", wall_s, "s"),
        row(case, "peak memory of the command", own_mb, "MB", high=700.0),
        row(case, "time with the recording over that without", over, "1", high=1.3),
        row(case, "recording, for 200 m of ploughing", recording_mb, "MB", high=25.0),
    ]


def saved(scenario: Scenario, directory: Path) -> Result:
    """A run with all its files."""
    done = run(scenario, estimators={n: load("estimator", n) for n in ("ratio", "four-state")})
    done.save(directory)
    return done


def _recording_s(done: Result, path: Path) -> float:
    """Least time in which a run's recording is written."""
    best_s = float("inf")
    for _ in range(3):
        start = time.perf_counter()
        done.record(path)
        best_s = min(best_s, time.perf_counter() - start)
    return best_s


CAMERA_RUN = "slope-9-dry"
FRAME_MS = 15.0
CAMERA_DRIVE = """
import sys
from twin.bench.bench import whole_frames
from twin.simulation.build import build
from twin.pipeline.run import sense
sense(build(whole_frames(float(sys.argv[1]))), ("rl", "rr"), lambda *_: None)
"""


def whole_frames(calibration_m: float, odometry: str = "phase-ecc") -> Scenario:
    """A run on the platform whose camera gives every pixel: 1280 x 800 at 30 frames/s."""
    named: Scenario = load("scenario", CAMERA_RUN)
    camera = named.sensors.camera
    assert camera is not None
    whole = replace(camera, binning=1, odometry=odometry)
    return replace(
        named,
        course=replace(named.course, calibration_m=calibration_m),
        sensors=replace(named.sensors, camera=whole),
    )


def camera_rows() -> Rows:
    """Pace of drawing and odometry together, time of odometry alone, and memory."""
    machine = build(whole_frames(0.0))
    _sense(replace(machine, scenario=replace(machine.scenario, course=Course(length_m=1.0))))
    start = time.perf_counter()
    simulated_s = _sense(machine)
    wall_s = time.perf_counter() - start
    short_mb, long_mb = (peak_mb(CAMERA_DRIVE, str(calibration_m)) for calibration_m in (0.0, 20.0))
    case = f"{CAMERA_RUN}, camera of 1280 x 800 at 30 frames/s"
    return [
        row(case, "simulated time per wall time", simulated_s / wall_s, "1", low=1.0),
        row(case, "odometry of a frame", _odometry_ms(), "ms", high=FRAME_MS),
        row(case, "peak memory", long_mb, "MB", high=1000.0),
        row(case, "peak memory over that of a fifth as long a run", long_mb / short_mb, "1",
            high=1.1),
    ]  # fmt: skip


def _sense(machine: Machine) -> float:
    """Drive a machine with its sensors; the time driven [s]."""
    _, true, *_ = sense(machine, ("rl", "rr"), lambda *_: None)
    return float(true["epoch_ns"][-1] - true["epoch_ns"][0]) * 1e-9


def _odometry_ms() -> float:
    """Median time of a frame's odometry, the frames drawn before."""
    machine = build(whole_frames(0.0, odometry="none"))
    short = replace(machine.scenario, course=Course(length_m=2.0))
    streams, *_ = sense(replace(machine, scenario=short), ("rl", "rr"), lambda *_: None)
    drawn = {} if streams.frames is None else {n: streams.frames[n] for n in streams.frames}
    seen = Streams({n: streams[n] for n in ("camera", "imu")}, drawn)
    odometry = attribute("odometry", ODOMETRY)
    setup = sensors.setup(machine.scenario.sensors, geometry(machine))
    state, times = odometry.init(setup, "phase-ecc"), []
    for chunk in seen.chunks(1):
        start = time.perf_counter()
        state, table = odometry.run(state, chunk)
        if len(table["epoch_ns"]):
            times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)
